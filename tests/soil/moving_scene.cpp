#include "moving_scene.h"

#include <cmath>

namespace bsoil {

SoilDef MovingScene::default_def() {
    SoilDef def = grid_def(40, 32, 24);
    def.materials = {materials::dry_sand(), materials::moist_sand(), materials::gravel()};
    return def;
}

MovingScene::MovingScene(unsigned seed, SoilDef def) : soil_(make_soil(def)) {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
        return std::uniform_real_distribution(low, high)(random);
    };
    const GridFrame& frame = soil_->frame();
    const auto fill = [&](const std::string& material, auto&& inside) {
        EXPECT_TRUE(soil_->fill(FunctionFill{
            [&](Vec3 at) { return inside(frame.to_grid(at)) ? 1.0 : -1.0; }, material}));
    };
    // Sizes keep clear of the points at which fills sample (thirds of a voxel), so that rounding
    // does not matter.
    const double hill_x = uniform(10, 30), hill_y = uniform(8, 24),
                 base = 4.71 + std::floor(uniform(0, 3));
    EXPECT_TRUE(soil_->add_terrain([&](Vec3 at) {
        const Vec3 g = frame.to_grid(at);
        return 3.17 - g.z - 0.0173 * (std::pow(g.x - hill_x, 2) + std::pow(g.y - hill_y, 2));
    }));
    fill("dry_sand", [&](Vec3 g) { return g.z < base; });
    const Vec3 pile{uniform(10, 30), uniform(8, 24), base};
    fill("gravel", [&](Vec3 g) {
        return g.z < base + 7.07 && std::hypot(g.x - pile.x, g.y - pile.y) < 5.31;
    });
    const Vec3 drop{uniform(8, 32), uniform(8, 24), 17.07};
    fill("moist_sand", [&](Vec3 g) { return length(g - drop) < 3.63; });

    const double v = frame.voxel_m;
    movers_.emplace_back(7, box_shape(Vec3{1.23, 6.13, 3.37} * v), Vec3{});  // a blade
    movers_.emplace_back(3, round_shape(ConvexShape::Kind::cylinder, 4.19 * v, 1.41 * v),
                         Vec3{});                                 // a wheel
    movers_.emplace_back(9, octahedron_shape(3.29 * v), Vec3{});  // a stone
    movers_.emplace_back(1, round_shape(ConvexShape::Kind::capsule, 1.87 * v, 3.11 * v), Vec3{},
                         true);  // a post
    for (int i = 0; i < 8; ++i) phases_.push_back(uniform(0, 6.28));
    place_bodies();
}

// Courses are functions of the step: a run may start anywhere.
void MovingScene::place_bodies() {
    const GridFrame& frame = soil_->frame();
    const double step_s = soil_->def().step_s;
    const Quat to_world = frame.grid_to_world.rotation;
    const auto course = [&](size_t i, double t) {
        switch (i) {
            case 0:
                return Vec3{20 + 12 * std::sin(0.031 * t + phases_[0]),
                            16 + 3 * std::sin(0.017 * t + phases_[1]), 6.5};
            case 1:
                return Vec3{20 + 9 * std::sin(0.023 * t + phases_[2]),
                            9 + 3 * std::cos(0.037 * t + phases_[3]), 7.3};
            case 2:
                return Vec3{20 + 14 * std::cos(0.041 * t + phases_[4]), 22.0,
                            7 + 4 * std::sin(0.063 * t + phases_[5])};
            default:
                return Vec3{6.2, 26.1, 6.4};
        }
    };
    const auto heading = [&](size_t i, double t) -> Quat {
        switch (i) {
            case 0:
                return turn({0, 0, 1}, 0.4 * std::sin(0.029 * t + phases_[6]));
            case 1:
                return turn({1, 0, 0}, 1.5707) * turn({0, 0, 1}, 0.05 * t);
            case 2:
                return turn({0.6, 0.8, 0}, 0.03 * t);
            default:
                return {};
        }
    };
    bodies_.clear();
    for (size_t i = 0; i < movers_.size(); ++i) {
        const double t = static_cast<double>(step_count_);
        SoilBody& body = movers_[i].body;
        const Vec3 at = course(i, t);
        body.pose = {frame.to_world(at), to_world * heading(i, t)};
        body.center_of_mass_m = body.pose.position;
        body.linear_velocity_m_s =
            rotate(to_world, at - course(i, t - 1)) * (frame.voxel_m / step_s);
        const Quat change = heading(i, t) * conjugate(heading(i, t - 1));
        body.angular_velocity_rad_s =
            rotate(to_world, Vec3{change.x, change.y, change.z}) * (2 / step_s);
        bodies_.push_back(body);
    }
}

StepReport MovingScene::step() {
    ++step_count_;
    place_bodies();
    return soil_->step(bodies_);
}

void MovingScene::run(int steps) {
    for (int i = 0; i < steps; ++i) step();
}

void MovingScene::skip_to(int64_t steps) {
    step_count_ = steps;
    place_bodies();
}

}  // namespace bsoil
