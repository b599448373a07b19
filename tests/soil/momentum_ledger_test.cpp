// Where the soil's momentum comes from and goes to: gravity, bodies, ground. As whole numbers.
#include <array>

#include "flow_fixture.h"
#include "moving_scene.h"

namespace bsoil::momentum_ledger_test {
namespace {

using namespace layout;

using Momentum = std::array<int64_t, 3>;  // along the grid's axes, units of the planes

Momentum momentum_of(Soil& soil) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    Momentum sum{};
    TileVoxels voxels;
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        if (!impl.tiles[index]) continue;
        impl.tiles.read_voxels(static_cast<int>(index), voxels);
        for (int z = 0; z < impl.height; ++z) {
            for (int c = 0; c < kTileColumns; ++c) {
                for (int axis = 0; axis < 3; ++axis) {
                    sum[static_cast<size_t>(axis)] += voxels.at(kKeptMomentum + axis, z, c);
                }
            }
        }
    }
    return sum;
}

/// Of the last step: what the soil should have gained, and how much bodies gave.
struct Ledger {
    Momentum gained{}, given{};
};

Ledger ledger_of(Soil& soil) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    Ledger out;
    if (impl.is_quiet) return out;
    const std::span<const int32_t> header = impl.results.header();
    for (size_t axis = 0; axis < 3; ++axis) {
        for (size_t b = 0; b < impl.bodies.ids().size(); ++b) {
            out.given[axis] +=
                wide_sum(&header[kResultHeader + b * kLoadWords + kLoadImpulse + 2 * axis]);
        }
        out.gained[axis] = wide_sum(&header[kResultFallen + 2 * axis]) + out.given[axis] -
                           wide_sum(&header[kResultGround + 2 * axis]);
    }
    return out;
}

/// Steps and checks: returns in how many steps bodies gave the soil momentum.
template <typename Step>
int expect_closed(Soil& soil, int steps, Step&& step) {
    Momentum before = momentum_of(soil);
    int given_count = 0;
    for (int i = 0; i < steps; ++i) {
        step();
        const Momentum now = momentum_of(soil);
        const Ledger ledger = ledger_of(soil);
        for (size_t axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(now[axis] - before[axis], ledger.gained[axis])
                << "step " << i << ", " << axis;
        }
        given_count += ledger.given != Momentum{};
        before = now;
        if (testing::Test::HasFailure()) break;
    }
    return given_count;
}

class MomentumLedger : public testing::TestWithParam<Backend> {
  protected:
    void SetUp() override {
        if (GetParam() == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
    }
    SoilDef with_backend(SoilDef def) const {
        def.backend = GetParam();
        return def;
    }
    int steps(int on_cpu, int on_gl) const { return GetParam() == Backend::gl ? on_gl : on_cpu; }
};

TEST_P(MomentumLedger, closes_while_bodies_plough_through_soil_that_falls) {
    MovingScene scene(3, with_backend(MovingScene::default_def()));
    const int count = steps(80, 10);
    EXPECT_GT(expect_closed(scene.soil(), count, [&] { scene.step(); }), count / 2);
}

TEST_P(MomentumLedger, closes_where_slides_have_momentum) {
    SoilDef def = with_backend(MovingScene::default_def());
    def.slides = SlideMotion::run_out;
    MovingScene scene(5, def);
    const int count = steps(80, 10);
    EXPECT_GT(expect_closed(scene.soil(), count, [&] { scene.step(); }), count / 8);
}

// Soil pours onto a tray that drives away, falls off it, and a sink takes some.
TEST_P(MomentumLedger, closes_between_a_source_a_tray_and_a_sink) {
    const auto soil = make_soil(with_backend(flow_def()));
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->add_source(pipe(60)));
    ASSERT_TRUE(soil->add_sink(box_sink({0.2, 0.2, 0}, {2.2, 2.2, 0.3})));
    std::vector<Mover> movers;
    movers.emplace_back(4, box_shape({0.3, 0.3, 0.06}), Vec3{1.0, 1.2, 0.6});
    movers.back().set_velocity({0.5, 0.1, 0});
    const double step_s = soil->def().step_s;
    const int given_count = expect_closed(*soil, steps(80, 30), [&] {
        movers.back().advance(step_s);
        soil->step(bodies_of(movers));
    });
    EXPECT_GT(given_count, steps(80, 30) / 8);
}

INSTANTIATE_TEST_SUITE_P(Backends, MomentumLedger, testing::Values(Backend::cpu, Backend::gl),
                         [](const auto& tested) {
                             return tested.param == Backend::cpu ? "cpu" : "gl";
                         });

// Soil falls 0.6 m onto a tray at rest: it stops it with m sqrt(2 g h), and bears no more then.
// Soil rests from up to a voxel above the tray on, which is 4 % of its momentum.
TEST(BodyImpulse, of_a_tray_is_what_stops_the_soil_that_falls_on_it) {
    const auto soil = make_soil(grid_def(32, 32, 32));
    ASSERT_TRUE(soil);
    std::vector<Mover> movers;
    movers.emplace_back(2, box_shape({0.6, 0.6, 0.1}), Vec3{0.8, 0.8, 0.3});
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {13, 13, 20}, {19, 19, 24})));
    const double mass_kg = soil->totals().mass_kg[0];
    Vec3 impulse_n_s;
    double load_kg = 0;
    for (int i = 0; i < 90; ++i) {
        const StepReport report = soil->step(bodies_of(movers));
        for (const BodyLoad& load : report.loads) {
            ASSERT_EQ(load.body, 2);
            impulse_n_s += load.impulse_n_s;
            load_kg = load.mass_kg;
        }
    }
    EXPECT_NEAR(load_kg, mass_kg, 0.01 * mass_kg);
    // The lower face of the soil is at 1 m, the upper one of the tray at 0.4 m.
    const double speed_m_s = std::sqrt(2 * soil->def().gravity_m_s2 * 0.6);
    EXPECT_NEAR(impulse_n_s.z, mass_kg * speed_m_s, 0.042 * mass_kg * speed_m_s);
    EXPECT_NEAR(impulse_n_s.x, 0, 0.01 * mass_kg * speed_m_s);
    EXPECT_NEAR(impulse_n_s.y, 0, 0.01 * mass_kg * speed_m_s);
}

}  // namespace
}  // namespace bsoil::momentum_ledger_test
