// Soil that bodies push moves off with the speed of the push: docs/decisions/pushed_soil.md.
#include <numbers>

#include "ploughed_bed.h"

namespace bsoil::pushed_soil_test {
namespace {

constexpr double kFriction = 0.600861;  // tan 31 deg, of the sand below

/// All of a soil's momentum [N s], and the height up to which there is any soil to speak of.
struct Motion {
    Vec3 momentum_n_s;
    double top_m = 0;
};

Motion motion_of(Soil& soil) {
    Motion out;
    Soil::Impl& impl = SoilProbe::impl(soil);
    const double voxel_m = impl.frame.voxel_m;
    const double unit = 2000 * std::pow(voxel_m, 3) / layout::kVoxelFull / layout::kVelocityOne *
                        voxel_m / soil.def().step_s;
    TileVoxels voxels;
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        if (!impl.tiles[index]) continue;
        impl.tiles.read_voxels(static_cast<int>(index), voxels);
        for (int z = 0; z < impl.height; ++z) {
            for (int c = 0; c < layout::kTileColumns; ++c) {
                const auto along = [&](int axis) {
                    return static_cast<double>(voxels.at(kKeptMomentum + axis, z, c));
                };
                out.momentum_n_s += unit * Vec3{along(0), along(1), along(2)};
                const bool is_soil = voxels.at(kKeptVolume, z, c) > layout::kVoxelFull / 100;
                if (is_soil) out.top_m = std::max(out.top_m, (z + 1) * voxel_m);
            }
        }
    }
    return out;
}

std::unique_ptr<Soil> bed(const SoilDef& def, double depth_m) {
    auto soil = make_soil(def);
    const auto& size = soil->frame().size;
    const Vec3 high{static_cast<double>(size[0]), static_cast<double>(size[1]),
                    depth_m / def.voxel_m};
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, high)));
    EXPECT_TRUE(soil->settle(10));
    return soil;
}

/// Mean height [m] of a bed's surface above `depth_m`, between two distances across.
double height_at(const Soil& soil, double x_m, double low_y_m, double high_y_m, double depth_m) {
    const double voxel_m = soil.frame().voxel_m;
    const auto column = [&](double at_m) { return static_cast<int>(std::lround(at_m / voxel_m)); };
    double sum = 0;
    for (int y = column(low_y_m); y < column(high_y_m); ++y) {
        sum += soil.surface_height_m(column(x_m), y) - depth_m;
    }
    return sum / (column(high_y_m) - column(low_y_m));
}

/// A blade 1 m wide cuts a bed 0.1 m deep for 1.5 m, and stops at once.
struct Cut {
    double momentum_n_s = 0;  ///< of the soil as the blade stops
    double heap_kg = 0;       ///< of a metre of blade, before it in the end
    double middle_m = 0;      ///< of the heap in the end, from the blade on
    double end_m = 0;
    double after_n_s = 0;  ///< a second later
};

Cut cut(double speed_m_s, double rate_hz, SlideMotion slides) {
    constexpr double kDepth = 0.3, kWay = 1.5, kFace = 2.06, kVoxel = 0.05;
    SoilDef def = grid_def(112, 32, 32, kVoxel);
    def.material = sand(31);
    def.step_s = 1 / rate_hz;
    def.slides = slides;
    const auto soil = bed(def, kDepth);
    Mover blade(1, box_shape({0.06, 0.5, 0.3}), {kFace - 0.06 - kWay, 0.8, 0.5});
    blade.set_velocity({speed_m_s, 0, 0});
    Cut out;
    const auto run = [&](double time_s) {
        for (int i = 0; i < static_cast<int>(std::lround(time_s * rate_hz)); ++i) {
            blade.advance(def.step_s);
            soil->step({&blade.body, 1});
        }
    };
    run(kWay / speed_m_s);
    out.momentum_n_s = motion_of(*soil).momentum_n_s.x;
    blade.set_velocity({});
    run(1.2);
    out.after_n_s = length(motion_of(*soil).momentum_n_s);
    run(0.8);
    double volume = 0;
    for (double x = kFace + 0.5 * kVoxel; x < 5.5; x += kVoxel) {
        const double height = height_at(*soil, x, 0.4, 1.2, kDepth);
        if (height > 0.005) out.end_m = x - kFace;
        volume += height * kVoxel;
        out.middle_m += height * kVoxel * (x - kFace);
    }
    out.middle_m /= volume;
    out.heap_kg = volume * def.material.density_kg_m3;
    return out;
}

double stopping_way(double speed_m_s) { return speed_m_s * speed_m_s / (2 * 9.81 * kFriction); }

// By hand the whole heap goes as fast as the blade. In the grid what moves up its slope does not.
TEST(PushedSoil, has_the_blades_speed_and_goes_on_when_it_stops) {
    const Cut slow = cut(0.5, 60, SlideMotion::run_out);
    for (const double speed : {2.0, 4.0}) {
        const Cut fast = cut(speed, 60, SlideMotion::run_out);
        EXPECT_GT(fast.momentum_n_s, 0.6 * fast.heap_kg * speed) << speed;
        EXPECT_LT(fast.momentum_n_s, 1.0 * fast.heap_kg * speed) << speed;
        EXPECT_GT(fast.middle_m - slow.middle_m, 0.5 * stopping_way(speed)) << speed;
        EXPECT_LT(fast.middle_m - slow.middle_m, 1.1 * stopping_way(speed)) << speed;
        EXPECT_LT(fast.after_n_s, 0.01 * fast.momentum_n_s) << speed;
    }
}

TEST(PushedSoil, goes_as_far_with_half_the_step) {
    const Cut whole = cut(4, 60, SlideMotion::run_out), half = cut(4, 120, SlideMotion::run_out);
    EXPECT_NEAR(half.momentum_n_s, whole.momentum_n_s, 0.15 * whole.momentum_n_s);
    EXPECT_NEAR(half.middle_m, whole.middle_m, 0.15 * whole.middle_m);
}

// Where slides settle, so does what is pushed: no heap goes on.
TEST(PushedSoil, rests_where_slides_settle) {
    const Cut slow = cut(0.5, 60, SlideMotion::settle), fast = cut(4, 60, SlideMotion::settle);
    EXPECT_LT(fast.middle_m, slow.middle_m + 0.15 * stopping_way(4));
    EXPECT_LT(fast.after_n_s, 0.001);
}

// Six paddles on an axle, their tips at 4.7 m/s, are let down 0.1 m into a bed.
TEST(PushedSoil, is_thrown_backwards_by_a_wheel_that_spins) {
    SoilDef def = grid_def(80, 32, 32);
    def.material = sand(31);
    def.slides = SlideMotion::run_out;
    const auto soil = bed(def, 0.4);
    Mover wheel(1, round_shape(ConvexShape::Kind::cylinder, 0.3, 0.1), {2.5, 0.8, 0.77});
    for (int k = 0; k < 6; ++k) {
        wheel.shapes.push_back(box_shape({0.35, 0.025, 0.1}));
        wheel.shapes.back().local.rotation = turn({0, 0, 1}, k * std::numbers::pi / 6);
    }
    wheel.body.pose.rotation = turn({1, 0, 0}, std::numbers::pi / 2);
    double back_n_s = 0, front_n_s = 0;
    for (int i = 0; i < 120; ++i) {
        const bool spins = i < 60;
        wheel.set_velocity({0, 0, spins && wheel.body.pose.position.z > 0.65 ? -0.3 : 0},
                           {0, spins ? 4 / 0.3 : 0, 0});
        wheel.advance(def.step_s);
        soil->step({&wheel.body, 1});
        const double momentum_n_s = motion_of(*soil).momentum_n_s.x;
        back_n_s = std::min(back_n_s, momentum_n_s);
        front_n_s = std::max(front_n_s, momentum_n_s);
    }
    EXPECT_LT(front_n_s, -0.1 * back_n_s);
    double behind = 0, before = 0;  // sums of heights more than half a metre from the axle
    for (double x = 0.5; x < 2; x += def.voxel_m) behind += height_at(*soil, x, 0.5, 1.1, 0.4);
    for (double x = 3; x < 4; x += def.voxel_m) before += height_at(*soil, x, 0.5, 1.1, 0.4);
    const double behind_kg = behind * def.voxel_m * 0.6 * def.material.density_kg_m3;
    EXPECT_GT(behind_kg, 1);
    // What flies has the momentum "rate times distance", however steeply it is thrown. The paddles
    // throw from where they touch the bed until they are let down. They leave it 0.25 m behind.
    const double rate_kg_s = behind_kg / (0.1 / 0.3), distance_m = 0.5 - 0.25;
    EXPECT_LT(back_n_s, -rate_kg_s * distance_m);
    EXPECT_LT(before, 0.1 * behind);
}

// A ball comes down at 4 m/s and stops in the bed. What gives way goes out at 45 deg - phi / 2 with
// up to its speed, so up to 0.26 m high, all around alike. A top is known to a voxel, and what
// flies is spread over one more.
TEST(PushedSoil, splashes_around_a_ball_that_falls_in) {
    for (const double speed : {0.5, 4.0}) {
        SoilDef def = grid_def(64, 64, 32);
        def.material = sand(31);
        def.slides = SlideMotion::run_out;
        const auto soil = bed(def, 0.4);
        Mover ball(1, sphere_shape(0.2), {1.6, 1.6, 0.7});
        double top_m = 0, aside_n_s = 0, most_n_s = 0;
        for (int i = 0; i < static_cast<int>(0.2 / speed * 60) + 40; ++i) {
            ball.set_velocity({0, 0, ball.body.pose.position.z > 0.5 ? -speed : 0});
            ball.advance(def.step_s);
            soil->step({&ball.body, 1});
            const Motion motion = motion_of(*soil);
            top_m = std::max(top_m, motion.top_m);
            aside_n_s = std::max(
                {aside_n_s, std::abs(motion.momentum_n_s.x), std::abs(motion.momentum_n_s.y)});
            most_n_s = std::max(most_n_s, motion.momentum_n_s.z);
        }
        EXPECT_LE(aside_n_s, 0.02 * most_n_s + 0.01) << speed;
        if (speed < 1) {
            EXPECT_LE(top_m, 0.4 + 2 * def.voxel_m);
            EXPECT_LT(most_n_s, 0.1);
        } else {
            EXPECT_GE(top_m, 0.4 + 0.15);
            EXPECT_LE(top_m, 0.4 + 0.26 + 2 * def.voxel_m);
            EXPECT_GT(most_n_s, 4);
        }
    }
}

// What makes room for a body that is put into a bed is moved far in one step, and by no push.
TEST(PushedSoil, is_none_where_a_body_is_put_into_a_bed) {
    SoilDef def = grid_def(64, 32, 32);
    def.material = sand(31);
    def.slides = SlideMotion::run_out;
    const auto soil = bed(def, 0.6);
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape({0.05, 0.05, 0.05}), Vec3{0.5, 0.8, 1.3});
    movers.back().set_velocity({4, 0, 0});  // a fast one, in the air
    for (int i = 0; i < 30; ++i) {
        if (i == 5) {
            movers.emplace_back(2, box_shape({0.2, 0.2, 0.2}), Vec3{1.6, 0.8, 0.45});
            movers.back().set_velocity({0.1, 0, 0});
        }
        for (Mover& mover : movers) mover.advance(def.step_s);
        soil->step(bodies_of(movers));
        EXPECT_LE(motion_of(*soil).momentum_n_s.z, 1) << i;
    }
}

TEST(PushedSoil, has_the_same_bits_on_threads_on_gl_and_from_a_snapshot) {
    expect_same_bits(
        [](Backend backend, int threads) {
            SoilDef def = grid_def(48, 16, 16);
            def.material = sand(31);
            def.slides = SlideMotion::run_out;
            def.backend = backend;
            def.thread_count = threads;
            PloughedBed out(def, 0.45);
            out.blade.set_velocity({3, 0, 0.1});
            return out;
        },
        24, 10);
}

}  // namespace
}  // namespace bsoil::pushed_soil_test
