#include "feature_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "pushing_block.h"

namespace bsoil::command {
namespace {

constexpr int kSide = 56;         // voxels, the smallest cube of the thesis
constexpr int kWarmUpSteps = 20;  // as for the other figures
constexpr int kSteps = 150;       // once to the other side and part of the way back

/// A soil that differs from the plain one in one thing.
struct Feature {
    const char* name;
    std::function<void(SoilDef&)> declare = [](SoilDef&) {};
    bool has_layers = false;  ///< the upper fifth of the soil is of the second material
    double source_kg_s = 0;
};

MaterialDef named(const char* name) {
    MaterialDef material = pushed_material();
    material.name = name;
    return material;
}

std::vector<Feature> features() {
    const auto two = [](SoilDef& def) { def.materials = {def.material, named("second")}; };
    return {
        {"plain"},
        {"cohesion of 1 kPa", [](SoilDef& def) { def.material.cohesion_pa = 1000; }},
        {"density that changes",
         [](SoilDef& def) {
             def.material.loose_density_kg_m3 = 1800;
             def.material.compacted_density_kg_m3 = 2200;
         }},
        {"a second material, not there", two},
        {"a second material, in the upper fifth", two, true},
        {"slides with momentum", [](SoilDef& def) { def.slides = SlideMotion::run_out; }},
        {"roughness 0.1", [](SoilDef& def) { def.material.roughness = 0.1; }},
        {"viscosity 0.3", [](SoilDef& def) { def.material.viscosity = 0.3; }},
        {"a rough material, not there",
         [two](SoilDef& def) {
             two(def);
             def.materials[1].roughness = 0.1;
         }},
        {"moist, without rain",
         [](SoilDef& def) {
             def.material.pore_water_fraction = 0.2;
             def.material.placed_saturation = 0.5;
             def.material.moist_cohesion_pa = 1000;
             def.material.conductivity_m_s = 1e-4;
         }},
        {"a source of 5 kg/s", [](SoilDef&) {}, false, 5},
    };
}

/// Processor time of a step [ms].
Result<double> time_feature(const Feature& feature, FeatureDevice device) {
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
    const double upper = feature.has_layers ? 0.8 * kHalf : kHalf;
    Status status = soil.fill(BoxFill{{{-kHalf, -kHalf, 0}, {kHalf, kHalf, upper}}, {}});
    if (status && feature.has_layers) {
        status = soil.fill(BoxFill{{{-kHalf, -kHalf, upper}, {kHalf, kHalf, kHalf}}, "second"});
    }
    if (!status) return Error{status.error()};
    if (feature.source_kg_s > 0) {
        SourceDef source;
        source.center_m = {0, 0, kSideM * 0.9};
        source.radius_m = 0.2;
        source.rate_kg_s = feature.source_kg_s;
        if (const auto added = soil.add_source(source); !added) return Error{added.error()};
    }
    PushingBlock block(kSideM, def.step_s);
    std::clock_t start = 0;
    for (int step = 0; step < kWarmUpSteps + kSteps; ++step) {
        if (step == kWarmUpSteps) start = std::clock();
        soil.step({&block.at(step), 1});
    }
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * 1e3 / kSteps;
}

}  // namespace

Result<nlohmann::ordered_json> time_features(FeatureDevice device, int round_count) {
    const std::vector<Feature> all = features();
    std::vector<double> best(all.size(), 1e30);
    for (int round = 0; round < round_count; ++round) {
        for (size_t i = 0; i < all.size(); ++i) {
            const auto took = time_feature(all[i], device);
            if (!took) return Error{all[i].name + std::string(": ") + took.error()};
            best[i] = std::min(best[i], *took);
        }
    }
    nlohmann::ordered_json json;
    fmt::print(
        "Block pushing soil, {}^3 voxels, by feature: processor time of a step, the least of "
        "{} rounds\n| soil | ms a step | of the plain one |\n|---|---|---|\n",
        kSide, round_count);
    for (size_t i = 0; i < all.size(); ++i) {
        fmt::print("| {} | {:.2f} | {:.2f} |\n", all[i].name, best[i], best[i] / best[0]);
        json[all[i].name] = {{"ms_a_step", best[i]}, {"of_plain", best[i] / best[0]}};
    }
    fmt::print("\n");
    return json;
}

}  // namespace bsoil::command
