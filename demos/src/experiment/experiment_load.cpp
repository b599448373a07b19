#include "experiment_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiment_schema.h"
#include "figures.h"
#include "files/data_files.h"
#include "files/text_file.h"
#include "measured_data.h"
#include "reading/scene_load.h"
#include "reading/toml_file.h"
#include "rig.h"

namespace bsoil::experiment {
namespace {

using scene::SchemaError;
using scene::SourcePosition;

/// A parameter of the sweep with the place that gives it its value.
struct PlacedParameter {
    Parameter parameter;
    SourcePosition at;
};
using Combination = std::vector<PlacedParameter>;

/// Points of a sweep: a handful of short lists could stand for more than any memory holds.
constexpr size_t kPointCapacity = 100'000;

class ExperimentReader {
  public:
    ExperimentReader(const std::string& path, const std::string& rig) : rig_(rig) {
        experiment_.path = path;
        experiment_.rig = rig;
    }

    Result<Experiment> read(toml::table root, const std::vector<std::string>& settings) {
        if (rig_.empty()) {
            for (const std::string& name : rig_names()) {
                if (root.contains(name)) rig_ = experiment_.rig = name;
            }
        }
        for (const std::string& setting : settings) apply_setting(root, setting);
        ExperimentFile file;
        if (errors_.empty()) scene::read_table(root, experiment_schema(), &file, errors_);
        if (errors_.empty()) check_file(file);
        if (errors_.empty()) {
            experiment_.title = file.title;
            experiment_.description = file.description;
            experiment_.plots = file.plots;
            experiment_.expectations = file.expectations;
            experiment_.validation = file.validation;
            read_measured(file);
            read_points(root);
        }
        if (errors_.empty()) check_settings(settings);
        if (errors_.empty()) check_columns(file);
        if (errors_.empty()) return std::move(experiment_);
        return Error{scene::error_text(std::move(errors_), experiment_.path)};
    }

  private:
    template <typename... Args>
    void error(SourcePosition at, fmt::format_string<Args...> text, Args&&... args) {
        errors_.push_back({at, fmt::format(text, std::forward<Args>(args)...)});
    }

    /// Gives a key of the file a value; a name without a dot is a key of the rig's table.
    void assign(toml::table& root, const Parameter& parameter, SourcePosition at) {
        const size_t dot = parameter.name.rfind('.');
        std::string tables = dot == std::string::npos ? rig_ : parameter.name.substr(0, dot);
        const std::string key =
            dot == std::string::npos ? parameter.name : parameter.name.substr(dot + 1);
        toml::table* table = &root;
        for (size_t start = 0; start <= tables.size();) {
            const size_t end = std::min(tables.find('.', start), tables.size());
            const std::string name = tables.substr(start, end - start);
            toml::node* node = table->get(name);
            if (!node) node = &table->insert_or_assign(name, toml::table{}).first->second;
            if (toml::array* array = node->as_array(); array && !array->empty()) {
                node = array->get(0);  // [[material]]: the first
            }
            table = node->as_table();
            if (!table) {
                return error(at, "`{}`: there is no table [{}]; add it", parameter.name, name);
            }
            start = end + 1;
        }
        if (parameter.text == "true" || parameter.text == "false") {
            table->insert_or_assign(key, parameter.text == "true");
        } else if (!parameter.number) {
            table->insert_or_assign(key, parameter.text);
        } else if (*parameter.number == std::round(*parameter.number) &&
                   std::abs(*parameter.number) < 1e15) {
            table->insert_or_assign(key, static_cast<int64_t>(*parameter.number));
        } else {
            table->insert_or_assign(key, *parameter.number);
        }
    }

    void apply_setting(toml::table& root, const std::string& setting) {
        const size_t equals = setting.find('=');
        const std::string name = setting.substr(0, equals);
        const std::string text = equals == std::string::npos ? "" : setting.substr(equals + 1);
        if (name.empty() || text.empty()) {
            return error({}, "\"{}\" must have the form key=value", setting);
        }
        assign(root, Parameter{name, text, number_in(text)}, {});
    }

    /// What a sweep gives a key is no longer what was set.
    void check_settings(const std::vector<std::string>& settings) {
        if (experiment_.points.empty()) return;
        const auto full_name = [this](const std::string& name) {
            return name.find('.') == std::string::npos ? rig_ + '.' + name : name;
        };
        for (const std::string& setting : settings) {
            const std::string name = setting.substr(0, setting.find('='));
            for (const Parameter& swept : experiment_.points.front().parameters) {
                if (full_name(swept.name) != full_name(name)) continue;
                error({}, "`{}` cannot be set: [sweep] gives it its values; change it there", name);
            }
        }
    }

    void check_file(const ExperimentFile& file) {
        if (file.rigs.size() != 1) {
            return error(file.at,
                         "an experiment must have one of the tables [plate], [blade], "
                         "[traction], [shear] and [column], not {}",
                         file.rigs.size());
        }
        if (file.rigs[0] != rig_) {
            error(file.at, "this is an experiment for `bsoil {}`; run that", file.rigs[0]);
        }
    }

    void read_measured(const ExperimentFile& file) {
        if (!file.measured) return;
        const MeasuredItem& item = *file.measured;
        experiment_.measured_item = item;
        const std::string path = scene::find_file(item.file, experiment_.path);
        if (path.empty()) {
            if (item.file.starts_with("data:")) {
                experiment_.missing_data = item.file;
            } else {
                error(item.where("file"),
                      "there is no file \"{}\" beside the experiment; check its name", item.file);
            }
            return;
        }
        const auto table = read_csv(path);
        if (!table) return error(item.where("file"), "{}", table.error());
        auto selected = select_measured(*table, item);
        if (!selected) return error(item.at, "{}: {}", item.file, selected.error());
        experiment_.measured = std::move(*selected);
    }

    /// The file's points: rows of the sweep, measured rows and lists, all combined.
    void read_points(const toml::table& root) {
        std::vector<Combination> combinations{{}};
        if (const toml::table* sweep = root["sweep"].as_table()) {
            const toml::node* measured = sweep->get("from_measured");
            if (measured) combine(combinations, measured_rows(*measured));
            if (const toml::node* rows = sweep->get("row")) {
                combine(combinations, listed_rows(*rows));
            }
            struct List {
                std::string name;
                const toml::node* values;
            };
            std::vector<List> lists;  // in the order of the file, not of the alphabet
            flatten(*sweep, "", [&](const std::string& name, const toml::node& values) {
                if (&values != measured && name != "row") lists.push_back({name, &values});
            });
            std::stable_sort(lists.begin(), lists.end(), [](const List& a, const List& b) {
                const SourcePosition x = scene::position_of(*a.values),
                                     y = scene::position_of(*b.values);
                return std::pair(x.line, x.column) < std::pair(y.line, y.column);
            });
            for (const List& list : lists) combine(combinations, listed(list.name, *list.values));
        }
        if (!errors_.empty() || experiment_.points_are_missing) return;
        for (const Combination& combination : combinations) {
            add_point(root, combination);
            if (!errors_.empty()) return;  // the other points have the same mistakes
        }
    }

    void combine(std::vector<Combination>& combinations, const std::vector<Combination>& with) {
        if (!with.empty() && combinations.size() > kPointCapacity / with.size()) {
            error(with.front().empty() ? SourcePosition{} : with.front().front().at,
                  "the sweep must have at most {} points", kPointCapacity);
            combinations.clear();
        }
        std::vector<Combination> product;
        for (const Combination& a : combinations) {
            for (const Combination& b : with) {
                product.push_back(a);
                product.back().insert(product.back().end(), b.begin(), b.end());
            }
        }
        combinations = std::move(product);
    }

    std::vector<Combination> listed(const std::string& name, const toml::node& values) {
        std::vector<Combination> out;
        const toml::array* array = values.as_array();
        if (!array || array->empty()) {
            error(scene::position_of(values), "`{}`: expected a list of values, not {}", name,
                  scene::kind_text(values));
            return out;
        }
        for (const toml::node& value : *array) {
            if (auto parameter = parameter_of(name, value)) {
                out.push_back({{std::move(*parameter), scene::position_of(value)}});
            } else {
                error(scene::position_of(value), "`{}`: expected a value, not {}", name,
                      scene::kind_text(value));
            }
        }
        return out;
    }

    std::vector<Combination> listed_rows(const toml::node& rows) {
        std::vector<Combination> out;
        std::set<std::string> first_names;
        const toml::array* array = rows.as_array();
        if (!array || array->empty()) {
            error(scene::position_of(rows), "`row`: expected a list of tables, not {}",
                  scene::kind_text(rows));
            return out;
        }
        for (const toml::node& row : *array) {
            const SourcePosition at = scene::position_of(row);
            if (!row.is_table()) {
                error(at, "`row`: expected tables in the list, not {}", scene::kind_text(row));
                return out;
            }
            Combination combination;
            flatten(*row.as_table(), "", [&](const std::string& name, const toml::node& value) {
                if (auto parameter = parameter_of(name, value)) {
                    combination.push_back({std::move(*parameter), scene::position_of(value)});
                } else {
                    error(scene::position_of(value), "`{}`: expected a value, not {}", name,
                          scene::kind_text(value));
                }
            });
            std::set<std::string> names;
            for (const PlacedParameter& p : combination) names.insert(p.parameter.name);
            if (out.empty()) first_names = names;
            if (names != first_names) {
                error(at, "every row of a sweep must give the same parameters");
            }
            out.push_back(std::move(combination));
        }
        return out;
    }

    std::vector<Combination> measured_rows(const toml::node& names) {
        const SourcePosition at = scene::position_of(names);
        std::vector<Combination> out;
        if (!experiment_.measured_item) {
            error(at, "`from_measured` needs a [measured]");
            return out;
        }
        experiment_.points_are_missing = !experiment_.missing_data.empty();
        if (experiment_.points_are_missing || !errors_.empty()) return out;
        const toml::array* array = names.as_array();
        std::vector<size_t> columns;
        for (size_t i = 0; array && i < array->size(); ++i) {
            const std::string name = array->get(i)->value_or(std::string());
            const auto& known = experiment_.measured.columns;
            const auto found = std::find(known.begin(), known.end(), name);
            if (found == known.end()) {
                error(at, "`from_measured`: \"{}\" is no name of a [[measured.column]]; name one",
                      name);
            } else {
                columns.push_back(static_cast<size_t>(found - known.begin()));
            }
        }
        if (columns.empty() && errors_.empty()) {
            error(at, "`from_measured`: expected a list of names, not {}", scene::kind_text(names));
        }
        std::set<std::vector<double>> taken;  // trials of one setting are one point
        for (const std::vector<double>& row : experiment_.measured.rows) {
            Combination combination;
            std::vector<double> values;
            for (const size_t c : columns) {
                values.push_back(row[c]);
                combination.push_back(
                    {{experiment_.measured.columns[c], cell(row[c]), row[c]}, at});
            }
            if (taken.insert(values).second) out.push_back(std::move(combination));
        }
        return out;
    }

    void add_point(const toml::table& root, const Combination& combination) {
        toml::table changed;  // only where needed: a copy forgets where its values stand
        if (!combination.empty()) changed = root;
        Point point;
        for (const PlacedParameter& p : combination) {
            assign(changed, p.parameter, p.at);
            point.parameters.push_back(p.parameter);
        }
        ExperimentFile file;
        std::vector<SchemaError> errors;
        scene::read_table(combination.empty() ? root : changed, experiment_schema(), &file, errors);
        file.setup.scene.path = experiment_.path;
        file.setup.scene.world = file.world;
        if (errors.empty()) scene::check_soil(file.setup.scene, errors);
        if (errors.empty()) check_setup(file.setup, errors);
        // What a sweep gives a key stands nowhere in the table: point at the sweep.
        std::string values;
        for (const PlacedParameter& p : combination) {
            values += fmt::format("{}{} = {}", values.empty() ? "" : ", ", p.parameter.name,
                                  p.parameter.text);
        }
        for (SchemaError& e : errors) {
            if (combination.empty()) continue;
            e.at = combination.front().at;
            for (const PlacedParameter& p : combination) {
                const size_t dot = p.parameter.name.rfind('.');
                const std::string key =
                    dot == std::string::npos ? p.parameter.name : p.parameter.name.substr(dot + 1);
                if (e.text.find('`' + key + '`') != std::string::npos) e.at = p.at;
            }
            e.text += fmt::format(" (at {})", values);
        }
        errors_.insert(errors_.end(), errors.begin(), errors.end());
        point.setup = std::move(file.setup);
        experiment_.points.push_back(std::move(point));
    }

    static void check_setup(const RigSetup& setup, std::vector<SchemaError>& errors) {
        const auto wrong = [&](const scene::SceneItem& item, const char* key,
                               const std::string& text) {
            errors.push_back({item.where(key), fmt::format("`{}`: {}", key, text)});
        };
        const scene::Scene& scene = setup.scene;
        if (scene.soil && scene.world.ground_plane) {
            wrong(scene.world, "ground_plane", "stands in place of [soil]; leave one of them out");
        }
        if (scene.soil && setup.bed.depth_m > scene.soil->def.size_m.z) {
            wrong(setup.bed, "depth_m", "the bed must not be deeper than the soil's box is high");
        }
        if (const auto* plate = std::get_if<PlateItem>(&setup.rig)) {
            if (plate->reach_m.empty()) wrong(*plate, "reach_m", "must give a sinkage");
            const double deepest_m = plate->reach_m.empty() ? 0 : std::ranges::max(plate->reach_m);
            if (scene.soil && deepest_m >= setup.bed.depth_m) {
                wrong(*plate, "reach_m",
                      "the plate goes deeper than the bed; raise `depth_m` of [bed]");
            }
            if (plate->shape == "hull" && plate->points_m.size() < 4) {
                wrong(*plate, "points_m", "a hull needs at least 4 points");
            }
        }
        if (const auto* blade = std::get_if<BladeItem>(&setup.rig)) {
            if (blade->window_from_m >= blade->travel_m) {
                wrong(*blade, "window_from_m", "must lie before the end of the travel");
            }
            if (scene.soil && blade->depth_m >= setup.bed.depth_m) {
                wrong(*blade, "depth_m", "the blade must not be deeper than the bed");
            }
            check_way(setup, blade->travel_m, *blade, "travel_m", errors);
        }
        if (const auto* wheel = std::get_if<TractionItem>(&setup.rig)) {
            if (wheel->window_from_m >= wheel->travel_m) {
                wrong(*wheel, "window_from_m", "must lie before the end of the travel");
            }
            const double endless = wheel->held == "travel" ? 1 : -1;
            if (wheel->slip_ratio == endless) {
                wrong(*wheel, "slip_ratio",
                      fmt::format("{} has no end where the {} speed is held; change one of them",
                                  endless, wheel->held));
            } else {
                check_way(setup, carriage_way_m(*wheel), *wheel, "travel_m", errors);
            }
        }
        if (const auto* column = std::get_if<ColumnItem>(&setup.rig)) {
            if (!scene.soil) {
                wrong(*column, "height_m", "a column needs [soil]; add it");
            } else if (column->height_m > scene.soil->def.size_m.z) {
                wrong(*column, "height_m", "the column must not be higher than the soil's box");
            }
            if (setup.bed.at.line != 0) {
                wrong(setup.bed, "depth_m", "a column stands on the floor; leave `depth_m` out");
            }
        }
        if (const auto* shear = std::get_if<ShearItem>(&setup.rig)) {
            if (shear->head == "annulus" && shear->inner_radius_m >= shear->outer_radius_m) {
                wrong(*shear, "inner_radius_m", "must be less than `outer_radius_m`");
            }
            if (shear->head == "box") {
                check_way(setup, shear->displacement_m, *shear, "displacement_m", errors);
            }
        }
    }

    /// A tool's way along x, the bed's middle in its own middle, starts and ends inside the bed.
    static void check_way(const RigSetup& setup, double way_m, const scene::SceneItem& item,
                          const char* key, std::vector<SchemaError>& errors) {
        if (!setup.scene.soil) return;
        const SoilDef& def = setup.scene.soil->def;
        const double bed_m = std::min(def.size_m.x / std::abs(std::cos(def.yaw_rad)),
                                      def.size_m.y / std::abs(std::sin(def.yaw_rad)));
        if (way_m < bed_m) return;
        errors.push_back(
            {item.where(key),
             fmt::format("`{}`: the bed is only {:.4g} m long; enlarge size_m", key, bed_m)});
    }

    /// Every column that is asked for has to be one.
    void check_columns(const ExperimentFile& file) {
        std::vector<std::string> known{"point"};
        if (!experiment_.points.empty()) {
            for (const Parameter& p : experiment_.points.front().parameters) {
                known.push_back(p.name);
            }
        }
        const std::vector<std::string>& results = result_columns(rig_);
        known.insert(known.end(), results.begin(), results.end());
        const auto need = [&](const std::string& name, SourcePosition at) {
            if (experiment_.points_are_missing ||
                std::find(known.begin(), known.end(), name) != known.end()) {
                return;
            }
            std::string list;
            for (const std::string& column : known) list += (list.empty() ? "" : ", ") + column;
            error(at, "\"{}\" is no parameter of the sweep and no result; these are {}", name,
                  list);
        };
        if (file.measured) {
            for (const MeasuredColumnItem& column : file.measured->columns) {
                need(column.name, column.where("name"));
            }
            for (const MeasuredColumnItem& column : file.measured->columns) {
                known.push_back(column.name + "_measured");
                known.push_back(column.name + "_error");
            }
        }
        for (const PlotItem& plot : file.plots) {
            need(plot.x, plot.where("x"));
            need(plot.y, plot.where("y"));
            for (const std::string& name : plot.by) need(name, plot.where("by"));
        }
        const auto need_figure = [&](const FigureItem& figure) {
            need(figure.column, figure.where("column"));
            for (const RowCondition& c : figure.at_values) need(c.column, figure.where("at"));
            for (const std::string& name : figure.by) need(name, figure.where("by"));
            if (!figure.over.empty()) need(figure.over, figure.where("over"));
            if (follows_column(figure.statistic) && figure.over.empty()) {
                error(figure.at, "`{}` needs `over`", figure.statistic);
            }
        };
        if (file.validation) {
            if (!file.measured) error(file.validation->at, "[validation] needs a [measured]");
            for (const CompareItem& compare : file.validation->compares) need_figure(compare);
        }
        for (const ExpectItem& expect : file.expectations) {
            need_figure(expect);
            if (expect.value.has_value() != expect.tolerance.has_value()) {
                error(expect.at, "`value` and `tolerance` belong together; give both or none");
            }
            if (!expect.value && !expect.min && !expect.max) {
                error(expect.at, "[[expect]] needs `value`, `min` or `max`");
            }
        }
    }

    std::string rig_;
    Experiment experiment_;
    std::vector<SchemaError> errors_;
};

}  // namespace

Result<Experiment> parse_experiment(const std::string& text, const std::string& path,
                                    const std::string& rig,
                                    const std::vector<std::string>& settings) {
    auto parsed = scene::parse_toml(text, path);
    if (!parsed) return Error{parsed.error()};
    return ExperimentReader(path, rig).read(std::move(*parsed), settings);
}

Result<Experiment> load_experiment(const std::string& path, const std::string& rig,
                                   const std::vector<std::string>& settings) {
    const auto text = scene::read_file(path, scene::kTomlCapacity);
    if (!text) return Error{text.error()};
    return parse_experiment(*text, path, rig, settings);
}

}  // namespace bsoil::experiment
