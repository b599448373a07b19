#include "plot.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "measured_data.h"
#include "rig.h"

extern char** environ;

namespace bsoil::experiment {

std::string axis_title(const std::string& column) {
    struct Unit {
        const char *suffix, *text;
    };
    static constexpr Unit kUnits[] = {{"_kg_m3", "kg/m^3"}, {"_n_m", "N m"}, {"_m_s", "m/s"},
                                      {"_deg", "deg"},      {"_kg", "kg"},   {"_pa", "Pa"},
                                      {"_m", "m"},          {"_s", "s"},     {"_n", "N"}};
    std::string name = column, unit;
    for (const Unit& u : kUnits) {
        if (!unit.empty() || !name.ends_with(u.suffix)) continue;
        name.resize(name.size() - std::string(u.suffix).size());
        unit = std::string(", ") + u.text;
    }
    std::replace(name.begin(), name.end(), '_', ' ');
    return name + unit;
}

std::vector<std::string> curve_keys(const Experiment& experiment, const PlotItem& plot) {
    if (plot.has("by")) return plot.by;
    std::vector<std::string> keys;
    if (!experiment.points.empty()) {
        for (const Parameter& p : experiment.points[0].parameters) {
            if (p.name != plot.x && p.name != plot.y) keys.push_back(p.name);
        }
    }
    // a sweep along measured rows changes all of its parameters from point to point
    if (station_column(experiment.rig).empty() && experiment.measured_item &&
        keys.size() + 1 == experiment.points[0].parameters.size() && keys.size() > 0) {
        std::map<std::string, size_t> rows_of;
        for (const Point& point : experiment.points) {
            std::string text;
            for (const Parameter& p : point.parameters) {
                if (p.name != plot.x) text += p.text + ' ';
            }
            ++rows_of[text];
        }
        if (rows_of.size() == experiment.points.size()) keys.clear();
    }
    return keys;
}

namespace {

constexpr int kPanelWidth = 640, kPanelHeight = 480;  // [pixels]

struct TitledCurve {
    std::string title;
    std::vector<std::pair<double, double>> points;
};

/// In double quotes, with nothing that gnuplot would expand.
std::string gnuplot_text(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

std::vector<PlotItem> default_plots(const Experiment& experiment) {
    std::string x = station_column(experiment.rig);
    if (x.empty() && !experiment.points.empty() && !experiment.points[0].parameters.empty()) {
        x = experiment.points[0].parameters[0].name;
    }
    std::vector<PlotItem> plots;
    for (const std::string& y : result_columns(experiment.rig)) {
        if (x.empty() || y == x || y.ends_with("_sd")) continue;
        PlotItem& plot = plots.emplace_back();
        plot.x = x;
        plot.y = y;
    }
    return plots;
}

std::vector<TitledCurve> computed_curves(const Experiment& experiment, const PlotItem& plot,
                                         const CsvTable& results) {
    const std::vector<std::string> keys = curve_keys(experiment, plot);
    std::vector<TitledCurve> curves;
    for (size_t r = 0; r < results.rows.size(); ++r) {
        const auto x = results.number(r, plot.x), y = results.number(r, plot.y);
        if (!x || !y) continue;
        std::string title;
        for (const std::string& key : keys) {
            title += fmt::format("{}{} = {}", title.empty() ? "" : ", ", axis_title(key),
                                 results.rows[r][static_cast<size_t>(results.column_index(key))]);
        }
        auto curve = std::find_if(curves.begin(), curves.end(),
                                  [&](const TitledCurve& c) { return c.title == title; });
        if (curve == curves.end()) curve = curves.insert(curves.end(), TitledCurve{title, {}});
        curve->points.push_back({*x, *y});
    }
    // rows of a station follow each other; points of a sweep may stand in any order
    if (station_column(experiment.rig) != plot.x) {
        for (TitledCurve& curve : curves) std::sort(curve.points.begin(), curve.points.end());
    }
    return curves;
}

std::vector<TitledCurve> measured_curves(const Experiment& experiment, const PlotItem& plot) {
    const MeasuredTable& table = experiment.measured;
    const auto index_of = [&](const std::string& name) {
        const auto found = std::find(table.columns.begin(), table.columns.end(), name);
        return found == table.columns.end() ? -1 : static_cast<int>(found - table.columns.begin());
    };
    const int x = index_of(plot.x), y = index_of(plot.y);
    if (x < 0 || y < 0) return {};
    std::vector<TitledCurve> curves;
    for (const std::vector<double>& row : table.rows) {
        std::string title = experiment.measured_item->label;
        for (const std::string& key : curve_keys(experiment, plot)) {
            if (const int k = index_of(key); k >= 0) {
                title +=
                    fmt::format(", {} = {}", axis_title(key), cell(row[static_cast<size_t>(k)]));
            }
        }
        auto curve = std::find_if(curves.begin(), curves.end(),
                                  [&](const TitledCurve& c) { return c.title == title; });
        if (curve == curves.end()) curve = curves.insert(curves.end(), TitledCurve{title, {}});
        curve->points.push_back({row[static_cast<size_t>(x)], row[static_cast<size_t>(y)]});
    }
    return curves;
}

/// Adds a panel: its data blocks to `data`, its plot command to `commands`.
void add_panel(const Experiment& experiment, const PlotItem& plot, const CsvTable& results,
               int& block_count, std::string& data, std::string& commands) {
    commands += fmt::format("set title {}\nset xlabel {}\nset ylabel {}\nunset logscale\n",
                            gnuplot_text(plot.title), gnuplot_text(axis_title(plot.x)),
                            gnuplot_text(axis_title(plot.y)));
    if (plot.log_x) commands += "set logscale x\n";
    if (plot.log_y) commands += "set logscale y\n";
    std::string curves;
    bool negative = false;
    int color = 0;
    const auto add = [&](const std::vector<TitledCurve>& of, const char* style) {
        color = 0;
        for (const TitledCurve& curve : of) {
            const std::string block = fmt::format("$data{}", block_count++);
            data += block + " << EOD\n";
            for (const auto& [x, y] : curve.points) negative |= y < 0;
            for (const auto& [x, y] : curve.points) data += fmt::format("{:.6g} {:.6g}\n", x, y);
            data += "EOD\n";
            curves += fmt::format("{}{} with {} linecolor {} title {}", curves.empty() ? "" : ", ",
                                  block, style, ++color,
                                  gnuplot_text(curve.title.empty() ? "BulletSoil" : curve.title));
        }
    };
    add(computed_curves(experiment, plot, results),
        "linespoints linewidth 2 pointtype 7 pointsize 0.4");
    add(measured_curves(experiment, plot), "points pointtype 6 pointsize 1.2 linewidth 1.5");
    commands += plot.log_y || negative ? "set yrange [*:*]\n" : "set yrange [0:*]\n";
    if (!curves.empty()) commands += "plot " + curves + '\n';
}

}  // namespace

std::string plot_script(const Experiment& experiment, const CsvTable& results) {
    const std::vector<PlotItem> plots =
        experiment.plots.empty() ? default_plots(experiment) : experiment.plots;
    const int count = std::max(1, static_cast<int>(plots.size()));
    const int columns = static_cast<int>(std::ceil(std::sqrt(count)));
    const int rows = (count + columns - 1) / columns;
    std::string data, commands;
    int block_count = 0;
    for (const PlotItem& plot : plots) {
        add_panel(experiment, plot, results, block_count, data, commands);
    }
    std::string script =
        "# drawn by `gnuplot results.gnuplot`\nset encoding utf8\nset grid\n"
        "set key below noenhanced\nset title noenhanced\n" +
        data;
    for (const char* format : {"svg", "png"}) {
        script += fmt::format(
            "set terminal {} size {},{} noenhanced{}\nset output \"results.{}\"\n"
            "set multiplot layout {},{} title {}\n{}unset multiplot\nunset output\n",
            format, columns * kPanelWidth, rows * kPanelHeight,
            format == std::string("svg") ? " background \"white\"" : "", format, rows, columns,
            gnuplot_text(experiment.title), commands);
    }
    return script;
}

Status draw_plot(const Experiment& experiment, const CsvTable& results, const std::string& folder) {
    const std::string path = folder + "/results.gnuplot";
    std::ofstream file(path);
    file << plot_script(experiment, results);
    file.close();
    if (!file) return Error{path + ": cannot be written; check its folder and the disk"};
    // the shell only to change the folder, which posix_spawn cannot do everywhere
    std::vector<std::string> words{"sh", "-c", "cd \"$1\" && exec gnuplot results.gnuplot", "sh",
                                   folder};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t process = 0;
    int status = -1;
    if (posix_spawnp(&process, "sh", nullptr, nullptr, arguments.data(), environ) == 0) {
        waitpid(process, &status, 0);
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return Done{};
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
        return Error{"no plot: gnuplot is not installed; install it (Debian: gnuplot-nox)"};
    }
    return Error{"no plot: gnuplot failed; run it by hand on " + path};
}

}  // namespace bsoil::experiment
