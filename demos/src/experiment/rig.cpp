#include "rig.h"

#include <algorithm>

#include "rig_world.h"

namespace bsoil::experiment {
namespace {

struct RigKind {
    std::string name, station;
    std::vector<std::string> results;
};

const std::vector<RigKind>& kinds() {
    static const std::vector<RigKind> all{
        {"plate", "sinkage_m", {"sinkage_m", "force_n", "pressure_pa"}},
        {"blade", "", {"draft_n", "draft_n_sd", "lift_n", "lift_n_sd"}},
        {"traction",
         "",
         {"drawbar_pull_n", "drawbar_pull_n_sd", "side_force_n", "side_force_n_sd", "tractive_n",
          "tractive_n_sd", "lateral_n", "lateral_n_sd", "vertical_load_n", "vertical_load_n_sd",
          "torque_n_m", "torque_n_m_sd", "sinkage_m", "sinkage_m_sd"}},
        {"shear",
         "displacement_m",
         {"displacement_m", "shear_stress_pa", "normal_stress_pa", "sinkage_m"}},
        {"column",
         "",
         {"slope_deg", "friction_deg", "steepest_deg", "height_m", "run_out", "rest_s"}},
    };
    return all;
}

const RigKind& kind_named(const std::string& name) {
    return *std::find_if(kinds().begin(), kinds().end(),
                         [&](const RigKind& kind) { return kind.name == name; });
}

}  // namespace

std::vector<std::string> rig_names() {
    std::vector<std::string> names;
    for (const RigKind& kind : kinds()) names.push_back(kind.name);
    return names;
}
const std::vector<std::string>& result_columns(const std::string& rig) {
    return kind_named(rig).results;
}
std::string station_column(const std::string& rig) { return kind_named(rig).station; }

Result<RigOutput> run_rig(const RigSetup& setup, const RigProgress& progress) {
    if (const auto* plate = std::get_if<PlateItem>(&setup.rig)) {
        return run_plate(setup, *plate, progress);
    }
    if (const auto* blade = std::get_if<BladeItem>(&setup.rig)) {
        return run_blade(setup, *blade, progress);
    }
    if (const auto* wheel = std::get_if<TractionItem>(&setup.rig)) {
        return run_traction(setup, *wheel, progress);
    }
    if (const auto* column = std::get_if<ColumnItem>(&setup.rig)) {
        return run_column(setup, *column, progress);
    }
    return run_shear(setup, std::get<ShearItem>(setup.rig), progress);
}

}  // namespace bsoil::experiment
