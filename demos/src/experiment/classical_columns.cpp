#include "classical_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "classical_models.h"
#include "experiment_load.h"
#include "measured_data.h"

namespace bsoil::experiment {
namespace {

/// Figures of one row, by column.
using Figures = std::map<std::string, double>;

double column_of(const MeasuredTable& table, size_t row, const std::string& name, double fallback) {
    const auto found = std::find(table.columns.begin(), table.columns.end(), name);
    return found == table.columns.end()
               ? fallback
               : table.rows[row][static_cast<size_t>(found - table.columns.begin())];
}

/// Measured rows that agree with a point's parameters in all but one.
std::vector<size_t> rows_of(const MeasuredTable& measured, const std::vector<Parameter>& parameters,
                            const std::string& but) {
    std::vector<size_t> rows;
    for (size_t r = 0; r < measured.rows.size(); ++r) {
        const auto agrees = [&](const Parameter& p) {
            return p.name == but || !p.number ||
                   same_value(column_of(measured, r, p.name, *p.number), *p.number);
        };
        if (std::all_of(parameters.begin(), parameters.end(), agrees)) rows.push_back(r);
    }
    return rows;
}

/// Measured plates of all sizes in the soil that the parameters give; without any, all plates.
std::vector<PlateReading> plate_readings(const Experiment& experiment,
                                         const std::vector<Parameter>& parameters) {
    const double radius_m = std::get<PlateItem>(experiment.points.front().setup.rig).radius_m;
    const MeasuredTable& measured = experiment.measured;
    std::vector<PlateReading> readings;
    for (const size_t r : rows_of(measured, parameters, "radius_m")) {
        readings.push_back({column_of(measured, r, "radius_m", radius_m),
                            column_of(measured, r, "sinkage_m", 0),
                            column_of(measured, r, "pressure_pa", 0)});
    }
    return readings;
}

std::string text_of(const BekkerSoil& soil) {
    return fmt::format("kc = {:.4g} kN/m^(n+1), kphi = {:.5g} kN/m^(n+2), n = {:.3f}",
                       soil.kc / 1e3, soil.kphi / 1e3, soil.n);
}

class ClassicalModel {
  public:
    explicit ClassicalModel(const Experiment& experiment)
        : experiment_(experiment), item_(*experiment.validation) {}

    Status prepare() {
        const std::string& rig = experiment_.rig;
        if ((item_.classical == "bekker") != (rig == "plate") ||
            (item_.classical == "wong_reece") != (rig == "traction") ||
            (item_.classical == "mckyes_ali") != (rig == "blade") ||
            (item_.classical == "janosi") != (rig == "shear")) {
            return wrong("classical",
                         item_.classical + " is no model of this rig; take one that is");
        }
        for (const Point& point : experiment_.points) {
            if (!point.setup.scene.soil) return wrong("classical", "there is no [soil]; add it");
        }
        if (rig == "traction") return take_bekker();
        for (const Point& point : experiment_.points) {
            if (rig == "plate") fit_plates(point);
            if (rig == "shear") fit_shear(point);
        }
        return Done{};
    }

    const std::string& parameters() const { return parameters_; }

    Figures figures(const CsvTable& results, size_t row) const {
        const auto point_index = static_cast<size_t>(*results.number(row, "point"));
        const RigSetup& setup = experiment_.points[point_index].setup;
        if (const auto* plate = std::get_if<PlateItem>(&setup.rig)) {
            const double pressure_pa = bekker_pressure_pa(bekker_[point_index], plate->radius_m,
                                                          *results.number(row, "sinkage_m"));
            return {{"pressure_pa", pressure_pa}};
        }
        if (const auto* blade = std::get_if<BladeItem>(&setup.rig)) return of_blade(setup, *blade);
        if (const auto* wheel = std::get_if<TractionItem>(&setup.rig)) {
            return of_wheel(setup, *wheel);
        }
        return {{"shear_stress_pa",
                 curves_[point_index].at_pa(*results.number(row, "displacement_m"))}};
    }

  private:
    Error wrong(const std::string& key, const std::string& text) const {
        return {fmt::format("{}:{}: `{}`: {}", experiment_.path, item_.where(key).line, key, text)};
    }

    static const MaterialDef& material_of(const RigSetup& setup) {
        return setup.scene.soil->def.materials.front();
    }
    ShearSoil shear_of(const RigSetup& setup) const {
        const MaterialDef& material = material_of(setup);
        return {material.cohesion_pa, material.friction_angle_rad,
                item_.janosi_k_m > 0 ? item_.janosi_k_m : material.shear_displacement_m};
    }

    void fit_plates(const Point& point) {
        bekker_.push_back(fit_bekker(plate_readings(experiment_, point.parameters)));
        add_parameters(text_of(bekker_.back()));
    }

    void fit_shear(const Point& point) {
        std::vector<ShearReading> readings;
        for (const size_t r : rows_of(experiment_.measured, point.parameters, "")) {
            readings.push_back({column_of(experiment_.measured, r, "displacement_m", 0),
                                column_of(experiment_.measured, r, "shear_stress_pa", 0)});
        }
        const JanosiCurve& curve = curves_.emplace_back(fit_janosi(readings));
        add_parameters(fmt::format("strength {:.3g} kPa, K = {:.3g} mm", curve.stress_pa / 1e3,
                                   curve.k_m * 1e3));
    }

    /// Points with the same parameters are named once.
    void add_parameters(const std::string& text) {
        if (parameters_.find(text) == std::string::npos) {
            parameters_ += (parameters_.empty() ? "" : "; ") + text;
        }
    }

    Status take_bekker() {
        BekkerSoil soil;
        if (!item_.bekker_plates.empty()) {
            const auto folder = std::filesystem::path(experiment_.path).parent_path();
            const auto plates = load_experiment((folder / item_.bekker_plates).string(), "plate");
            if (!plates) return Error{plates.error()};
            if (plates->measured.rows.empty()) {
                return wrong(
                    "bekker_plates",
                    item_.bekker_plates + " has no measurements; name an experiment that has");
            }
            soil = fit_bekker(plate_readings(*plates, {}));
        } else if (item_.bekker_kc_kn_m_np1 && item_.bekker_kphi_kn_m_np2 && item_.bekker_n) {
            soil = {*item_.bekker_kc_kn_m_np1 * 1e3, *item_.bekker_kphi_kn_m_np2 * 1e3,
                    *item_.bekker_n};
        } else {
            return wrong("classical", "needs `bekker_plates`, or kc, kphi and n");
        }
        bekker_ = {soil};
        parameters_ = text_of(soil);
        return Done{};
    }

    Figures of_blade(const RigSetup& setup, const BladeItem& blade) const {
        const MaterialDef& material = material_of(setup);
        const WedgeForce force = mckyes_ali_wedge(
            {blade.width_m, blade.depth_m, blade.rake_rad, std::atan(material.tool_friction)},
            material.density_kg_m3 * setup.scene.world.gravity_m_s2, material.friction_angle_rad);
        return {{"draft_n", force.draft_n}, {"lift_n", force.lift_n}};
    }

    Figures of_wheel(const RigSetup& setup, const TractionItem& wheel) const {
        const double lug_m = wheel.grouser_count > 0 ? wheel.grouser_height_m : 0;
        const WheelForces force = wong_reece_wheel(
            {wheel.radius_m, wheel.radius_m + lug_m, wheel.width_m, wheel.load_n, wheel.slip_ratio,
             wheel.slip_angle_rad, item_.peak_stress_c1, item_.peak_stress_c2},
            bekker_.front(), shear_of(setup));
        const double c = std::cos(wheel.slip_angle_rad), s = std::sin(wheel.slip_angle_rad);
        return {{"drawbar_pull_n", c * force.tractive_n - s * force.lateral_n},
                {"side_force_n", s * force.tractive_n + c * force.lateral_n},
                {"tractive_n", force.tractive_n},
                {"lateral_n", force.lateral_n},
                {"torque_n_m", force.torque_n_m},
                {"sinkage_m", force.sinkage_m}};
    }

    const Experiment& experiment_;
    const ValidationItem& item_;
    std::vector<BekkerSoil> bekker_;   ///< of plates: for each point
    std::vector<JanosiCurve> curves_;  ///< of shear: for each point
    std::string parameters_;
};

}  // namespace

std::string classical_name(const std::string& classical) {
    static const std::map<std::string, std::string> names{{"bekker", "Bekker"},
                                                          {"wong_reece", "Bekker, Wong and Reece"},
                                                          {"mckyes_ali", "McKyes and Ali"},
                                                          {"janosi", "Mohr-Coulomb, Janosi"}};
    return names.at(classical);
}

Result<std::string> add_classical(CsvTable& results, const Experiment& experiment) {
    ClassicalModel model(experiment);
    const Status prepared = model.prepare();
    if (!prepared) return Error{prepared.error()};
    for (size_t r = 0; r < results.rows.size(); ++r) {
        const Figures figures = model.figures(results, r);
        for (const auto& [name, figure] : figures) {
            if (r == 0) results.columns.push_back(name + "_classical");
            results.rows[r].push_back(cell(figure));
            if (results.column_index(name + "_measured") < 0) continue;
            if (r == 0) results.columns.push_back(name + "_classical_error");
            const auto measured = results.number(r, name + "_measured");
            results.rows[r].push_back(measured && *measured != 0 ? cell(figure / *measured - 1)
                                                                 : "");
        }
    }
    return model.parameters();
}

}  // namespace bsoil::experiment
