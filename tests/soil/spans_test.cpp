// The multi-level heightfield (Tables 1 to 3) against the oracle.
#include "oracle/spans.h"

#include "stage_scenario.h"

namespace bsoil::spans_test {
namespace {

using namespace layout;

class Spans : public Stage {};

TEST_P(Spans, follow_the_oracle) {
    StageBench& bench = prepared(Backend::cpu);
    bench.build_spans();
    const oracle::Field field = bench.to_field(bench.read());
    const oracle::Model model = bench.model();
    oracle::Field bare = field;  // of bodies and what they carry
    field.for_each([&](int x, int y, int z) {
        bare.at(x, y, z).bodies = 0;
        bare.at(x, y, z).support = {};
    });
    const std::vector<oracle::Body> bodies = bench.oracle_bodies();
    bool lost = false;
    int carried_count = 0, bare_count = 0, covered_count = 0;
    for (int y = 0; y < field.ny; ++y) {
        for (int x = 0; x < field.nx; ++x) {
            SCOPED_TRACE(testing::Message() << "column " << x << " " << y);
            std::vector<oracle::Span> all = oracle::height_spans(model, field, x, y);
            const std::vector<int32_t> got = bench.read_column(x, y);
            const size_t kept = std::min<size_t>(all.size(), kSpanCapacity);
            lost = lost || all.size() > kept;
            // The uppermost ones.
            const std::vector<oracle::Span> expected(all.end() - static_cast<std::ptrdiff_t>(kept),
                                                     all.end());
            ASSERT_EQ(got[0], static_cast<int>(kept));
            for (size_t i = 0; i < kept; ++i) {
                // Sums of the same integers, exact in doubles too.
                EXPECT_EQ(got[1 + i * kSpanWords], expected[i].bottom * kVoxelFull) << "span " << i;
                EXPECT_EQ(got[2 + i * kSpanWords], expected[i].top * kVoxelFull) << "span " << i;
                using Kind = oracle::Span::Kind;
                EXPECT_EQ(got[3 + i * kSpanWords], expected[i].kind == Kind::rigid   ? kSpanRigid
                                                   : expected[i].kind == Kind::piled ? kSpanPiled
                                                                                     : kSpanFalling)
                    << "span " << i;
                const int base = oracle::base_of(model, field, bodies, expected[i], x, y);
                const bool is_free = base >= 0 && oracle::is_top_free(field, expected[i], x, y);
                EXPECT_EQ(got[kColumnBase + i / 2] >> (i % 2 * 16) & 0xffff,
                          base + 1 + (is_free ? kBaseFree : 0))
                    << "span " << i;
                carried_count += base >= 0;
            }
            using Kind = oracle::FreeSurface::Kind;
            oracle::FreeSurface surface = oracle::free_surface(model, field, all, x, y);
            const bool covered = surface.kind == Kind::covered;
            if (covered) {
                // Roofs hang without the bodies too.
                for (const oracle::Span& span : all) {
                    const int z = static_cast<int>(span.bottom);
                    if (span.kind != oracle::Span::Kind::piled || z == 0 ||
                        field.at(x, y, z - 1).psi() >= model.solid_coverage) {
                        continue;
                    }
                    bare.at(x, y, z).support = field.at(x, y, z).support;
                }
                surface = oracle::free_surface(model, bare, oracle::height_spans(model, bare, x, y),
                                               x, y);
            }
            const double height = surface.height * kVoxelFull;
            EXPECT_EQ(bench.read_surface(x, y), surface.kind == Kind::bare ? kTerrainTop - height
                                                : covered                  ? kCovered - height
                                                                           : height);
            bare_count += surface.kind == Kind::bare;
            covered_count += covered;
        }
    }
    EXPECT_EQ((bench.result_status() & kStatusSpansFull) != 0, lost);
    EXPECT_GT(carried_count, 0);
    EXPECT_GT(bare_count, 0);
    EXPECT_GT(covered_count, 0);
}

TEST_P(Spans, have_the_same_bits_on_gl) {
    expect_same_on_gl([](StageBench& bench) {
        bench.build_spans();
        std::vector<int32_t> words;
        for (int y = 0; y < GetParam().ny; ++y) {
            for (int x = 0; x < GetParam().nx; ++x) {
                const std::vector<int32_t> column = bench.read_column(x, y);
                words.insert(words.end(), column.begin(),
                             column.begin() + 1 + column[0] * kSpanWords);
                for (int i = 0; i < column[0]; ++i) {
                    words.push_back(column[kColumnBase + i / 2] >> (i % 2 * 16) & 0xffff);
                }
                words.push_back(bench.read_surface(x, y));
            }
        }
        return words;
    });
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Spans, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::spans_test
