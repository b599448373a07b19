/// An experiment file in memory: one rig of terramechanics, the soil it stands on, the parameters
/// that are swept and what the results are compared with. The keys of the file are in
/// experiment_schema.cpp and demos/experiments/README.md.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "scene/scene.h"

namespace bsoil::experiment {

/// [bed]
struct BedItem : scene::SceneItem {
    double depth_m = 0.3;
};

/// [plate]
struct PlateItem : scene::SceneItem {
    std::string shape = "circle";
    double radius_m = 0.05;
    double length_m = 0.1, width_m = 0.1;
    double height_m = 0.02;
    std::vector<Vec3> points_m;
    double mass_kg = 50;
    double speed_m_s = 0.01;
    std::vector<double> reach_m;
    bool unload = false;
    std::vector<double> stations_m;
};

/// [blade]
struct BladeItem : scene::SceneItem {
    double width_m = 0.2, height_m = 0.4, thickness_m = 0.02;
    double rake_rad = 1.5707963267948966;
    double depth_m = 0.1;
    double speed_m_s = 0.1, lowering_speed_m_s = 0.1;
    double mass_kg = 50;
    double travel_m = 1, window_from_m = 0.5;
};

/// [traction]
struct TractionItem : scene::SceneItem {
    double radius_m = 0.1, width_m = 0.1;
    int grouser_count = 0;
    double grouser_height_m = 0.01, grouser_thickness_m = 0.003;
    double wheel_mass_kg = 2, carriage_mass_kg = 1;
    double load_n = 50;
    double slip_ratio = 0, slip_angle_rad = 0;
    double speed_m_s = 0.02;
    std::string held = "travel";
    double settle_s = 1;
    double travel_m = 0.5, window_from_m = 0.25;
    int earlier_passes = 0;
    double friction = 0.5;
    std::optional<double> rim_friction;
};

/// [shear]
struct ShearItem : scene::SceneItem {
    std::string head = "annulus";
    double outer_radius_m = 0.1, inner_radius_m = 0.07;
    double length_m = 0.1, width_m = 0.1;
    double height_m = 0.02;
    int grouser_count = 12;
    double grouser_height_m = 0.01, grouser_thickness_m = 0.003;
    double normal_stress_pa = 10e3;
    double mass_kg = 20;
    double speed_m_s = 0.005;
    double settle_s = 1;
    double displacement_m = 0.05;
    std::vector<double> stations_m;
    double friction = 0.5;
};

/// [column]
struct ColumnItem : scene::SceneItem {
    double radius_m = 0.5, height_m = 1;
    double duration_s = 60;
};

/// The rig of an experiment: its table.
using RigItem = std::variant<PlateItem, BladeItem, TractionItem, ShearItem, ColumnItem>;

/// One run: a rig with all its parameters and the soil it stands on.
struct RigSetup {
    scene::Scene scene;  ///< world, soil, materials; the rig adds its bodies and joints
    BedItem bed;
    RigItem rig;
};

/// Value of a parameter: a number or a word.
struct Parameter {
    std::string name;  ///< "depth_m", "soil.voxel_m"
    std::string text;
    std::optional<double> number;
};

/// A point of the sweep.
struct Point {
    std::vector<Parameter> parameters;  ///< those that are swept, in the order of the file
    RigSetup setup;
};

/// [[measured.column]]
struct MeasuredColumnItem : scene::SceneItem {
    std::string name, column;
    double factor = 1;
    std::map<std::string, double> values;  ///< what words of the file stand for; empty: numbers
};
/// [[measured.where]]
struct MeasuredFilterItem : scene::SceneItem {
    std::string column;
    std::vector<std::string> equals;  ///< any of these
};
/// [measured]
struct MeasuredItem : scene::SceneItem {
    std::string file, label = "measured";
    std::vector<MeasuredColumnItem> columns;
    std::vector<MeasuredFilterItem> filters;
};

/// [[plot]]
struct PlotItem : scene::SceneItem {
    std::string x, y, title;
    std::vector<std::string> by;
    bool log_x = false, log_y = false;
};

/// Holds for rows with this value in a column, or with one between `from` and `to`.
struct RowCondition {
    std::string column, text;
    std::optional<double> from, to;
};

/// What [[expect]] and [[validation.compare]] share: figures taken from rows of the results.
struct FigureItem : scene::SceneItem {
    std::string title, column;
    std::vector<RowCondition> at_values;
    std::string statistic = "each";
    std::string over;             ///< the column that some statistics follow
    std::vector<std::string> by;  ///< rows that agree in these columns give one figure
};

/// [[expect]]
struct ExpectItem : FigureItem {
    std::optional<double> value, tolerance, min, max;
};

/// [[validation.compare]]
struct CompareItem : FigureItem {
    bool of_load = false;
    std::optional<double> aim;
};

/// [validation]
struct ValidationItem : scene::SceneItem {
    std::string classical;       ///< "bekker", "wong_reece", "mckyes_ali", "janosi"
    std::string classical_note;  ///< where its parameters are from
    std::string bekker_plates;   ///< the experiment whose measured plates give Bekker's parameters
    std::optional<double> bekker_kc_kn_m_np1, bekker_kphi_kn_m_np2, bekker_n;
    double peak_stress_c1 = 0.18, peak_stress_c2 = 0.32;
    double janosi_k_m = 0;  ///< of the classical model; 0: the material's
    std::vector<CompareItem> compares;
};

/// Measured rows in the experiment's own names and units.
struct MeasuredTable {
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows;
};

/// A whole experiment.
struct Experiment {
    std::string path, title, description;
    std::string rig;  ///< "plate", "blade", "traction", "shear", "column"
    std::optional<MeasuredItem> measured_item;
    MeasuredTable measured;  ///< empty where the file has none or the data is absent
    std::vector<PlotItem> plots;
    std::vector<ExpectItem> expectations;
    std::optional<ValidationItem> validation;
    std::vector<Point> points;
    std::string missing_data;         ///< name of the measured data that is not there, or empty
    bool points_are_missing = false;  ///< the points were to be taken from that data
};

}  // namespace bsoil::experiment
