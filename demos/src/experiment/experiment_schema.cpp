#include "experiment_schema.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiment_load.h"
#include "figures.h"

namespace bsoil::experiment {
namespace {

using scene::kDegree;
using scene::Range;
using scene::TableOf;

constexpr Range kSize{1e-3, 100};  // [m] of a tool
constexpr Range kWay{1e-4, 1e3};   // [m]
constexpr Range kMass{1e-3, 1e6};  // [kg]
constexpr Range kSpeed{1e-5, 10};  // [m/s]
constexpr Range kTime{0, 1e4};     // [s]
constexpr Range kAnything{-1e30, 1e30};

TableOf<ExperimentWorld> world_table() {
    using W = ExperimentWorld;
    return TableOf<W>("world", false, "The Bullet world. Up is z, tools travel along x.")
        .number("gravity_m_s2", &W::gravity_m_s2, {0, 30}, "gravity along -z, also of the soil")
        .number("substep_s", &W::substep_s, {1e-4, 0.05},
                "Bullet's fixed step; a step of the soil is cut into a whole number of them")
        .integer("solver_iterations", &W::solver_iterations, {1, 10000},
                 "iterations of Bullet's constraint solver")
        .flag("ground_plane", &W::ground_plane,
              "a rigid plane at height 0 in place of [soil]: the rig then measures statics and "
              "Coulomb's friction");
}

TableOf<BedItem> bed_table() {
    return TableOf<BedItem>("bed", false,
                            "The soil is a level bed over the grid's whole floor. Rigs stand at "
                            "its centre or travel through it along x.")
        .number("depth_m", &BedItem::depth_m, kWay, "height of the free surface above the floor");
}

TableOf<PlateItem> plate_table() {
    using P = PlateItem;
    return TableOf<P>("plate", false,
                      "A press: a plate on a vertical slider with a motor. Results, one row for "
                      "each station: `sinkage_m`, `force_n` (of the slider on the plate less the "
                      "plate's weight), `pressure_pa` (force over the area seen from above).")
        .selected_by("shape")
        .word("shape", &P::shape, {"circle", "rectangle", "cone", "hull"},
              "circle and rectangle are level, a cone points down; sinkage counts from the "
              "lowest point")
        .number("radius_m", &P::radius_m, kSize, "radius; of a cone: of its base")
        .only({"circle", "cone"})
        .number("length_m", &P::length_m, kSize, "edge along x")
        .only({"rectangle"})
        .number("width_m", &P::width_m, kSize, "edge along y")
        .only({"rectangle"})
        .number("height_m", &P::height_m, kSize, "thickness; of a cone: from apex to base")
        .only({"circle", "rectangle", "cone"})
        .points("points_m", &P::points_m, {-100, 100},
                "points whose convex hull is pressed in; z points up")
        .only({"hull"})
        .number("mass_kg", &P::mass_kg, kMass,
                "mass of the plate; a heavy one keeps its speed against a strong soil")
        .number("speed_m_s", &P::speed_m_s, kSpeed, "speed of pressing and of unloading")
        .numbers("reach_m", &P::reach_m, kWay,
                 "sinkages the plate is pressed to, one after another")
        .required()
        .flag("unload", &P::unload, "after each of them the plate is raised until its force is 0")
        .numbers("stations_m", &P::stations_m, kWay,
                 "sinkages at which a row is recorded, on the first way down; those of `reach_m` "
                 "where the key is missing");
}

TableOf<BladeItem> blade_table() {
    using B = BladeItem;
    return TableOf<B>("blade", false,
                      "A blade on a carriage that is lowered and then drawn along x at constant "
                      "speed. Its weight is balanced. Results, one row for each point: mean and "
                      "standard deviation (`_sd`) of `draft_n` (against the travel) and `lift_n` "
                      "(up) of the joint that holds the blade.")
        .number("width_m", &B::width_m, kSize, "edge across the travel")
        .number("height_m", &B::height_m, kSize, "edge along the face, from the tip")
        .number("thickness_m", &B::thickness_m, kSize, "edge square to the face")
        .number("rake_deg", &B::rake_rad, {15, 165},
                "angle between face and horizontal, before the tip: 90 upright, less leans back",
                kDegree)
        .number("depth_m", &B::depth_m, kWay, "of the tip below the free surface")
        .number("speed_m_s", &B::speed_m_s, kSpeed, "speed of the carriage")
        .number("lowering_speed_m_s", &B::lowering_speed_m_s, kSpeed,
                "speed at which the blade is lowered before the travel")
        .number("mass_kg", &B::mass_kg, kMass, "mass of the blade")
        .number("travel_m", &B::travel_m, kWay, "length of the travel")
        .number("window_from_m", &B::window_from_m, {0, 1e3},
                "means are taken from this way on to the end of the travel");
}

TableOf<TractionItem> traction_table() {
    using T = TractionItem;
    return TableOf<T>(
               "traction", false,
               "A wheel with a motor on a carriage that is drawn along x and free to move up and "
               "down. Slip ratio s: rim speed = travel speed / (1 - s) for s >= 0 and travel "
               "speed * (1 + s) for s < 0; -1 is a locked wheel. Results, one row for each point, "
               "mean and standard deviation (`_sd`): `drawbar_pull_n` and `side_force_n` (of the "
               "wheel on the carriage along the travel and to its left), `tractive_n` and "
               "`lateral_n` (the same along the wheel's heading and to its left), "
               "`vertical_load_n` (of the wheel on the soil), `torque_n_m` (of the motor, driving "
               "forward positive), `sinkage_m` (of the rim's lowest point, without grousers, "
               "below the free surface at the start).")
        .number("radius_m", &T::radius_m, kSize, "of the rim, without grousers")
        .number("width_m", &T::width_m, kSize, "of rim and grousers")
        .integer("grouser_count", &T::grouser_count, {0, 200}, "boxes spread over the rim")
        .number("grouser_height_m", &T::grouser_height_m, {0, 100}, "beyond the rim")
        .number("grouser_thickness_m", &T::grouser_thickness_m, {1e-4, 100}, "along the rim")
        .number("wheel_mass_kg", &T::wheel_mass_kg, kMass, "of the wheel")
        .number("carriage_mass_kg", &T::carriage_mass_kg, kMass,
                "of what moves up and down with the wheel")
        .number("load_n", &T::load_n, {0, 1e7},
                "vertical load on the soil: both weights and a constant force up or down")
        .number("slip_ratio", &T::slip_ratio, {-1, 1}, "see above")
        .number("slip_angle_deg", &T::slip_angle_rad, {-90, 90},
                "from the travel to the wheel's heading, to the left positive", kDegree)
        .number("speed_m_s", &T::speed_m_s, kSpeed, "the speed that is held")
        .word("held", &T::held, {"travel", "rim"},
              "which speed is held while the other follows from the slip ratio")
        .number("settle_s", &T::settle_s, kTime,
                "before the travel: the load is raised from 0 to its value")
        .number("travel_m", &T::travel_m, kWay, "way covered at the speed that is held")
        .number("window_from_m", &T::window_from_m, {0, 1e3},
                "means are taken from this way on to the end of the travel")
        .integer("earlier_passes", &T::earlier_passes, {0, 100},
                 "over the same bed, each like the one that is measured; the wheel is lifted back "
                 "between them, and the sinkage is that below the free surface before the first")
        .number("friction", &T::friction, {0, 10},
                "Coulomb friction with a rigid plane; with soil the material's counts")
        .number("rim_friction", &T::rim_friction, {0, 2},
                "with soil, of a wheel without grousers; the material's where the key is missing. "
                "Grousers hold the soil between them: it shears on itself");
}

TableOf<ShearItem> shear_table() {
    using S = ShearItem;
    return TableOf<S>(
               "shear", false,
               "A shear head under constant normal load: an annulus that turns, or a box that is "
               "drawn along x. Results, one row for each station: `displacement_m` (at the "
               "annulus' mean radius), `shear_stress_pa` (of the annulus: 3 M / (2 pi (r_o^3 - "
               "r_i^3)); of the box: force / area), `normal_stress_pa`, `sinkage_m`.")
        .selected_by("head")
        .word("head", &S::head, {"annulus", "box"}, "the form of the shear head")
        .number("outer_radius_m", &S::outer_radius_m, kSize, "of the annulus")
        .only({"annulus"})
        .number("inner_radius_m", &S::inner_radius_m, kSize, "of the annulus")
        .only({"annulus"})
        .number("length_m", &S::length_m, kSize, "of the box, along the travel")
        .only({"box"})
        .number("width_m", &S::width_m, kSize, "of the box, across the travel")
        .only({"box"})
        .number("height_m", &S::height_m, kSize, "of the plate, without grousers")
        .integer("grouser_count", &S::grouser_count, {0, 200},
                 "vanes below the plate, spread evenly")
        .number("grouser_height_m", &S::grouser_height_m, {0, 100}, "below the plate")
        .number("grouser_thickness_m", &S::grouser_thickness_m, {1e-4, 100}, "along the motion")
        .number("normal_stress_pa", &S::normal_stress_pa, {0, 1e8},
                "vertical load over the plate's area")
        .number("mass_kg", &S::mass_kg, kMass, "of the head")
        .number("speed_m_s", &S::speed_m_s, kSpeed, "of the head, of an annulus at its mean radius")
        .number("settle_s", &S::settle_s, kTime,
                "before the shearing: the load is raised from 0 to its value")
        .number("displacement_m", &S::displacement_m, kWay, "length of the way")
        .numbers("stations_m", &S::stations_m, kWay,
                 "displacements at which a row is recorded; ten evenly spaced where the key is "
                 "missing")
        .number("friction", &S::friction, {0, 10},
                "Coulomb friction with a rigid plane; with soil the material's counts");
}

TableOf<ColumnItem> column_table() {
    using C = ColumnItem;
    return TableOf<C>(
               "column", false,
               "A round column of soil as placed stands free on the middle of the grid's floor and "
               "comes down. There is no bed. Results, one row for each point, of the heap at rest: "
               "`slope_deg` (of its flank; 90 where less than 1 % of the soil left its place), "
               "`friction_deg` (phi, which soil without cohesion rests at), `steepest_deg` "
               "(Culmann's steepest face that stands with a heap's height), `height_m`, `run_out` "
               "(how much further than the column its soil lies, in radii), `rest_s` (when nothing "
               "moved any more).")
        .number("radius_m", &C::radius_m, kSize, "radius of the column")
        .number("height_m", &C::height_m, kSize, "its height")
        .number("duration_s", &C::duration_s, {0.1, 1e4},
                "a heap that still moves then fails, like an expectation");
}

/// Stores numbers or texts in place.
std::function<std::string(MeasuredFilterItem&, const toml::node&)> read_filter() {
    return [](MeasuredFilterItem& item, const toml::node& value) -> std::string {
        const auto take = [&](const toml::node& node) {
            const auto given = parameter_of("equals", node);
            if (given) item.equals.push_back(given->text);
            return given.has_value();
        };
        const toml::array* list = value.as_array();
        const bool taken =
            list ? !list->empty() && std::all_of(list->begin(), list->end(), take) : take(value);
        return taken ? "" : "expected a value or a list, not " + scene::kind_text(value);
    };
}

/// Stores what the words of a column stand for.
std::string read_words(MeasuredColumnItem& item, const toml::node& value) {
    const toml::table* table = value.as_table();
    if (!table) return "expected a table, not " + scene::kind_text(value);
    for (const auto& [word, node] : *table) {
        if (!node.is_number()) return "expected numbers, not " + scene::kind_text(node);
        item.values[std::string(word.str())] = scene::number_of(node);
    }
    return {};
}

/// A value, or the two ends of a range.
std::optional<RowCondition> condition_of(const std::string& column, const toml::node& value) {
    if (const toml::array* ends = value.as_array()) {
        if (ends->size() != 2 || !ends->get(0)->is_number() || !ends->get(1)->is_number()) {
            return std::nullopt;
        }
        return RowCondition{column, "", scene::number_of(*ends->get(0)),
                            scene::number_of(*ends->get(1))};
    }
    const auto given = parameter_of(column, value);
    if (!given) return std::nullopt;
    return RowCondition{column, given->text, given->number, std::nullopt};
}

/// The keys of figures taken from rows of the results.
template <typename T>
TableOf<T> figure_table(const std::string& name, const std::string& doc) {
    return TableOf<T>(name, true, doc)
        .text("title", &T::title, "what it is, in words")
        .text("column", &T::column, "column of the results")
        .required()
        .value("at", "{name = value or [from, to], ...}",
               "only rows with these values in these columns; all rows where the key is missing",
               [](T& item, const toml::node& value) -> std::string {
                   const toml::table* table = value.as_table();
                   if (!table) return "expected a table, not " + scene::kind_text(value);
                   std::string error;
                   flatten(*table, "", [&](const std::string& path, const toml::node& leaf) {
                       if (auto condition = condition_of(path, leaf)) {
                           item.at_values.push_back(std::move(*condition));
                       } else {
                           error = "expected a value or two numbers, not " + scene::kind_text(leaf);
                       }
                   });
                   return error;
               })
        .word("statistic", &T::statistic, statistic_names(),
              "of the rows. magnitude: of the absolute values; spread: largest less least; "
              "deviation: the largest distance from the first row's, as a share of that; last: of "
              "the last row; and along `over`: least_rise from one row to the next, exponent of "
              "the power law through the rows, janosi_k: where 1 - 1/e of the largest is reached")
        .text("over", &T::over, "the column along which these look")
        .texts("by", &T::by,
               "rows that agree in these columns give a figure each; without it, all rows one");
}

TableOf<MeasuredItem> measured_table() {
    using M = MeasuredItem;
    using C = MeasuredColumnItem;
    const TableOf<C> column =
        TableOf<C>("measured.column", true, "One column of the file, in the experiment's terms.")
            .text("name", &C::name, "a parameter of the sweep or a column of the results")
            .required()
            .text("column", &C::column, "its heading in the file")
            .required()
            .number("factor", &C::factor, kAnything, "turns the file's unit into that of `name`")
            .value("values", "{word = number, ...}",
                   "what the file's words stand for; rows with other words are left out",
                   read_words);
    const TableOf<MeasuredFilterItem> filter =
        TableOf<MeasuredFilterItem>("measured.where", true, "Only rows where this holds are taken.")
            .text("column", &MeasuredFilterItem::column, "a heading in the file")
            .required()
            .value("equals", "text, number or list", "what stands there, any of a list",
                   read_filter())
            .required();
    return TableOf<M>(
               "measured", false,
               "Measured data to stand beside the results. A result is compared with the mean of "
               "the rows that agree with it in every parameter of the sweep, and at the station, "
               "that the data has columns for; `NAME_measured` and the relative error `NAME_error` "
               "are then columns of the results.")
        .text("file", &M::file,
              "a CSV file with headings: beside the experiment, or data:PATH for a file under "
              "$BULLETSOIL_DATA (else `shared/data` beside the project)")
        .required()
        .text("label", &M::label, "what the plot calls it")
        .child<C>("column", column, [](M& m) { return &m.columns.emplace_back(); })
        .required()
        .child<MeasuredFilterItem>("where", filter, [](M& m) { return &m.filters.emplace_back(); });
}

TableOf<PlotItem> plot_table() {
    using P = PlotItem;
    return TableOf<P>("plot", true,
                      "A panel of the plot. Without one, each result is drawn over the first "
                      "parameter of the sweep, or over the station.")
        .text("x", &P::x, "column of the results")
        .required()
        .text("y", &P::y, "column of the results")
        .required()
        .texts("by", &P::by,
               "parameters each value of which has a curve of its own; all but `x` where the key "
               "is missing")
        .text("title", &P::title, "above the panel")
        .flag("log_x", &P::log_x, "logarithmic axis")
        .flag("log_y", &P::log_y, "logarithmic axis");
}

TableOf<ExpectItem> expect_table() {
    using E = ExpectItem;
    return figure_table<E>("expect",
                           "Something the results have to show; it prints PASS or FAIL and the "
                           "figure. A row or a "
                           "group without a figure fails, but of measured values and errors.")
        .number("value", &E::value, kAnything, "the figure expected; needs `tolerance`")
        .number("tolerance", &E::tolerance, {0, 1e30}, "on either side, in the column's unit")
        .number("min", &E::min, kAnything, "least figure")
        .number("max", &E::max, kAnything, "largest figure");
}

TableOf<ValidationItem> validation_table() {
    using V = ValidationItem;
    using C = CompareItem;
    const TableOf<C> compare =
        figure_table<C>("validation.compare",
                        "A result that is compared with the measured and the classical one.")
            .flag("of_load", &C::of_load,
                  "a force that may be near zero: its error is also given as a share of the load, "
                  "and the relative one only where the measured force exceeds 3 % of the load")
            .number("aim", &C::aim, {0, 10}, "for the median of the relative error's magnitude");
    return TableOf<V>("validation", false,
                      "The experiment is part of `bsoil validate`: its results stand beside "
                      "measurements and a classical model, in columns `NAME_classical` and "
                      "`NAME_classical_error`. Density, friction angle, cohesion, tool friction "
                      "and K of the classical model are those of the experiment's material.")
        .word("classical", &V::classical, {"bekker", "wong_reece", "mckyes_ali", "janosi"},
              "the model: of plates, wheels, blades, shear")
        .required()
        .text("classical_note", &V::classical_note, "where its parameters are from")
        .number("bekker_kc_kn_m_np1", &V::bekker_kc_kn_m_np1, {-1e6, 1e6},
                "kc in p = (kc / b + kphi) z^n, in kN/m^(n+1)")
        .number("bekker_kphi_kn_m_np2", &V::bekker_kphi_kn_m_np2, {-1e6, 1e6},
                "kphi, in kN/m^(n+2)")
        .number("bekker_n", &V::bekker_n, {0, 5}, "n")
        .text("bekker_plates", &V::bekker_plates,
              "instead of these three: the experiment beside this one whose measured plates they "
              "are fitted to; plates themselves are fitted to their own measurements")
        .number("janosi_k_m", &V::janosi_k_m, {0, 0.2},
                "Janosi's K of the classical model; 0: that of the material")
        .number("peak_stress_c1", &V::peak_stress_c1, {0, 1},
                "the normal stress under a wheel is largest at c1 + c2 slip of the entry angle")
        .number("peak_stress_c2", &V::peak_stress_c2, {0, 1}, "c2")
        .child<C>("compare", compare, [](V& v) { return &v.compares.emplace_back(); })
        .required();
}

/// A rig's table: the rig it makes is the last one in the file, and its name is kept to find two.
template <typename T>
void add_rig(TableOf<ExperimentFile>& file, const std::string& name, const TableOf<T>& table) {
    file.child<T>(name, table, [name](ExperimentFile& f) {
        f.rigs.push_back(name);
        return &f.setup.rig.emplace<T>();
    });
}

}  // namespace

std::optional<Parameter> parameter_of(const std::string& name, const toml::node& value) {
    if (value.is_string()) return Parameter{name, value.as_string()->get(), {}};
    if (value.is_boolean()) {
        return Parameter{name, value.as_boolean()->get() ? "true" : "false", {}};
    }
    if (!value.is_number()) return std::nullopt;
    const double number = scene::number_of(value);
    return Parameter{name, fmt::format("{:.6g}", number), number};
}

void flatten(const toml::table& table, const std::string& prefix,
             const std::function<void(const std::string&, const toml::node&)>& visit) {
    for (const auto& [key, value] : table) {
        const std::string path = prefix + std::string(key.str());
        if (const toml::table* inner = value.as_table()) {
            flatten(*inner, path + '.', visit);
        } else {
            visit(path, value);
        }
    }
}

const scene::TableSpec& experiment_schema() {
    static const std::shared_ptr<const scene::TableSpec> schema = [] {
        using F = ExperimentFile;
        TableOf<F> file("", false, "");
        file.file("an experiment")
            .text("title", &F::title, "one line, for headings")
            .text("description", &F::description, "what is measured and where the figures are from")
            .child<ExperimentWorld>("world", world_table(), [](F& f) { return &f.world; })
            .child<scene::SoilItem>("soil", scene::soil_table(),
                                    [](F& f) { return &f.setup.scene.soil.emplace(); })
            .child<scene::MaterialItem>(
                "material", scene::material_table(),
                [](F& f) { return &f.setup.scene.materials.emplace_back(); })
            .child<BedItem>("bed", bed_table(), [](F& f) { return &f.setup.bed; });
        add_rig<PlateItem>(file, "plate", plate_table());
        add_rig<BladeItem>(file, "blade", blade_table());
        add_rig<TractionItem>(file, "traction", traction_table());
        add_rig<ShearItem>(file, "shear", shear_table());
        add_rig<ColumnItem>(file, "column", column_table());
        file.value("sweep", "table", "the parameters that are swept, see above",
                   [](F&, const toml::node& value) -> std::string {
                       return value.is_table() ? ""
                                               : "expected a table, not " + scene::kind_text(value);
                   })
            .child<MeasuredItem>("measured", measured_table(),
                                 [](F& f) { return &f.measured.emplace(); })
            .child<PlotItem>("plot", plot_table(), [](F& f) { return &f.plots.emplace_back(); })
            .child<ExpectItem>("expect", expect_table(),
                               [](F& f) { return &f.expectations.emplace_back(); })
            .child<ValidationItem>("validation", validation_table(),
                                   [](F& f) { return &f.validation.emplace(); });
        return file.spec();
    }();
    return *schema;
}

}  // namespace bsoil::experiment
