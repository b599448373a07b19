#include "feature_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "pushing_block.h"
#include "scene_work.h"

namespace bsoil::command {
namespace {

constexpr int kSide = 56;         // voxels, the smallest cube of the thesis
constexpr int kWarmUpSteps = 20;  // as for the other figures
constexpr int kSteps = 150;       // to the other side, back, and part of the way again

/// A soil that differs from the plain one in one thing.
struct Feature {
    const char* name;
    std::function<void(SoilDef&)> declare = [](SoilDef&) {};
    /// From the lower edge of each material but the first to the surface, as a share of the soil's
    /// height. The block goes through the upper fifth.
    std::vector<double> layers = {};
    double source_kg_s = 0;
    double sink_kg_s = 0;   ///< in the middle of its way
    bool has_dams = false;  ///< rock along the sides beside it, as high as the soil
};

MaterialDef named(const char* name) {
    MaterialDef material = pushed_material();
    material.name = name;
    return material;
}

void make_moist(SoilDef& def) {
    def.material.pore_water_fraction = 0.2;
    def.material.placed_saturation = 0.5;
    def.material.moist_cohesion_pa = 1000;
    def.material.conductivity_m_s = 1e-4;
}

void let_density_change(SoilDef& def) {
    def.material.loose_density_kg_m3 = 1800;
    def.material.compacted_density_kg_m3 = 2200;
}

std::vector<Feature> features() {
    const auto open_sides = [](SoilDef& def) { def.open_sides = kOpenLowY | kOpenHighY; };
    const auto two = [](SoilDef& def) { def.materials = {def.material, named("second")}; };
    return {
        {"plain"},
        {"cohesion of 1 kPa", [](SoilDef& def) { def.material.cohesion_pa = 1000; }},
        {"density that changes", let_density_change},
        {"peak friction by density",
         [](SoilDef& def) {
             let_density_change(def);
             def.material.dilatancy_angle_rad = 5 * std::numbers::pi / 180;
         }},
        {"cohesion of 1 kPa that moved soil keeps",
         [](SoilDef& def) {
             def.material.cohesion_pa = 1000;
             def.material.loose_cohesion_fraction = 1;
         }},
        {"cohesion of 1 kPa that compaction gives back",
         [](SoilDef& def) {
             let_density_change(def);
             def.material.cohesion_pa = 1000;
             def.material.compaction_cohesion_ratio = 0.1;
         }},
        {"a second material, not there", two},
        {"a second material, in the upper fifth", two, {0.2}},
        {"four materials, in the upper fifth",
         [](SoilDef& def) {
             def.materials = {def.material, named("second"), named("third"), named("fourth")};
         },
         {0.2, 0.13, 0.07}},
        {"slides with momentum", [](SoilDef& def) { def.slides = SlideMotion::run_out; }},
        {"roughness 0.1", [](SoilDef& def) { def.material.roughness = 0.1; }},
        {"viscosity 0.3", [](SoilDef& def) { def.material.viscosity = 0.3; }},
        {"a rough material, not there",
         [two](SoilDef& def) {
             two(def);
             def.materials[1].roughness = 0.1;
         }},
        {"moist, without rain", make_moist},
        {"moist, in rain of 36 mm/h",
         [](SoilDef& def) {
             make_moist(def);
             def.rain_m_s = 1e-5;
         }},
        {"moist, over groundwater",
         [](SoilDef& def) {
             make_moist(def);
             def.water_table_m = 0.5;
         }},
        {.name = "a source of 5 kg/s", .source_kg_s = 5},
        {.name = "a source of 5 kg/s, in air",
         .declare = [](SoilDef& def) { def.material.fall_speed_m_s = 1; },
         .source_kg_s = 5},
        {.name = "a source of 5 kg/s, in a gusty wind",
         .declare =
             [](SoilDef& def) {
                 def.material.fall_speed_m_s = 1;
                 def.wind_m_s = {0, 2, 0};
                 def.gust = 0.5;
             },
         .source_kg_s = 5},
        {.name = "a sink of 5 kg/s", .sink_kg_s = 5},
        {.name = "open sides, behind dams", .declare = open_sides, .has_dams = true},
        {.name = "open sides, over which the bed runs out", .declare = open_sides},
    };
}

struct FeatureCost {
    double step_ms = 0;  ///< processor time
    /// In a step, in each dispatch once; 0 where no kernels count.
    double changed_voxel_count = 0;
};

double changed_voxels(const WorkCounts& work) {
    double changed = 0;
    for (const PassWork& pass : work.passes) {
        changed += static_cast<double>(pass.voxel_changed_count);
    }
    return changed;
}

Result<FeatureCost> time_feature(const Feature& feature, FeatureDevice device) {
    constexpr double kSideM = kSide * PushingBlock::kVoxelM, kHalf = kSideM / 2;
    SoilDef def;
    def.material = pushed_material();
    def.size_m = {kSideM, kSideM, kSideM};
    def.voxel_m = PushingBlock::kVoxelM;
    def.up = UpAxis::z;
    def.backend = device.backend;
    def.thread_count = device.thread_count;
    feature.declare(def);
    auto made = Soil::create(def);
    if (!made) return Error{made.error()};
    Soil& soil = **made;
    if (feature.has_dams) {
        const Status dams = soil.add_terrain([](Vec3 at) {
            const double over_m = kHalf - at.z,
                         beside_m = std::abs(at.y) - kHalf + 2 * PushingBlock::kVoxelM;
            return std::min(over_m, beside_m);
        });
        if (!dams) return Error{dams.error()};
    }
    double from = 0;
    for (size_t m = 0; m <= feature.layers.size(); ++m) {
        const double to = m < feature.layers.size() ? (1 - feature.layers[m]) * kHalf : kHalf;
        const Status status = soil.fill(
            BoxFill{{{-kHalf, -kHalf, from}, {kHalf, kHalf, to}}, soil.materials()[m].name});
        if (!status) return Error{status.error()};
        from = to;
    }
    if (feature.source_kg_s > 0) {
        SourceDef source;
        source.center_m = {0, 0, kSideM * 0.9};
        source.radius_m = 0.2;
        source.rate_kg_s = feature.source_kg_s;
        if (const auto added = soil.add_source(source); !added) return Error{added.error()};
    }
    if (feature.sink_kg_s > 0) {
        SinkDef sink;
        sink.region.kind = ConvexShape::Kind::box;
        sink.region.half_extents_m = {0.2, 0.2, 0.2};
        sink.pose.position = {0, 0, kHalf};
        sink.rate_kg_s = feature.sink_kg_s;
        if (const auto added = soil.add_sink(sink); !added) return Error{added.error()};
    }
    PushingBlock block(kSideM, def.step_s);
    std::clock_t start = 0;
    double changed_before = 0;
    for (int step = 0; step < kWarmUpSteps + kSteps; ++step) {
        if (step == kWarmUpSteps) {
            changed_before = changed_voxels(soil.work_counts());
            start = std::clock();
        }
        soil.step({&block.at(step), 1});
    }
    FeatureCost cost;
    cost.step_ms = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * 1e3 / kSteps;
    cost.changed_voxel_count = (changed_voxels(soil.work_counts()) - changed_before) / kSteps;
    if (!soil.device_failure().empty()) return Error{soil.device_failure()};
    return cost;
}

/// How many voxels each soil changes in a step: the same on every machine.
Result<std::vector<double>> count_changes(const std::vector<Feature>& all) {
    const CountingKernels counting;
    std::vector<double> counts;
    for (const Feature& feature : all) {
        const auto cost = time_feature(feature, {Backend::cpu, 1});
        if (!cost) return Error{feature.name + std::string(": ") + cost.error()};
        counts.push_back(cost->changed_voxel_count);
    }
    return counts;
}

}  // namespace

Result<nlohmann::ordered_json> time_features(FeatureDevice device, int round_count,
                                             bool is_counted) {
    const std::vector<Feature> all = features();
    std::vector<double> best(all.size(), 1e30), changed;
    for (int round = 0; round < round_count; ++round) {
        for (size_t i = 0; i < all.size(); ++i) {
            const auto took = time_feature(all[i], device);
            if (!took) return Error{all[i].name + std::string(": ") + took.error()};
            best[i] = std::min(best[i], took->step_ms);
        }
    }
    if (is_counted) {
        auto counts = count_changes(all);
        if (!counts) return Error{counts.error()};
        changed = std::move(*counts);
    }
    nlohmann::ordered_json json;
    fmt::print(
        "Block pushing soil, {}^3 voxels, by feature: processor time of a step, the least of "
        "{} rounds; voxels changed in a step, and the time for one\n"
        "| soil | ms a step | of the plain one | changed | ns for one | of the plain one |\n"
        "|---|---|---|---|---|---|\n",
        kSide, round_count);
    for (size_t i = 0; i < all.size(); ++i) {
        fmt::print("| {} | {:.2f} | {:.2f} |", all[i].name, best[i], best[i] / best[0]);
        auto& row = json[all[i].name];
        row = {{"ms_a_step", best[i]}, {"of_plain", best[i] / best[0]}};
        if (is_counted) {
            const double ns = best[i] * 1e6 / changed[i];
            const double of_plain = ns / (best[0] * 1e6 / changed[0]);
            fmt::print(" {:.0f} | {:.0f} | {:.2f} |\n", changed[i], ns, of_plain);
            row["voxels_changed_a_step"] = changed[i];
            row["ns_for_one"] = ns;
            row["of_plain_for_one"] = of_plain;
        } else {
            fmt::print(" - | - | - |\n");
        }
    }
    fmt::print("\n");
    return json;
}

}  // namespace bsoil::command
