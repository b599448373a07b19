// The multi-level heightfield (Tables 1 to 3) against the oracle.
#include "oracle/spans.h"

#include <set>

#include "stage_scenario.h"

namespace bsoil::spans_test {
namespace {

using namespace layout;

class Spans : public Stage {};

struct Compared {
    size_t lost_count = 0;
    int carried_count = 0;
};

/// The kernel keeps a column's uppermost spans.
Compared expect_kept(const StageBench& bench, const oracle::Field& field,
                     const std::vector<oracle::Body>& bodies, const std::vector<oracle::Span>& all,
                     int x, int y) {
    using Kind = oracle::Span::Kind;
    const oracle::Model model = bench.model();
    const std::vector<int32_t> got = bench.read_column(x, y);
    const size_t kept = std::min<size_t>(all.size(), kSpanCapacity);
    Compared out{all.size() - kept};
    EXPECT_EQ(got[0], static_cast<int>(kept));
    for (size_t i = 0; i < kept; ++i) {
        const oracle::Span& expected = all[out.lost_count + i];
        // Sums of the same integers, exact in doubles too.
        EXPECT_EQ(got[1 + i * kSpanWords], expected.bottom * kVoxelFull) << "span " << i;
        EXPECT_EQ(got[2 + i * kSpanWords], expected.top * kVoxelFull) << "span " << i;
        EXPECT_EQ(got[3 + i * kSpanWords], expected.kind == Kind::rigid   ? kSpanRigid
                                           : expected.kind == Kind::piled ? kSpanPiled
                                                                          : kSpanFalling)
            << "span " << i;
        const int base = oracle::base_of(model, field, bodies, expected, x, y);
        const bool is_free = base >= 0 && oracle::is_top_free(field, expected, x, y);
        EXPECT_EQ(got[kColumnBase + i / 2] >> (i % 2 * 16) & 0xffff,
                  base + 1 + (is_free ? kBaseFree : 0))
            << "span " << i;
        out.carried_count += base >= 0;
    }
    return out;
}

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
            const std::vector<oracle::Span> all = oracle::height_spans(model, field, x, y);
            const Compared compared = expect_kept(bench, field, bodies, all, x, y);
            lost = lost || compared.lost_count > 0;
            carried_count += compared.carried_count;
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

/// Plates over one another with soil between: from column to column one more.
std::vector<std::vector<int32_t>> columns_of_plates(Backend backend) {
    constexpr int kPlates = 14;
    SoilDef def = grid_def(16, 16, 64);
    def.backend = backend;
    StageBench bench(def);
    StatePlanes planes = bench.empty_planes();
    std::vector<Mover> movers;
    const auto is_body = [](int plate) { return plate == 7 || plate == 9 || plate == 11; };
    for (int i = 0; i < kPlates; ++i) {
        const double voxel = bench.soil().frame().voxel_m, width = 16 - i;
        if (!is_body(i)) continue;
        movers.emplace_back(static_cast<int>(movers.size()), box_shape(Vec3{width, 16, 1} * voxel),
                            Vec3{i + width / 2, 8, 4 * i + 2.5} * voxel, i == 9);
    }
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
            const int plates = std::min(x + 1, kPlates), top = 4 * plates - 1;
            for (int z = 0; z < 4 * plates + 7; ++z) {
                const bool is_plate = z % 4 == 2 && z / 4 < plates;
                if (is_plate && !is_body(z / 4)) planes.at(kPlaneTerrain, x, y, z) = kVoxelFull;
                // On every second row soil falls on the top one.
                const bool falls = y % 2 == 0 && z > top + 3;
                if (is_plate || (z >= top && !falls)) continue;
                planes.at(kPlaneVolume, x, y, z) = planes.at(kPlaneMaterial, x, y, z) = kVoxelFull;
            }
        }
    }
    bench.write(planes);
    bench.place(movers);
    bench.find_support();
    bench.build_spans();
    std::vector<std::vector<int32_t>> words;
    const oracle::Field field = bench.to_field(bench.read());
    std::set<size_t> lost;
    int carried_count = 0;
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
            SCOPED_TRACE(testing::Message() << "column " << x << " " << y);
            const auto all = oracle::height_spans(bench.model(), field, x, y);
            const Compared compared = expect_kept(bench, field, bench.oracle_bodies(), all, x, y);
            lost.insert(compared.lost_count);
            carried_count += compared.carried_count;
            words.push_back(bench.read_column(x, y));
        }
    }
    EXPECT_GE(lost.size(), 8u);  // even numbers and odd ones
    EXPECT_TRUE(lost.contains(1) && lost.contains(2)) << testing::PrintToString(lost);
    EXPECT_GT(carried_count, 100);
    EXPECT_NE(bench.result_status() & kStatusSpansFull, 0u);
    return words;
}

TEST(FullColumns, keep_their_uppermost_spans) {
    const auto words = columns_of_plates(Backend::cpu);
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    EXPECT_EQ(columns_of_plates(Backend::gl), words);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Spans, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::spans_test
