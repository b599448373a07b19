// Moved soil that is compacted regains cohesion: docs/decisions/compacted_soil.md
#include "bank_case.h"
#include "soil/slip_table.h"
#include "temporary_file.h"

namespace bsoil::compacted_soil_test {
namespace {

using namespace bank_test;

/// Clay whose fills are as loose as dug clay is.
MaterialDef dug_clay() {
    MaterialDef clay = materials::clay();
    clay.density_kg_m3 = clay.loose_density_kg_m3;
    clay.compaction_cohesion_ratio = 0.1;
    return clay;
}

// By hand: 0.1 of 1 kPa loose, of 32 kPa half way, and all that it had (20 kPa) before 1 MPa.
TEST(RegainedCohesion, is_a_share_of_the_pressure_that_belongs_to_the_density) {
    SoilDef def = grid_def(8, 8, 8, 0.1);
    def.material = dug_clay();
    const MaterialDef& m = def.material;
    const std::vector<int32_t> loose(layout::kTableWords, 0);
    const std::vector<int32_t> words = regained_strengths(m, def, loose.data());
    const auto cohesion_pa = [&](size_t entry, double density_kg_m3) {
        return words[entry] / 65536.0 * density_kg_m3 * def.gravity_m_s2 * def.voxel_m;
    };
    EXPECT_NEAR(cohesion_pa(0, 1440), 100, 0.2);
    EXPECT_NEAR(cohesion_pa(16, 2 / (1 / 1440.0 + 1 / 2150.0)), 3162, 1);
    EXPECT_NEAR(cohesion_pa(32, 2150), 20000, 1);
    MaterialDef off = m;
    off.compaction_cohesion_ratio = 0;
    for (int32_t word : regained_strengths(off, def, loose.data())) EXPECT_EQ(word, 0);
}

TEST(RegainedCohesion, needs_densities) {
    SoilDef def = grid_def(8, 8, 8);
    def.material.compaction_cohesion_ratio = 0.1;
    const Status status = def.validate();
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().find("compaction_cohesion_ratio"), std::string::npos)
        << status.error();
}

class CompactedBank : public testing::TestWithParam<BankCase> {};

// Moved soil stands to Culmann's height for the cohesion that belongs to its density, 1 kPa here,
// and not to that of soil that was never moved, which has five times as much.
TEST_P(CompactedBank, stands_below_its_critical_height_and_fails_above) {
    BankCase bank = GetParam();
    const double moved_pa = bank.cohesion_pa;
    bank.cohesion_pa *= 5;
    bank.compaction_ratio = 0.1;  // so that its density changes
    const MaterialDef m = bank.material();
    bank.compaction_ratio =
        moved_pa / pressure_of_relative_density(m.relative_density(m.density_kg_m3));
    const bool is_wall = bank.face_deg == 90;
    for (const bool stands : {true, false}) {
        const double share = stands ? (is_wall ? 0.9 : 0.85) : (is_wall ? 1.1 : 1.15);
        auto soil = make_bank(bank, share / 5, 1.2);
        ASSERT_TRUE(soil);
        soil->step({});
        loosen(*soil);
        const uint64_t checksum = soil->checksum();
        const int64_t units = soil->totals().units[0];
        for (int i = 0; i < 300; ++i) soil->step({});  // 5 s
        EXPECT_EQ(soil->checksum() == checksum, stands);
        EXPECT_EQ(soil->totals().units[0], units);
        EXPECT_EQ(soil->status_bits(), 0u);
    }
}

std::vector<BankCase> bank_cases() {
    std::vector<BankCase> cases;
    for (double yaw : {0.0, 22.5, 45.0}) {
        for (double face : {90.0, 60.0}) cases.push_back({1000, 16000, face, 0.1, yaw});
        cases.push_back({1000, 16000, 90, 0.05, yaw});
    }
    cases.push_back({1000, 16000, 60, 0.05, 0});
    cases.push_back({1000, 16000, 90, 0.025, 0});
    return cases;
}
INSTANTIATE_TEST_SUITE_P(Banks, CompactedBank, testing::ValuesIn(bank_cases()),
                         testing::PrintToStringParamName());

/// Dug clay between two boards, 16 voxels apart, put in by lifts.
class BoxOfClay {
  public:
    static constexpr double kVoxel = 0.05;

    BoxOfClay() {
        SoilDef def = grid_def(32, 8, 16, kVoxel);
        def.material = dug_clay();
        soil_ = make_soil(def);
        for (const double x : {7.0, 25.0}) {
            boards_.emplace_back(static_cast<int>(boards_.size()),
                                 box_shape(Vec3{1, 8, 8} * kVoxel), Vec3{x, 4, 8} * kVoxel, true);
        }
        boards_.emplace_back(2, box_shape(Vec3{8, 8, 1} * kVoxel), Vec3{16, 4, 15} * kVoxel);
        boards_[2].body.contact_pressure_pa = 300e3;
    }
    Soil& soil() { return *soil_; }

    /// Clay up to `top` voxels; tamped: down from there to `down` voxels by a plate that presses
    /// with 300 kPa.
    void add_lift(double top, double down) {
        ASSERT_TRUE(soil_->fill(voxel_box(*soil_, {8, 0, 0}, {24, 8, top})));
        step(boards_.data(), 2);
        loosen(*soil_);
        if (down >= top) return;
        Mover& plate = boards_[2];
        plate.body.pose.position.z = (top + 1) * kVoxel;
        plate.set_velocity({0, 0, -kVoxel / 16 * 60});
        for (int i = 0; i < 16 * (top - down); ++i) {
            plate.advance(1.0 / 60);
            step(boards_.data(), 3);
        }
        plate.set_velocity({0, 0, 3 * kVoxel});
        for (int i = 0; i < 20; ++i) {
            plate.advance(1.0 / 60);
            step(boards_.data(), 3);
        }
    }
    /// Without boards.
    void stand(int steps) {
        for (int i = 0; i < steps; ++i) soil_->step({});
    }
    /// Of all clay, where it stands as a block between the boards' places.
    double density_kg_m3() const {
        return soil_->totals().mass_kg[0] / (16 * 8 * kVoxel * kVoxel * rim_m());
    }
    /// Mean height of the outermost two voxels of the clay that stood between the boards.
    double rim_m() const {
        double sum = 0;
        for (int x : {8, 9, 22, 23}) sum += soil_->surface_height_m(x, 4);
        return sum / 4;
    }

  private:
    void step(const Mover* movers, int count) {
        std::vector<SoilBody> bodies;
        for (int i = 0; i < count; ++i) bodies.push_back(movers[i].body);
        soil_->step(bodies);
    }
    std::unique_ptr<Soil> soil_;
    std::vector<Mover> boards_;
};

// By hand: loose clay has 0.1 kPa and stands as a wall to 0.04 m. Lifts of 5 cm tamped by 1 cm, and
// the next filled up on them, are a fifth denser, half way from loose to compacted: 3 kPa carry a
// wall of 0.9 m.
TEST(DugClay, that_was_tamped_stands_where_loose_clay_falls) {
    BoxOfClay tamped, loose;
    for (int lift = 0; lift < 8; ++lift) {
        tamped.add_lift(lift + 1, lift + 0.8);
        if (HasFatalFailure()) return;
    }
    loose.add_lift(8, 8);
    for (BoxOfClay* box : {&tamped, &loose}) {
        const bool stands = box == &tamped;
        const double before = box->rim_m();
        const int64_t units = box->soil().totals().units[0];
        const MaterialDef clay = dug_clay();
        const double density = clay.relative_density(box->density_kg_m3());
        EXPECT_NEAR(density, stands ? 0.5 : 0, 0.03);
        const BankCase wall{clay.compaction_cohesion_ratio * pressure_of_relative_density(density),
                            box->density_kg_m3() * kGravity,
                            90,
                            0.05,
                            0,
                            20};
        EXPECT_EQ(before < wall.critical_m(), stands);
        box->stand(600);
        RecordProperty(stands ? "tamped" : "loose",
                       std::to_string(before) + " to " + std::to_string(box->rim_m()));
        if (stands) {
            EXPECT_GT(box->rim_m(), before - 0.1 * BoxOfClay::kVoxel);
        } else {
            EXPECT_LT(box->rim_m(), 0.75 * before);
        }
        EXPECT_EQ(box->soil().totals().units[0], units);
        EXPECT_EQ(box->soil().status_bits(), 0u);
    }
}

TEST(DugClay, goes_on_from_a_snapshot_bit_for_bit) {
    BoxOfClay box;
    box.add_lift(1, 0.8);
    box.add_lift(8, 8);
    const TemporaryFile file("dug_clay.snapshot");
    for (int part = 0; part < 4; ++part) {
        box.stand(3);
        Soil& soil = box.soil();
        ASSERT_TRUE(soil.save(file.path()));
        SoilDef def = soil.def();
        def.thread_count = 3;
        auto twin = make_soil(def);
        ASSERT_TRUE(twin->load(file.path()));
        for (int i = 0; i < 20; ++i) {
            soil.step({});
            twin->step({});
            ASSERT_EQ(soil.checksum(), twin->checksum()) << "part " << part << ", step " << i;
        }
    }
}

}  // namespace
}  // namespace bsoil::compacted_soil_test
