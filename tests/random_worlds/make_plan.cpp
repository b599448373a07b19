#include "make_plan.h"

#include <algorithm>

#include "make_shape.h"

namespace bsoil::random_worlds {
namespace {

/// Speeds that bodies have at first, and that driven bodies keep [voxels a soil step]: well within
/// what a step resolves by sub-steps, so that no world sets speed_clamped by itself. And no faster
/// than after a fall of this many voxels, so that most stay in the grid.
constexpr double kSpeedVoxels = 1.5, kFallVoxels = 6;
/// Clear height under a body that is dropped [voxels].
constexpr double kDropVoxels = 4;

/// Puts a world together, part by part.
class Maker {
  public:
    Maker(uint64_t seed, PlanKind kind) : random_(seed), kind_(kind) { plan_.seed = seed; }

    WorldPlan make() {
        add_soil();
        if (kind_ == PlanKind::any && random_.chance(0.1)) add_soil();
        set_time();
        for (int i = fixed_count(); i > 0; --i) add_fixed();
        for (int i = random_.integer(1, kind_ == PlanKind::small ? 3 : 6); i > 0; --i) add_moving();
        if (random_.chance(0.3)) add_joints();
        if (random_.chance(0.25)) add_chain();
        if (kind_ != PlanKind::calm) {
            if (random_.chance(0.35)) {
                for (int i = random_.integer(1, 2); i > 0; --i) add_driven();
            }
            if (kind_ == PlanKind::any && random_.chance(0.2)) add_car();
            if (random_.chance(0.35)) {
                for (int i = random_.integer(1, 3); i > 0; --i) add_event();
            }
            set_comings_and_goings();
        }
        return std::move(plan_);
    }

  private:
    int fixed_count() { return random_.chance(0.45) ? random_.integer(1, 2) : 0; }
    double size(int soil, int axis) const {
        const Vec3 s = plan_.soils[static_cast<size_t>(soil)].def.size_m;
        return axis == 0 ? s.x : axis == 1 ? s.y : s.z;
    }
    double voxel(int soil) const { return plan_.soils[static_cast<size_t>(soil)].def.voxel_m; }
    double top_speed_m_s(int soil) const {
        const SoilDef& def = plan_.soils[static_cast<size_t>(soil)].def;
        return std::min(kSpeedVoxels * def.voxel_m / def.step_s,
                        std::sqrt(2 * def.gravity_m_s2 * kFallVoxels * def.voxel_m));
    }
    int any_soil() { return random_.integer(0, static_cast<int>(plan_.soils.size()) - 1); }

    void set_time() {
        plan_.frame_s = 1.0 / random_.choose({60, 60, 60, 30, 120});
        plan_.substep_count = random_.choose({1, 1, 2, 4});
        plan_.is_variable = random_.chance(0.2);
        plan_.action_steps = random_.integer(40, 120);
    }

    /// The first soil decides the up axis and gravity; a second one lies beside it.
    void add_soil() {
        SoilPlan soil;
        SoilDef& def = soil.def;
        const bool is_first = plan_.soils.empty();
        const bool is_small = kind_ == PlanKind::small;
        def.voxel_m =
            is_first ? random_.log_uniform(0.005, 0.5) : voxel(0) * random_.choose({0.5, 1.0, 1.5});
        const int x = is_small ? random_.integer(8, 18) : random_.integer(12, 44);
        const int y = is_small ? random_.integer(8, 18) : random_.integer(12, 44);
        const int z = is_small ? random_.integer(8, 16) : random_.integer(14, 36);
        def.size_m = Vec3{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)} *
                     def.voxel_m;
        if (is_first) {
            def.up = random_.choose({UpAxis::y, UpAxis::z});
            def.gravity_m_s2 = random_.chance(0.2) ? random_.choose({1.62, 3.7, 20.0}) : 9.81;
            def.floor_center_m = random_.chance(0.5) ? random_.in_cube() * 10 : Vec3{};
            def.yaw_rad = random_.chance(0.4) ? random_.uniform(-3, 3) : 0;
        } else {
            const SoilDef& first = plan_.soils[0].def;
            def.up = first.up;
            def.gravity_m_s2 = first.gravity_m_s2;
            def.floor_center_m = first.floor_center_m;
            (def.up == UpAxis::y ? def.floor_center_m.z : def.floor_center_m.y) +=
                length(first.size_m) + length(def.size_m);
        }
        def.step_s = 1.0 / random_.choose({60, 60, 60, 60, 30, 120, 240});
        def.backend = Backend::cpu;
        def.thread_count = 1;
        std::vector<MaterialDef> known(materials::all().begin(), materials::all().end());
        // Weather is added apart.
        std::erase_if(known, [](const MaterialDef& m) { return m.pore_water_fraction > 0; });
        for (int i = random_.integer(1, 3); i > 0; --i) {
            const auto at = known.begin() + random_.integer(0, static_cast<int>(known.size()) - 1);
            def.materials.push_back(*at);
            known.erase(at);
        }
        if (random_.chance(0.1)) def.overflow = OverflowHeuristic::even;
        if (random_.chance(0.1)) def.overflow = OverflowHeuristic::up_spread;
        add_fills(soil, x, y, z);
        plan_.soils.push_back(std::move(soil));
    }

    void add_fills(SoilPlan& soil, int x, int y, int z) {
        const double voxel_m = soil.def.voxel_m;
        const auto material = [&] {
            return random_.integer(0, static_cast<int>(soil.def.materials.size()) - 1);
        };
        const int bed = random_.integer(4, std::min(12, z / 2));
        const Vec3 all{x * voxel_m, y * voxel_m, bed * voxel_m};
        if (random_.chance(0.15)) {
            soil.terrain_m = random_.uniform(1, bed - 1) * voxel_m;
            soil.terrain_slope = random_.uniform(0, 0.1);
        }
        FillPlan first{.kind = random_.chance(0.2) ? FillPlan::Kind::noise : FillPlan::Kind::box,
                       .material = material(),
                       .low_m = {},
                       .high_m = all,
                       .seed = static_cast<uint64_t>(random_.integer(0, 1000))};
        soil.fills.push_back(first);
        double top = bed;
        const auto place = [&](double low, double high) {
            FillPlan fill;
            fill.kind = random_.choose(
                {FillPlan::Kind::box, FillPlan::Kind::cylinder, FillPlan::Kind::hill});
            fill.material = material();
            const double half_x = random_.uniform(2, x / 3.0), half_y = random_.uniform(2, y / 3.0);
            const double at_x = random_.uniform(0, x), at_y = random_.uniform(0, y);
            fill.low_m = Vec3{at_x - half_x, at_y - half_y, low} * voxel_m;
            fill.high_m = Vec3{at_x + half_x, at_y + half_y, high} * voxel_m;
            return fill;
        };
        for (int i = random_.integer(0, 2); i > 0; --i) {
            const double high = bed + random_.uniform(1, std::min(8.0, z * 0.6 - bed + 2));
            soil.fills.push_back(place(0, high));
            top = std::max(top, high);
        }
        if (random_.chance(0.15) && top + 6 < z) {
            FillPlan hanging = place(top + 2, std::min<double>(z, top + 2 + random_.uniform(1, 4)));
            hanging.is_hanging = true;
            soil.fills.push_back(hanging);
            top = hanging.high_m.z / voxel_m;
        }
        tops_m_.push_back(top * voxel_m);
    }

    /// A place for a ball, clear of all others and above the soil; false where there is none.
    /// half_height_m: of what is flat, and then keeps clear of what is above it as well.
    bool place(int soil, double bound, Vec3& at, double half_height_m = 0) {
        const double edge = bound + voxel(soil);
        if (size(soil, 0) <= 2 * edge || size(soil, 1) <= 2 * edge) return false;
        const double gap = random_.uniform(0.2, kDropVoxels) * voxel(soil);
        for (int attempt = 0; attempt < 40; ++attempt) {
            at = {random_.uniform(edge, size(soil, 0) - edge),
                  random_.uniform(edge, size(soil, 1) - edge),
                  tops_m_[static_cast<size_t>(soil)] + gap +
                      (half_height_m > 0 ? half_height_m : bound)};
            bool is_free = true;
            for (const Ball& ball : balls_) {
                Vec3 apart = ball.at_m - at;
                if (half_height_m > 0) apart.z = 0;
                is_free &=
                    ball.soil != soil || length(apart) > ball.bound_m + bound + 0.5 * voxel(soil);
            }
            if (!is_free) continue;
            balls_.push_back({soil, at, bound});
            return true;
        }
        return false;
    }

    void add_fixed() {
        BodyPlan body;
        body.kind = BodyPlan::Kind::fixed;
        body.soil = any_soil();
        const double v = voxel(body.soil);
        const double bound = random_.uniform(1.5, 7) * v;
        body.shape =
            make_fixed_shape(random_, bound, std::max(size(body.soil, 0), size(body.soil, 1)));
        const double top = tops_m_[static_cast<size_t>(body.soil)];
        const double height = random_.uniform(0, top + 2 * v);
        const bool is_ground = body.shape.kind == ShapePlan::Kind::plane ||
                               body.shape.kind == ShapePlan::Kind::heightfield;
        Vec3& at = body.pose.position;
        at = {random_.uniform(0, size(body.soil, 0)), random_.uniform(0, size(body.soil, 1)),
              height};
        if (is_ground) {
            at.x = size(body.soil, 0) / 2;
            at.y = size(body.soil, 1) / 2;
            at.z = std::min(height, top);
            // A plane may lean by a seventh of the way to the border.
            const double rise = body.shape.kind == ShapePlan::Kind::plane
                                    ? 0.15 * (size(body.soil, 0) + size(body.soil, 1)) / 2
                                    : bound / 2;
            tops_m_[static_cast<size_t>(body.soil)] = std::max(top, at.z + rise);
        } else {
            body.pose.rotation = random_.rotation();
            balls_.push_back({body.soil, at, bound_m(body.shape)});
        }
        plan_.bodies.push_back(std::move(body));
    }

    void add_moving() {
        BodyPlan body;
        body.soil = any_soil();
        const double v = voxel(body.soil);
        const double bound =
            random_.chance(0.15) ? random_.uniform(0.4, 1.5) * v : random_.uniform(1.5, 6) * v;
        body.shape = make_moving_shape(random_, bound);
        if (!place(body.soil, bound_m(body.shape), body.pose.position)) return;
        body.pose.rotation = random_.chance(0.3) ? Quat{} : random_.rotation();
        body.mass_kg = random_.chance(0.15)
                           ? random_.log_uniform(1e-3, 1e5)
                           : random_.log_uniform(300, 4000) * 1.5 * bound * bound * bound;
        if (random_.chance(0.5)) {
            body.velocity_m_s = random_.in_cube() * (top_speed_m_s(body.soil) / 1.7321);
            body.velocity_m_s.z = std::min(0.0, body.velocity_m_s.z);
            body.spin_rad_s = random_.in_cube() * (0.6 * top_speed_m_s(body.soil) / bound / 1.7321);
        }
        body.friction = random_.uniform(0.2, 0.9);
        if (kind_ == PlanKind::any) {
            body.is_ignored = random_.chance(0.07);
            body.is_coverage_only = random_.chance(0.03);
        }
        if (random_.chance(0.15)) body.surface_friction = random_.uniform(0, 0.8);
        plan_.bodies.push_back(std::move(body));
    }

    void add_driven() {
        BodyPlan body;
        body.kind = BodyPlan::Kind::driven;
        body.soil = any_soil();
        const double v = voxel(body.soil);
        body.shape = make_moving_shape(random_, random_.uniform(1.5, 5) * v);
        body.pose.position = {random_.uniform(0.1, 0.9) * size(body.soil, 0),
                              random_.uniform(0.1, 0.9) * size(body.soil, 1),
                              random_.uniform(0.5, 1.2) * tops_m_[static_cast<size_t>(body.soil)]};
        body.pose.rotation = random_.rotation();
        body.velocity_m_s = random_.in_cube() * (0.4 * top_speed_m_s(body.soil));
        body.velocity_m_s.z *= 0.3;
        if (random_.chance(0.5)) {
            body.spin_rad_s =
                random_.in_cube() * (0.3 * top_speed_m_s(body.soil) / bound_m(body.shape));
        }
        plan_.bodies.push_back(std::move(body));
    }

    void add_joints() {
        for (size_t i = 0; i + 1 < plan_.bodies.size(); ++i) {
            const BodyPlan &a = plan_.bodies[i], &b = plan_.bodies[i + 1];
            if (a.kind != BodyPlan::Kind::moving || b.kind != BodyPlan::Kind::moving ||
                a.soil != b.soil || !random_.chance(0.6)) {
                continue;
            }
            JointPlan joint;
            joint.kind = random_.choose({JointPlan::Kind::hinge, JointPlan::Kind::slider,
                                         JointPlan::Kind::point, JointPlan::Kind::six_dof});
            joint.a = static_cast<int>(i);
            joint.b = static_cast<int>(i) + 1;
            joint.axis = random_.direction();
            if (kind_ != PlanKind::calm && random_.chance(0.4)) {
                const double reach = length(a.pose.position - b.pose.position);
                joint.motor_speed = 0.2 * top_speed_m_s(a.soil) / reach;
                joint.motor_most =
                    0.3 * std::min(a.mass_kg, b.mass_kg) * plan_.soils[0].def.gravity_m_s2 * reach;
            }
            plan_.joints.push_back(joint);
        }
    }

    void add_chain() {
        ChainPlan chain;
        chain.soil = any_soil();
        const double v = voxel(chain.soil);
        chain.link_count = random_.integer(1, 3);
        chain.has_fixed_base = random_.chance(0.3);
        chain.half_m = random_.uniform(1.2, 2.5) * v;
        const double h = chain.half_m;
        chain.link_mass_kg = random_.log_uniform(500, 4000) * 8 * h * h * h;
        Vec3 middle;
        if (!place(chain.soil, 1.2 * h * (chain.link_count + 1.2), middle, h)) return;
        chain.pose.position = middle - Vec3{1.2 * h * chain.link_count, 0, 0};
        if (kind_ != PlanKind::calm && random_.chance(0.6)) {
            chain.motor_speed = 0.2 * top_speed_m_s(chain.soil) / h;
            chain.motor_most = 2 * chain.link_mass_kg * plan_.soils[0].def.gravity_m_s2 * h;
        }
        plan_.chains.push_back(chain);
    }

    void add_car() {
        CarPlan car;
        car.soil = any_soil();
        car.radius_m = random_.uniform(2, 3) * voxel(car.soil);
        const double r = car.radius_m;
        car.width_m = std::max(0.01, random_.uniform(0.6, 1) * r);  // the least that is a wheel
        car.mass_kg = random_.log_uniform(500, 2500) * 8 * r * r * r;
        if (!place(car.soil, 3.4 * r, car.pose.position, 2.2 * r)) return;
        car.pose.rotation = Random::turn({0, 0, 1}, random_.uniform(-3, 3));
        const double weight = car.mass_kg * plan_.soils[0].def.gravity_m_s2;
        if (random_.chance(0.7)) car.engine_n = random_.uniform(-0.4, 0.6) * weight;
        if (random_.chance(0.5)) car.steering_rad = random_.uniform(-0.4, 0.4);
        plan_.cars.push_back(car);
    }

    void add_event() {
        EventPlan event;
        event.step = random_.integer(1, plan_.action_steps - 1);
        event.kind = random_.choose({EventPlan::Kind::teleport, EventPlan::Kind::push,
                                     EventPlan::Kind::push, EventPlan::Kind::set_ignored,
                                     EventPlan::Kind::set_coupled, EventPlan::Kind::fill,
                                     EventPlan::Kind::disable, EventPlan::Kind::enable});
        const bool is_of_soil = event.kind == EventPlan::Kind::fill ||
                                event.kind == EventPlan::Kind::disable ||
                                event.kind == EventPlan::Kind::enable;
        if (is_of_soil) {
            event.body = any_soil();
        } else {
            std::vector<int> moving;
            for (size_t i = 0; i < plan_.bodies.size(); ++i) {
                if (plan_.bodies[i].kind == BodyPlan::Kind::moving) {
                    moving.push_back(static_cast<int>(i));
                }
            }
            if (moving.empty()) return;
            event.body = moving[static_cast<size_t>(
                random_.integer(0, static_cast<int>(moving.size()) - 1))];
        }
        const int soil =
            is_of_soil ? event.body : plan_.bodies[static_cast<size_t>(event.body)].soil;
        if (event.kind == EventPlan::Kind::push) {
            event.vector = random_.in_cube() * (top_speed_m_s(soil) / 1.7321);
        } else {
            event.vector = {random_.uniform(0.2, 0.8) * size(soil, 0),
                            random_.uniform(0.2, 0.8) * size(soil, 1),
                            random_.uniform(0.3, 1.3) * tops_m_[static_cast<size_t>(soil)]};
        }
        plan_.events.push_back(event);
        // What is switched off is switched on again.
        if (event.kind == EventPlan::Kind::disable) {
            event.kind = EventPlan::Kind::enable;
            event.step = random_.integer(event.step, plan_.action_steps);
            plan_.events.push_back(event);
        }
    }

    void set_comings_and_goings() {
        for (size_t i = 0; i < plan_.bodies.size(); ++i) {
            if (!random_.chance(0.12)) continue;
            bool is_joined = false;
            for (const JointPlan& joint : plan_.joints) {
                is_joined |= joint.a == static_cast<int>(i) || joint.b == static_cast<int>(i);
            }
            if (is_joined) continue;
            BodyPlan& body = plan_.bodies[i];
            if (random_.chance(0.5)) {
                body.enters_step = random_.integer(1, plan_.action_steps - 1);
            } else {
                body.leaves_step = random_.integer(1, plan_.action_steps - 1);
            }
        }
    }

    struct Ball {
        int soil;
        Vec3 at_m;
        double bound_m;
    };
    Random random_;
    PlanKind kind_;
    WorldPlan plan_;
    std::vector<Ball> balls_;     ///< room that is taken
    std::vector<double> tops_m_;  ///< of each soil: nothing but bodies reaches higher
};

}  // namespace

WorldPlan make_plan(uint64_t seed, PlanKind kind) { return Maker(seed, kind).make(); }

}  // namespace bsoil::random_worlds
