#include "add_weather.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "random.h"

namespace bsoil::random_worlds {
namespace {

/// Tells this stream of random numbers from the plan's own.
constexpr uint64_t kStream = 0x7765617468657200;
/// That of groundwater and wells.
constexpr uint64_t kDeepStream = 0x67726f756e647700;
/// Speed at which sources pour [voxels a soil step]: as bodies move at most.
constexpr double kPourVoxels = 1.5;

class WeatherMaker {
  public:
    explicit WeatherMaker(WorldPlan& plan)
        : plan_(plan), random_(plan.seed ^ kStream), deep_(plan.seed ^ kDeepStream) {}

    void add() {
        plan_.has_weather = true;
        for (SoilPlan& soil : plan_.soils) {
            for (MaterialDef& material : soil.def.materials) change(material);
            set_water(soil.def);
            if (random_.chance(0.4)) set_wind(soil.def);
            if (random_.chance(0.3)) open_sides(soil.def);
            if (random_.chance(0.15)) soil.def.slides = SlideMotion::run_out;
            set_law(soil.def);
            if (random_.chance(0.5)) {
                for (int i = random_.integer(1, 2); i > 0; --i) add_source(soil);
            }
            if (random_.chance(0.35)) {
                for (int i = random_.integer(1, 2); i > 0; --i) add_sink(soil);
            }
            add_groundwater(soil);
        }
    }

  private:
    double action_s() const { return plan_.frame_s * plan_.action_steps; }

    void change(MaterialDef& m) {
        if (random_.chance(0.15)) make_up(m);
        if (random_.chance(0.5)) {
            m.pore_water_fraction = random_.uniform(0.01, 0.5);
            m.placed_saturation =
                random_.chance(0.3) ? random_.choose({0.0, 1.0}) : random_.uniform(0, 1);
            m.moist_cohesion_pa = random_.chance(0.3) ? 0 : random_.log_uniform(10, 2e4);
            m.conductivity_m_s = random_.chance(0.15) ? 0 : random_.log_uniform(1e-7, 1);
            m.residual_saturation = random_.uniform(0, 0.5);
        }
        if (random_.chance(0.3)) m.fall_speed_m_s = random_.log_uniform(0.2, 30);
        if (random_.chance(0.15)) m.roughness = random_.log_uniform(0.05, 40);
        if (random_.chance(0.15)) m.viscosity = random_.chance(0.2) ? 1 : random_.uniform(0, 1);
    }
    /// Of no soil that there is: anything a program may ask for.
    void make_up(MaterialDef& m) {
        m.density_kg_m3 = random_.log_uniform(200, 4000);
        m.loose_density_kg_m3 = m.compacted_density_kg_m3 = 0;
        if (random_.chance(0.5)) {
            m.loose_density_kg_m3 = std::max(200.0, m.density_kg_m3 * random_.uniform(0.75, 1));
            m.compacted_density_kg_m3 = std::min(4000.0, m.density_kg_m3 * random_.uniform(1, 1.3));
        }
        m.friction_angle_rad = random_.uniform(0, 1.2);
        m.cohesion_pa = random_.chance(0.4) ? 0 : random_.log_uniform(10, 2e5);
        m.loose_cohesion_fraction = random_.uniform(0, 1);
        m.tool_friction = random_.uniform(0, 2);
        m.tool_adhesion_pa = random_.chance(0.5) ? 0 : random_.log_uniform(10, 1e4);
        m.shear_displacement_m = random_.chance(0.5) ? 0 : random_.log_uniform(1e-3, 0.2);
        if (m.has_density_range() && random_.chance(0.5)) {
            m.compaction_cohesion_ratio = random_.log_uniform(1e-3, 0.5);
        }
        if (m.has_density_range() && random_.chance(0.5)) {
            m.dilatancy_angle_rad = random_.uniform(0, 0.1);
        }
    }

    void set_water(SoilDef& def) {
        if (random_.chance(0.3)) def.rain_m_s = random_.log_uniform(1e-6, 1e-3);
        if (random_.chance(0.3)) def.drying_m_s = random_.log_uniform(1e-6, 1e-3);
        if (random_.chance(0.4)) def.floor_drainage_m_s = random_.log_uniform(1e-6, 1);
    }

    void set_wind(SoilDef& def) {
        const Vec3 way = random_.direction();
        def.wind_m_s = Vec3{way.x, way.y, way.z} * random_.log_uniform(0.2, 30);
        if (random_.chance(0.5)) def.gust = random_.uniform(0, 1);
        def.gust_size_m = std::clamp(random_.log_uniform(2, 500) * def.voxel_m, 0.01, 1000.0);
        def.shelter_m = random_.chance(0.2) ? 0 : random_.uniform(0, 100) * def.voxel_m;
    }

    void open_sides(SoilDef& def) {
        for (const int bit : {kOpenLowX, kOpenHighX, def.up == UpAxis::y ? kOpenLowZ : kOpenLowY,
                              def.up == UpAxis::y ? kOpenHighZ : kOpenHighY}) {
            if (random_.chance(0.4)) def.open_sides |= bit;
        }
    }

    void set_law(SoilDef& def) {
        ContactLawDef& law = def.contact_law;
        if (random_.chance(0.1)) {
            law.kind = def.up == UpAxis::y ? ContactLawDef::Kind::plain : ContactLawDef::Kind::work;
        }
        if (random_.chance(0.15)) law.passive_wedge = true;
        if (random_.chance(0.15)) law.trapped_soil = false;
        if (!random_.chance(0.1)) return;
        law.kind = ContactLawDef::Kind::bekker;
        for (const MaterialDef& m : def.materials) {
            BekkerSoil bekker;
            bekker.kphi_pa_m_n = random_.log_uniform(1e5, 1e7);
            bekker.kc_pa_m_n1 = random_.chance(0.5) ? 0 : random_.uniform(0, 2e4);
            bekker.n = random_.uniform(0.5, 1.5);
            bekker.cohesion_pa = m.cohesion_pa;
            bekker.friction_angle_rad = m.friction_angle_rad;
            bekker.shear_displacement_m = m.shear_displacement_m;
            law.bekker.push_back(bekker);
        }
    }

    /// In the grid, between these shares of its height.
    Vec3 place(const SoilDef& def, double low, double high) {
        return {random_.uniform(0.1, 0.9) * def.size_m.x, random_.uniform(0.1, 0.9) * def.size_m.y,
                random_.uniform(low, high) * def.size_m.z};
    }
    void set_times(FlowPlan& flow) {
        double &start = flow.is_source ? flow.source.start_s : flow.sink.start_s,
               &end = flow.is_source ? flow.source.end_s : flow.sink.end_s;
        start = random_.chance(0.5) ? 0 : random_.uniform(0, 0.5) * action_s();
        end = random_.uniform(0.6, 1) * action_s();
        if (random_.chance(0.15)) flow.moves_step = random_.integer(1, plan_.action_steps - 1);
        if (random_.chance(0.15)) flow.ends_step = random_.integer(1, plan_.action_steps - 1);
    }

    void add_source(SoilPlan& soil) {
        FlowPlan flow;
        flow.is_source = true;
        SourceDef& source = flow.source;
        const double v = soil.def.voxel_m;
        source.center_m = place(soil.def, 0.6, 0.95);
        flow.moved_to_m = place(soil.def, 0.6, 0.95);
        if (random_.chance(0.4)) source.direction = random_.direction();
        double area = 0;  // in voxels
        if (random_.chance(0.5)) {
            source.radius_m = random_.uniform(0.7, 4) * v;
            area = std::numbers::pi * source.radius_m * source.radius_m / (v * v);
        } else {
            source.shape = SourceDef::Shape::rectangle;
            source.length_m = random_.uniform(1, 8) * v;
            source.width_m = random_.uniform(1, 4) * v;
            source.turn_rad = random_.uniform(-3, 3);
            area = source.length_m * source.width_m / (v * v);
        }
        if (random_.chance(0.6)) {
            source.speed_m_s =
                std::min(100.0, random_.uniform(0, kPourVoxels) * v / soil.def.step_s);
            source.spread_rad = random_.chance(0.5) ? random_.uniform(0, 0.6) : 0;
        }
        const auto material = static_cast<size_t>(
            random_.integer(0, static_cast<int>(soil.def.materials.size()) - 1));
        source.material = soil.def.materials[material].name;
        // At most a quarter of a layer a step: a source that could not place what it pours at
        // first is refused.
        const double layers = random_.log_uniform(0.002, 0.25) * std::max(1.0, area / 4);
        const double rate_m3_s = layers * v * v * v / soil.def.step_s;
        if (random_.chance(0.5)) {
            source.rate_m3_s = rate_m3_s;
        } else {
            source.rate_kg_s = rate_m3_s * 0.5 * soil.def.materials[material].density_kg_m3;
        }
        set_times(flow);
        soil.flows.push_back(flow);
    }

    void add_sink(SoilPlan& soil) {
        FlowPlan flow;
        SinkDef& sink = flow.sink;
        const double v = soil.def.voxel_m;
        sink.region.kind = random_.choose(
            {ConvexShape::Kind::box, ConvexShape::Kind::sphere, ConvexShape::Kind::cylinder});
        const double half = random_.uniform(1, 5) * v;
        sink.region.half_extents_m = Vec3{half, half, half} * random_.uniform(0.7, 1);
        sink.region.radius_m = sink.region.half_height_m = half;
        sink.pose.position = place(soil.def, 0, 0.5);
        flow.moved_to_m = place(soil.def, 0, 0.5);
        sink.pose.rotation = random_.rotation();
        if (random_.chance(0.6)) {
            const double mass_kg = 8 * half * half * half * soil.def.materials[0].density_kg_m3;
            sink.rate_kg_s = random_.log_uniform(0.05, 5) * mass_kg;
        }
        set_times(flow);
        soil.flows.push_back(flow);
    }

    void add_groundwater(SoilPlan& soil) {
        const double share = deep_.uniform(0.02, 0.6);
        if (deep_.chance(0.3)) soil.def.water_table_m = share * soil.def.size_m.z;
        const double half = deep_.uniform(1, 5) * soil.def.voxel_m;
        const double rate = deep_.log_uniform(1e-3, 1) * 8 * half * half * half * 1000;
        const Vec3 at{deep_.uniform(0.1, 0.9) * soil.def.size_m.x,
                      deep_.uniform(0.1, 0.9) * soil.def.size_m.y,
                      deep_.uniform(0, 0.5) * soil.def.size_m.z};
        const bool takes = deep_.chance(0.6);
        const bool has_water = std::ranges::any_of(
            soil.def.materials, [](const MaterialDef& m) { return m.pore_water_fraction > 0; });
        if (!has_water || !deep_.chance(0.4)) return;
        FlowPlan flow;
        flow.sink.region.kind = ConvexShape::Kind::box;
        flow.sink.region.half_extents_m = {half, half, half};
        flow.sink.pose.position = flow.moved_to_m = at;
        flow.sink.water_kg_s = takes ? rate : -rate;
        flow.sink.end_s = action_s();
        soil.flows.push_back(flow);
    }

    WorldPlan& plan_;
    Random random_, deep_;
};

}  // namespace

void add_weather(WorldPlan& plan) { WeatherMaker(plan).add(); }

}  // namespace bsoil::random_worlds
