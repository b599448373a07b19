// What walls bear of the soil between them: docs/decisions/silo_walls.md.
#include <array>
#include <cmath>
#include <numbers>

#include "contact/wall_friction.h"
#include "soil_fixture.h"

namespace bsoil::silo_test {
namespace {

constexpr double kWidth = 0.5, kFloorTop = 0.2, kWall = 0.12, kPhiDeg = 30, kFriction = 0.4;
constexpr double kDensity = 1600;
constexpr int kFloorId = 3, kWallId = 7;

enum class Form { square, round };

/// A plate of the wall, mitred: plates that overlapped would count twice where they do.
ConvexShape wall_plate(double at_rad, double apart_rad, double half_height_m) {
    const auto across = [](double angle_rad) {
        return Vec3{std::cos(angle_rad), std::sin(angle_rad), 0};
    };
    const double quarter = std::numbers::pi / 2;
    ConvexShape plate;
    plate.kind = ConvexShape::Kind::hull;
    plate.bound_m = std::hypot((kWidth / 2 + kWall) / std::cos(apart_rad / 2), half_height_m);
    plate.planes = {{-across(at_rad), -kWidth / 2},
                    {across(at_rad), kWidth / 2 + kWall},
                    {across(at_rad + apart_rad / 2 + quarter), 0},
                    {across(at_rad - apart_rad / 2 - quarter), 0},
                    {{0, 0, 1}, half_height_m},
                    {{0, 0, -1}, half_height_m}};
    return plate;
}

/// What stands around the soil.
struct Plan {
    Form form = Form::square;
    double fill_widths = 1, voxel_m = 0.05, yaw_deg = 0;
    bool has_static_walls = false;
    Backend backend = Backend::cpu;
    int threads = 0;
};

/// A silo of 0.5 m on a plate that is wider than it.
struct Silo {
    double height_m;
    std::vector<Mover> bodies;
    std::unique_ptr<Soil> soil;
    StepReport report;

    explicit Silo(const Plan& plan) : height_m(plan.fill_widths * kWidth) {
        const double voxel_m = plan.voxel_m;
        const int side = 8 * static_cast<int>(std::ceil(1.4 / voxel_m / 8));
        const double top_m = kFloorTop + height_m + 0.2;
        SoilDef def =
            grid_def(side, side, 8 * static_cast<int>(std::ceil(top_m / voxel_m / 8)), voxel_m);
        def.material = fixed_density(sand(kPhiDeg));
        def.material.density_kg_m3 = kDensity;
        def.material.tool_friction = kFriction;
        def.backend = plan.backend;
        def.thread_count = plan.threads;
        soil = make_soil(def);
        const double middle_m = side * voxel_m / 2 + 0.3 * voxel_m;
        bodies.emplace_back(kFloorId, box_shape({0.5, 0.5, 0.1}),
                            Vec3{middle_m, middle_m, kFloorTop - 0.1});
        const double yaw = plan.yaw_deg * std::numbers::pi / 180;
        const double half_height_m = (top_m - kFloorTop) / 2;
        const int count = plan.form == Form::square ? 4 : 24;
        const double apart = 2 * std::numbers::pi / count;
        std::vector<ConvexShape> plates;
        for (int i = 0; i < count; ++i) {
            plates.push_back(wall_plate(i * apart, apart, half_height_m));
        }
        Mover& wall = bodies.emplace_back(kWallId, plates.front(),
                                          Vec3{middle_m, middle_m, kFloorTop + half_height_m},
                                          plan.has_static_walls);
        wall.shapes = plates;
        wall.body.shapes = &wall.shapes;
        wall.body.pose.rotation = turn({0, 0, 1}, yaw);
        const double filled_m = height_m;
        const auto inside = [=](Vec3 p) {
            const Vec3 d = rotate(turn({0, 0, 1}, -yaw), p - Vec3{middle_m, middle_m, 0});
            double out_m = -1;
            for (int i = 0; i < count; ++i) {
                out_m = std::max(out_m, d.x * std::cos(i * apart) + d.y * std::sin(i * apart));
            }
            return std::min({kWidth / 2 - out_m, p.z - kFloorTop, kFloorTop + filled_m - p.z});
        };
        // Ground bodies have to be there before the soil.
        soil->step(bodies_of(bodies));
        EXPECT_TRUE(soil->fill(FunctionFill{inside, {}}));
        step(8);
    }

    void step(int count) {
        for (int i = 0; i < count; ++i) report = soil->step(bodies_of(bodies));
    }
    BodyLoad load_of(int id) const {
        for (const BodyLoad& load : report.loads) {
            if (load.body == id) return load;
        }
        return {};
    }
};

/// Janssen (1895) by the silo's own area and the height to which this mass fills it.
double floor_share(const Plan& plan, double mass_kg) {
    const double area_m2 = plan.form == Form::square
                               ? kWidth * kWidth
                               : 24 * kWidth * kWidth / 4 * std::tan(std::numbers::pi / 24);
    const double k = 1 - std::sin(kPhiDeg * std::numbers::pi / 180);
    const double length_m = kWidth / 4 / (k * kFriction);
    const double deep = mass_kg / (kDensity * area_m2) / length_m;
    return -std::expm1(-deep) / deep;
}

void expect_janssen(const Plan& plan) {
    const Silo silo(plan);
    const BodyLoad floor = silo.load_of(kFloorId);
    const double share = 1 - floor.held_kg / floor.mass_kg;
    const double expected = floor_share(plan, floor.mass_kg);
    EXPECT_NEAR(share / expected, 1, 0.1)  // ours, fixed before the first run
        << (plan.form == Form::square ? "square " : "round ") << plan.voxel_m << " m, "
        << plan.yaw_deg << " deg, " << plan.fill_widths << " widths";
    // What comes off the floor goes onto the wall, to the last bit.
    EXPECT_EQ(silo.load_of(kWallId).held_kg, plan.has_static_walls ? 0 : -floor.held_kg);
}

class SiloAtVoxels : public testing::TestWithParam<int> {};

TEST_P(SiloAtVoxels, floor_bears_what_janssen_has) {
    for (const Form form : {Form::square, Form::round}) {
        for (const double yaw_deg : {0.0, 20.0, 45.0}) {
            for (const double fill : {0.5, 1.0, 2.0, 4.0}) {
                expect_janssen({form, fill, kWidth / GetParam(), yaw_deg});
            }
        }
    }
}

std::string voxels_to_the_width(const testing::TestParamInfo<int>& tested) {
    return std::to_string(tested.param);
}
INSTANTIATE_TEST_SUITE_P(SlowToTheWidth, SiloAtVoxels, testing::Values(10, 15, 20),
                         voxels_to_the_width);

// Walls bear nothing of 125 full voxels and their whole share of 250; by hand 0.5 of it of 190.
TEST(Silo, of_a_few_voxels_weighs_on_its_floor) {
    constexpr double kVoxelM = 0.05;  // 10 to the width: each layer is 100 of them
    const auto held_of_expected = [](double layers) {
        const Plan plan{Form::square, layers / 10, kVoxelM};
        const BodyLoad floor = Silo(plan).load_of(kFloorId);
        return floor.held_kg / floor.mass_kg / (1 - floor_share(plan, floor.mass_kg));
    };
    EXPECT_EQ(held_of_expected(1), 0);
    const double part = held_of_expected(2);
    EXPECT_GT(part, 0.2);
    EXPECT_LT(part, 0.8);
    EXPECT_GT(held_of_expected(4), 0.8);
}

TEST(Silo, static_walls_bear_the_same) {
    for (const Form form : {Form::square, Form::round}) {
        for (const double yaw_deg : {0.0, 20.0, 45.0}) {
            for (const double fill : {1.0, 4.0}) {
                expect_janssen({form, fill, 0.05, yaw_deg, true});
            }
        }
    }
}

// Walls hold what comes down along them and nothing that rises, at whatever place.
TEST(Silo, floor_that_is_pushed_up_bears_all) {
    Silo silo({});
    EXPECT_GT(silo.load_of(kFloorId).held_kg, 20);
    const auto move = [&](double up_m_s) {
        Mover& floor = silo.bodies.front();
        floor.set_velocity({0, 0, up_m_s});
        floor.advance(silo.soil->def().step_s);
        silo.step(1);
        floor.set_velocity({});
    };
    move(0.1);
    EXPECT_EQ(silo.load_of(kFloorId).held_kg, 0);
    EXPECT_EQ(silo.load_of(kWallId).held_kg, 0);
    move(-0.1);
    EXPECT_GT(silo.load_of(kFloorId).held_kg, 20);
}

TEST(Silo, has_the_same_bits_on_threads_and_on_gl) {
    for (const bool has_static_walls : {false, true}) {
        const auto shares = [&](Backend backend, int threads) {
            Silo silo({Form::round, 0.5, 0.05, 20, has_static_walls, backend, threads});
            const BodyLoad floor = silo.load_of(kFloorId), wall = silo.load_of(kWallId);
            return std::array{floor.mass_kg,     floor.held_kg,    floor.held_kg_m.x,
                              floor.held_kg_m.z, wall.held_kg_m.y, wall.held_kg};
        };
        const auto one = shares(Backend::cpu, 1);
        EXPECT_GT(one[1], 5);
        EXPECT_EQ(shares(Backend::cpu, 3), one);
        if (gl_missing().empty()) {
            EXPECT_EQ(shares(Backend::gl, 0), one);
        }
    }
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
}

// What the walls are found from is read with everything else.
TEST(Silo, on_a_gpu_waits_once_a_step) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    Silo silo({Form::square, 0.5, 0.05, 0, false, Backend::gl});
    Mover& floor = silo.bodies.front();
    floor.set_velocity({0, 0, -0.05});
    int64_t before = 0;
    for (int i = 0; i < 6; ++i) {
        if (i == 3) before = silo.soil->work_counts().wait_count;
        floor.advance(silo.soil->def().step_s);
        silo.step(1);
        EXPECT_GT(silo.load_of(kFloorId).held_kg, 5);
    }
    EXPECT_EQ(silo.soil->work_counts().wait_count - before, 3);
}

/// Soil on a plate of 1 m, with more bodies.
struct Plate {
    std::vector<Mover> bodies;
    std::unique_ptr<Soil> soil;
    StepReport report;

    explicit Plate(double height_m, double cohesion_pa = 0) {
        SoilDef def = grid_def(40, 40, 64);
        def.material = fixed_density(sand(kPhiDeg, cohesion_pa));
        def.material.density_kg_m3 = kDensity;
        soil = make_soil(def);
        bodies.emplace_back(kFloorId, box_shape({0.5, 0.5, 0.1}), Vec3{1, 1, 0.1});
        EXPECT_TRUE(soil->fill(BoxFill{{{0.7, 0.7, 0.2}, {1.3, 1.3, 0.2 + height_m}}, {}}));
    }
    void step(int count) {
        for (int i = 0; i < count; ++i) report = soil->step(bodies_of(bodies));
    }
};

// However high it is: a block of voxels far above a body is part of its load.
TEST(Load, of_a_plate_is_all_that_stands_on_it) {
    Plate plate(2, 20e3);
    plate.step(4);
    ASSERT_EQ(plate.report.loads.size(), 1u);
    const double mass_kg = plate.soil->totals().mass_kg[0];
    EXPECT_NEAR(plate.report.loads[0].mass_kg, mass_kg, 1e-3 * mass_kg);
    EXPECT_EQ(plate.report.loads[0].held_kg, 0);
}

// What stands by itself leans on no wall; cohesion of 20 kPa does to a height of some metres.
TEST(Load, with_cohesion_leans_on_no_wall) {
    for (const double cohesion_pa : {0.0, 20e3}) {
        Plate plate(1, cohesion_pa);
        plate.bodies.emplace_back(kWallId, box_shape({0.1, 0.5, 0.8}), Vec3{0.6, 1, 1.0});
        plate.step(2);
        ASSERT_FALSE(plate.report.loads.empty());
        EXPECT_EQ(plate.report.loads[0].held_kg > 0, cohesion_pa == 0);
    }
}

// A pillar that stands in a load, or a block that lies in it, moves with the load.
TEST(Load, holds_what_lies_in_it_and_is_not_held) {
    for (const double bottom_m : {0.2, 0.6}) {
        Plate plate(0.8);
        plate.bodies.emplace_back(kWallId, box_shape({0.15, 0.15, 0.4}),
                                  Vec3{1, 1, bottom_m + 0.4});
        plate.step(4);
        for (const BodyLoad& load : plate.report.loads) EXPECT_EQ(load.held_kg, 0);
    }
}

/// Cells of a square shaft of some voxels, and its walls' faces.
struct Shaft {
    std::vector<LoadCell> cells;
    std::vector<WallFace> faces;

    Shaft(int side, int height, double friction, double relief_kg = 0) {
        for (int z = 0; z < height; ++z) {
            for (int i = 0; i < side * side; ++i) {
                const int x = i % side, y = i / side;
                cells.push_back({x, y, z, 1});
                for (const bool is_wall : {x == 0, x == side - 1, y == 0, y == side - 1}) {
                    if (!is_wall) continue;
                    faces.push_back({{x, y, z}, 1, friction, 0.5, relief_kg, 0, {}, 0});
                }
            }
        }
    }
    double borne_kg() const {
        double sum = 0;
        for (const WallFace& face : faces) sum += face.borne_kg;
        return sum;
    }
};

TEST(WallFriction, is_janssens) {
    for (const int height : {2, 10, 40}) {
        Shaft shaft(6, height, 0.4);
        const double mass_kg = 36.0 * height;
        WallFriction().find(shaft.cells, mass_kg, shaft.faces);
        const double length = 36 / (24 * 0.4 * 0.5);
        EXPECT_NEAR(mass_kg - shaft.borne_kg(), 36 * length * -std::expm1(-height / length),
                    1e-9 * mass_kg);
    }
}

// Bell: 3 kg on a voxel's side. Until that much comes down walls hold nothing; from there on they
// hold what is beyond.
TEST(WallFriction, begins_where_soil_does_not_stand_by_itself) {
    Shaft low(6, 6, 0.4, 3);
    WallFriction().find(low.cells, 36.0 * 6, low.faces);
    EXPECT_EQ(low.borne_kg(), 0);
    Shaft high(6, 16, 0.4, 3);
    WallFriction().find(high.cells, 36.0 * 16, high.faces);
    const double length = 36 / (24 * 0.4 * 0.5);
    EXPECT_NEAR(36.0 * 16 - high.borne_kg(), 36 * (6 + length * -std::expm1(-10 / length)), 1e-9);
}

TEST(WallFriction, hangs_soil_up_that_comes_down) {
    const Vec3 up{0, 0, 1};
    EXPECT_EQ(hanging_share({0, 0, 0.001}, up, 0.005), 1);
    EXPECT_NEAR(hanging_share({0, 0, 0.0075}, up, 0.005), 0.5, 1e-12);
    EXPECT_EQ(hanging_share({0, 0, -1}, up, 0.005), 1);
    EXPECT_EQ(hanging_share({0, 0, 1}, up, 0.005), 0);
    EXPECT_EQ(hanging_share({1, 0, 0}, up, 0.005), 0);
    EXPECT_NEAR(hanging_share({3, 0, -4}, up, 0.005), 0.8, 1e-12);
}

}  // namespace
}  // namespace bsoil::silo_test
