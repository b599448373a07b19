// A law beside measurements without a grid: forces on exact surfaces in a flat bed, as the coupling
// would find them at yield. Rules are told apart here in seconds; heaps, ruts and Bullet's solver
// come on top in `bsoil validate`.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "flat_bed_wheel.h"
#include "measured_data.h"

namespace bsoil::flat_bed {
namespace {

/// Rows of a CSV file by column.
using Row = std::map<std::string, std::string>;
std::vector<Row> read(const std::string& name) {
    std::ifstream file(measured_data(name));
    std::vector<Row> rows;
    std::vector<std::string> columns;
    for (std::string line; std::getline(file, line);) {
        std::vector<std::string> cells;
        std::stringstream stream(line);
        for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
        if (columns.empty()) {
            columns = cells;
            continue;
        }
        Row& row = rows.emplace_back();
        for (size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) {
            row[columns[i]] = cells[i];
        }
    }
    return rows;
}
double number(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    const size_t n = values.size();
    return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

/// Errors of a law by data set and quantity.
class Errors {
  public:
    void add(const std::string& key, double computed, double measured, double scale = 0) {
        sets_[key].push_back(scale > 0 ? std::abs(computed - measured) / scale
                                       : std::abs(computed / measured - 1));
    }
    const std::map<std::string, std::vector<double>>& sets() const { return sets_; }

  private:
    std::map<std::string, std::vector<double>> sets_;
};

const Soil kPavlov{1330, 29, 0, {}, {}, 0.002}, kDing{1605, 31.9, 250, {}, {}, 0.002},
    kObermayr{1440, 35};

constexpr double kPavlovLug_m = 0.005;
bool has_lugs(const Row& row) { return row.at("wheel") != "smooth"; }

WheelForce pavlov_wheel(const Law& law, const Row& row) {
    Wheel wheel{kPavlov, 0.058, 0.05};
    if (has_lugs(row)) {
        wheel.lug_count = 12;
        wheel.lug_height_m = kPavlovLug_m;
        wheel.lug_thickness_m = 0.003;
    }
    return wheel_under_load(law, wheel, number(row, "slip_ratio"),
                            radians(std::min(number(row, "slip_angle_deg"), 89.9)),
                            number(row, "Fz_N"), false);
}

Errors errors_of(const Law& law) {
    Errors errors;
    for (const Row& row : read("cmu_pavlov2022_wheel_means.csv")) {
        const bool lugs = has_lugs(row);
        const double angle = number(row, "slip_angle_deg"), load_n = number(row, "Fz_N");
        const WheelForce f = pavlov_wheel(law, row);
        const std::string set = std::string("pavlov ") + (lugs ? "lugs" : "smooth") +
                                (angle > 0 ? " at " + row.at("slip_angle_deg") : "");
        errors.add(set + ", pull", f.pull_n, number(row, "Fx_N"), load_n);
        errors.add(set + ", sinkage", f.sinkage_m, 1e-3 * number(row, "sinkage_mm"));
        if (lugs) {
            errors.add(set + ", sinkage of the tips", f.sinkage_m + kPavlovLug_m,
                       1e-3 * number(row, "sinkage_mm"));
        }
        if (angle > 0) errors.add(set + ", side", f.side_n, number(row, "Fy_N"), load_n);
    }
    for (const Row& row : read("roverdevkit_single_wheel_experiments.csv")) {
        if (row.at("case_id").rfind("ding2011", 0) != 0) continue;
        Wheel wheel{kDing, 0.15735, 0.165};
        wheel.lug_count = static_cast<int>(number(row, "grouser_count"));
        wheel.lug_height_m = number(row, "grouser_height_m");
        wheel.lug_thickness_m = 0.005;
        const double load_n = number(row, "vertical_load_n"), slip = number(row, "slip");
        const WheelForce f = wheel_under_load(law, wheel, slip, 0, load_n, true);
        const std::string set = wheel.lug_count > 0 ? "ding lugs" : "ding smooth";
        errors.add(set + ", pull", f.pull_n, number(row, "meas_drawbar_pull_n"), load_n);
        errors.add(set + ", sinkage", f.sinkage_m, number(row, "meas_sinkage_m"));
        if (wheel.lug_count > 0) {
            errors.add(set + ", sinkage of the tips", f.sinkage_m + wheel.lug_height_m,
                       number(row, "meas_sinkage_m"));
        }
        if (slip > 0) errors.add(set + ", torque", f.torque_n_m, number(row, "meas_torque_nm"));
    }
    for (const Row& row : read("cmu_pavlov2022_plate_sinkage.csv")) {
        const double sinkage_m = 1e-3 * number(row, "sinkage_mm");
        if (row.at("box") != "large" || row.at("trial") != "1" || sinkage_m < 0.0049 ||
            sinkage_m > 0.0151) {
            continue;
        }
        Case c;
        c.soil = kPavlov;
        c.friction = std::tan(radians(29));
        const double r = 5e-4 * number(row, "plate_diameter_mm");
        c.edge_m = r / 10;
        const auto surface = oracle::surface_of({cylinder(r, 0.04, false)}, c.edge_m);
        c.surface = &surface;
        c.motion.pose.position = {0, 0, 0.02 - sinkage_m};
        c.motion.velocity_m_s = {0, 0, -1};
        errors.add("pavlov plates, force", force_of(law, c, sinkage_m).force_n.z,
                   number(row, "force_N"));
    }
    for (const Row& row : read("obermayr2013_blade.csv")) {
        Case c;
        c.soil = kObermayr;
        c.friction = 0.29;
        const double depth_m = number(row, "x");
        ConvexShape blade;
        blade.half_extents_m = {0.03, 0.1, 0.3};
        c.edge_m = 0.01;
        const auto surface = oracle::surface_of({blade}, c.edge_m);
        c.surface = &surface;
        c.motion.pose.position = {0, 0, 0.3 - depth_m};
        c.motion.velocity_m_s = {1, 0, 0};
        errors.add("obermayr blade, draft", -force_of(law, c, depth_m).force_n.x, number(row, "y"));
    }
    return errors;
}

const std::vector<Law>& laws() {
    using L = Rules::Lugs;
    static const std::vector<Law> list{
        {"today's", true, {}},
        {"plain", false, {}},
        {"+ metal", false, {.smooth_metal = true}},
        {"+ wedge", false, {.wedge = true}},
        {"+ K 3 mm", false, {.shear_k_m = 0.003}},
        {"+ r + h", false, {.lugs = L::cylinder}},
        {"+ trapped, full", false, {.lugs = L::full}},
        {"+ trapped", false, {.lugs = L::trapped}},
        {"+ bow", false, {.bow = Bow::turned}},
        {"wedge, trapped", false, {.wedge = true, .lugs = L::trapped}},
        {"wedge, trapped, K", false, {.wedge = true, .shear_k_m = 0.003, .lugs = L::trapped}},
    };
    return list;
}

/// What stands in docs/decisions/bow.md: the rules of a bow beside what they are added to.
const std::vector<Law>& bow_laws() {
    static const std::vector<Law> list = [] {
        std::vector<Law> made;
        for (const auto& [name, bow] : {std::pair{"wedge, trapped", Bow::none},
                                        {"turned", Bow::turned},
                                        {"turned by share", Bow::turned_by_share},
                                        {"held", Bow::held},
                                        {"block", Bow::block}}) {
            made.push_back(
                {name, false, {.wedge = true, .bow = bow, .lugs = Rules::Lugs::trapped}});
        }
        return made;
    }();
    return list;
}

std::vector<Errors> errors_of(const std::vector<Law>& laws) {
    std::vector<Errors> all;
    for (const Law& law : laws) all.push_back(errors_of(law));
    return all;
}

void print_head(const std::string& first, const std::vector<Law>& laws) {
    std::printf("| %s |", first.c_str());
    for (const Law& law : laws) std::printf(" %s |", law.name.c_str());
    std::printf("\n");
}

void print_table(const std::vector<Law>& laws, const std::vector<Errors>& all) {
    print_head("", laws);
    std::map<std::string, std::vector<std::vector<double>>> kinds;
    for (const auto& [set, errors] : all.front().sets()) {
        std::printf("| %s (%zu) |", set.c_str(), errors.size());
        std::vector<std::vector<double>>& kind = kinds[set.substr(set.find(", ") + 2)];
        kind.resize(all.size());
        for (size_t i = 0; i < all.size(); ++i) {
            const std::vector<double>& own = all[i].sets().at(set);
            kind[i].insert(kind[i].end(), own.begin(), own.end());
            std::printf(" %.1f |", 100 * median(own));
        }
        std::printf("\n");
    }
    for (const auto& [kind, errors] : kinds) {
        std::printf("| **all** %s (%zu) |", kind.c_str(), errors.front().size());
        for (const auto& own : errors) std::printf(" %.1f |", 100 * median(own));
        std::printf("\n");
    }
}

/// Decides by the pull on all wheels but one set, and looks at that one afterwards.
void print_leave_one_out(const std::vector<Errors>& all) {
    std::vector<double> chosen, todays;
    for (const auto& [left_out, unused] : all.front().sets()) {
        if (left_out.find(", pull") == std::string::npos) continue;
        size_t best = 0;
        double least = 1e9;
        for (size_t i = 0; i < all.size(); ++i) {
            std::vector<double> rest;
            for (const auto& [set, errors] : all[i].sets()) {
                if (set != left_out && set.find(", pull") != std::string::npos) {
                    rest.insert(rest.end(), errors.begin(), errors.end());
                }
            }
            if (median(rest) < least) {
                least = median(rest);
                best = i;
            }
        }
        const std::vector<double>&own = all[best].sets().at(left_out),
              &now = all[0].sets().at(left_out);
        std::printf("| %s | %s | %.1f | %.1f | %.1f |\n", left_out.c_str(),
                    laws()[best].name.c_str(), 100 * least, 100 * median(own), 100 * median(now));
        chosen.insert(chosen.end(), own.begin(), own.end());
        todays.insert(todays.end(), now.begin(), now.end());
    }
    std::printf("| all left out | | | %.1f | %.1f |\n", 100 * median(chosen), 100 * median(todays));
}

bool ends_with(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// Medians over all wheels but one set, by which docs/decisions/bow.md decides.
void print_left_out(const std::vector<Errors>& all) {
    std::vector<std::string> wheels{"nothing"};
    for (const auto& [set, unused] : all.front().sets()) {
        if (ends_with(set, ", pull")) wheels.push_back(set.substr(0, set.find(", ")));
    }
    for (const std::string quantity : {", pull", ", side", ", sinkage"}) {
        print_head(quantity.substr(2) + " without", bow_laws());
        for (const std::string& left_out : wheels) {
            std::printf("| %s |", left_out.c_str());
            for (const Errors& errors : all) {
                std::vector<double> rest;
                for (const auto& [set, own] : errors.sets()) {
                    if (!ends_with(set, quantity) || set == left_out + quantity) continue;
                    rest.insert(rest.end(), own.begin(), own.end());
                }
                std::printf(" %.1f |", 100 * median(rest));
            }
            std::printf("\n");
        }
    }
}

/// Pull, side force [N] and sinkage [mm] of wheels that are locked or braked.
void print_braked() {
    print_head("wheel and slip | measured", bow_laws());
    for (const Row& row : read("cmu_pavlov2022_wheel_means.csv")) {
        if (number(row, "slip_ratio") > -0.1) continue;
        std::printf("| %s at %s, %s | %.1f, %.1f; %.0f |", row.at("wheel").c_str(),
                    row.at("slip_angle_deg").c_str(), row.at("slip_ratio").c_str(),
                    number(row, "Fx_N"), number(row, "Fy_N"), number(row, "sinkage_mm"));
        for (const Law& law : bow_laws()) {
            const WheelForce f = pavlov_wheel(law, row);
            std::printf(" %.1f, %.1f; %.0f |", f.pull_n, f.side_n, 1e3 * f.sinkage_m);
        }
        std::printf("\n");
    }
}

/// Largest pull over load of a wheel of 0.2 m radius less tan phi.
double thrust_of(const Law& law, double phi_deg, int lug_count, double lug_height_m) {
    const Wheel wheel{{1500, phi_deg, 0, {}, {}, 0.01}, 0.2, 0.15, lug_count, lug_height_m, 0.005};
    double most = -1e9;
    for (const double slip : {0.1, 0.3, 0.6, 0.9}) {
        most = std::max(most, wheel_under_load(law, wheel, slip, 0, 200, false).pull_n / 200);
    }
    return most - std::tan(radians(phi_deg));
}

void print_thrust() {
    std::vector<double> most(bow_laws().size(), -1e9);
    for (const double phi : {25.0, 29.0, 33.0, 38.0, 42.0}) {
        for (const auto& [count, height_m] :
             {std::pair{0, 0.0}, {12, 0.01}, {24, 0.01}, {12, 0.03}, {24, 0.03}}) {
            std::printf("| %.0f | %d x %.0f mm |", phi, count, 1e3 * height_m);
            for (const Law& law : laws()) {
                std::printf(" %.2f |", thrust_of(law, phi, count, height_m));
            }
            std::printf("\n");
            for (size_t i = 0; i < most.size(); ++i) {
                most[i] = std::max(most[i], thrust_of(bow_laws()[i], phi, count, height_m));
            }
        }
    }
    std::printf("| largest thrust |");
    for (const double thrust : most) std::printf(" %.2f |", thrust);
    std::printf("\n");
}

void print_all() {
    const std::vector<Errors> all = errors_of(laws()), bows = errors_of(bow_laws());
    print_table(laws(), all);
    print_leave_one_out(all);
    print_table(bow_laws(), bows);
    print_left_out(bows);
    print_braked();
    print_thrust();
}

}  // namespace
}  // namespace bsoil::flat_bed

int main() {
    if (bsoil::flat_bed::read("obermayr2013_blade.csv").empty()) {
        std::printf("%s is not there\n", bsoil::measured_data("").c_str());
        return 77;
    }
    bsoil::flat_bed::print_all();
}
