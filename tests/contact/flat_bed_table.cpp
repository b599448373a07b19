// A law beside measurements without a grid: forces on exact surfaces in a flat bed, as the coupling
// would find them at yield. Rules are told apart here in seconds; heaps, ruts and Bullet's solver
// come on top in `bsoil validate`.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>

#include "bsoil/contact/contact_faces.h"
#include "bsoil/contact/granular_law.h"
#include "bsoil/contact/plain_law.h"
#include "oracle/resistive_force.h"

namespace bsoil {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNever = -1;  ///< a shear displacement that no rule asks for

double radians(double degrees) { return degrees * kPi / 180; }

/// Rows of a CSV file by column.
using Row = std::map<std::string, std::string>;
std::vector<Row> read(const std::string& name) {
    std::ifstream file(std::string(BULLETSOIL_DATA_DIR "/terramechanics/") + name);
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

/// What a law is changed by. Each is tried alone and with others.
struct Rules {
    bool wedge = false;    ///< a wall meets no more than its passive wedge: the library's rule
    bool bearing = false;  ///< a sole bears no less than its bearing capacity
    bool bow = false;      ///< what moves forward is pushed by a force within phi of its motion
    double shear_k_m = 0;  ///< Janosi's K; 0: shear is there at once
    bool smooth_metal = false;  ///< rims have two thirds of the soil's angle, else all of it
    /// trapped: the library's rule; full: the same, the space between lugs taken as filled
    enum class Lugs { apart, cylinder, full, trapped } lugs = Lugs::apart;
};

struct Law {
    std::string name;
    bool is_granular = false;
    Rules rules;
};

struct Soil {
    double density_kg_m3, friction_angle_deg, cohesion_pa = 0;
    std::optional<double> loose_kg_m3 = {}, compacted_kg_m3 = {};
    double published_k_m = 0;  ///< what the experiments of `bsoil validate` give today's law
};

/// A body in a flat bed, pushed in a given way.
struct Case {
    Soil soil;
    double friction = 0;
    const std::vector<oracle::Facet>* surface = nullptr;
    const std::vector<ToothRow>* teeth = nullptr;  ///< of each facet, in the body's frame
    oracle::Intruder motion;
    double radius_m = 0;  ///< of a wheel about its y axis, for the shear displacement; else 0
    double edge_m = 0.01;
};

/// Length of the path that a wheel's surface has slid along the soil since it entered it.
double sheared_m(const Case& c, Vec3 arm, double sinkage_m) {
    const Vec3 axle = rotate(c.motion.pose.rotation, {0, 1, 0});
    const double omega = dot(c.motion.angular_velocity_rad_s, axle);
    if (!(c.radius_m > 0) || std::abs(omega) < 1e-9) return 1e9;
    constexpr int kSteps = 24;
    // Back along its circle to where it came in.
    double path = 0;
    const double step_rad = kPi / 2 / kSteps;
    for (int i = 0; i < kSteps; ++i) {
        const Vec3 velocity = c.motion.velocity_m_s + cross(c.motion.angular_velocity_rad_s, arm);
        const Vec3 flat = arm - dot(arm, axle) * axle;
        const double size = length(flat);
        const Vec3 n = size > 0 ? flat * (1 / size) : Vec3{0, 0, -1};
        path += length(velocity - dot(velocity, n) * n) * step_rad / std::abs(omega);
        const double a = omega > 0 ? -step_rad : step_rad;
        const Vec3 turned = std::cos(a) * flat + std::sin(a) * cross(axle, flat);
        arm = turned + dot(arm, axle) * axle;
        if (-arm.z < c.radius_m - sinkage_m) break;
    }
    return path;
}

/// Forces of the law on exact surfaces. Each element that moves into the soil gives its limit and
/// its friction along its sliding, as a row of the coupling at yield does.
oracle::Wrench force_of(const Law& law, const Case& c, double sinkage_m) {
    MaterialDef material;
    material.density_kg_m3 = c.soil.density_kg_m3;
    material.loose_density_kg_m3 = material.compacted_density_kg_m3 = 0;
    material.friction_angle_rad = radians(c.soil.friction_angle_deg);
    material.cohesion_pa = law.is_granular ? c.soil.cohesion_pa : 0;
    material.tool_friction = c.friction;
    material.shear_displacement_m = law.is_granular ? c.soil.published_k_m : 0;
    auto soil = std::make_shared<ContactSoil>();
    soil->materials = {material};
    soil->voxel_m = c.edge_m;
    soil->law.kind = law.is_granular ? ContactLawDef::Kind::granular : ContactLawDef::Kind::plain;
    soil->law.passive_wedge = law.rules.wedge;
    soil->law.trapped_soil = law.rules.lugs == Rules::Lugs::trapped;
    const auto contact_law = ContactLaw::make(soil);
    const SoilStrength strength = strength_of(material, 9.81);
    const double tan_phi = std::tan(material.friction_angle_rad);

    std::vector<ContactVoxel> voxels;
    std::vector<Vec3> arms;
    for (size_t i = 0; i < c.surface->size(); ++i) {
        const oracle::Facet& facet = (*c.surface)[i];
        const Vec3 arm = rotate(c.motion.pose.rotation, facet.at);
        const double depth_m = -(c.motion.pose.position.z + arm.z);
        if (depth_m <= 0) continue;
        ContactVoxel& v = voxels.emplace_back();
        v.center_m = v.position_m = c.motion.pose.position + arm;
        v.normal = rotate(c.motion.pose.rotation, facet.normal);
        v.area_m2 = facet.area_m2;
        v.depth_m = v.bearing_depth_m = depth_m;
        v.relative_density = -1;
        if (c.teeth) {
            v.teeth = (*c.teeth)[i];
            v.teeth.outward = rotate(c.motion.pose.rotation, v.teeth.outward);
        }
        arms.push_back(arm);
    }
    oracle::Wrench sum;
    if (voxels.empty()) return sum;
    ContactFaces faces;
    faces.find(voxels, c.motion.pose.rotation, *contact_law, c.edge_m);
    double extent_m = 0;
    for (const Vec3& arm : arms) extent_m = std::max(extent_m, length(arm));
    const double fastest =
        length(c.motion.velocity_m_s) + extent_m * length(c.motion.angular_velocity_rad_s);
    for (size_t i = 0; i < voxels.size(); ++i) {
        const ContactVoxel& v = voxels[i];
        const Vec3 velocity =
            c.motion.velocity_m_s + cross(c.motion.angular_velocity_rad_s, arms[i]);
        const Vec3 share = velocity * (1 / fastest);
        const double approach = dot(share, v.normal);
        if (approach <= 1e-9) continue;
        const FaceExtent& face = faces.of_voxel(i);
        const double k_m = law.is_granular ? c.soil.published_k_m : law.rules.shear_k_m;
        const double j_m = k_m > 0 ? sheared_m(c, arms[i], sinkage_m) : kNever;
        const ElementYield yield =
            contact_law->yield({v, face}, {share, 0}, {j_m < 0 ? 1e9 : j_m, 0});
        double normal_pa = yield.normal_limit_pa, friction = yield.friction;
        const double down = std::max(0.0, -v.normal.z), sole = down * down;
        if (law.rules.bearing) {
            normal_pa *= sole * face_factors(strength, face, v.depth_m).sole + 1 - sole;
        }
        if (law.rules.shear_k_m > 0) {
            friction = std::min(friction, tan_phi * -std::expm1(-j_m / law.rules.shear_k_m));
        }
        const Vec3 slide = share - approach * v.normal;
        const double sliding = length(slide);
        Vec3 stress = -normal_pa * v.normal;
        if (yield.normal_limit_pa > 0) {
            stress += (normal_pa / yield.normal_limit_pa) * yield.drag_pa;
        }
        if (sliding > 0) stress += slide * (-(friction * normal_pa + yield.adhesion_pa) / sliding);
        if (law.rules.bow && velocity.x > 0 && length(stress) > 0) {
            // Turned towards -v until within phi of it, at the same size.
            const Vec3 back = velocity * (-1 / length(velocity));
            const double size = length(stress), along = dot(stress, back);
            const Vec3 across = stress - along * back;
            const double cos_phi = 1 / std::hypot(1, tan_phi);
            if (along < size * cos_phi && length(across) > 0) {
                stress = size * (cos_phi * back +
                                 std::sqrt(1 - cos_phi * cos_phi) / length(across) * across);
            }
        }
        const Vec3 force = v.area_m2 * yield.area_share * stress;
        sum.force_n += force;
        sum.moment_n_m += cross(arms[i], force);
    }
    return sum;
}

ConvexShape cylinder(double radius_m, double width_m, bool lies) {
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::cylinder;
    shape.radius_m = radius_m;
    shape.half_height_m = width_m / 2;
    if (lies) shape.local.rotation = {std::sin(kPi / 4), 0, 0, std::cos(kPi / 4)};
    return shape;
}

/// A wheel of a measurement.
struct Wheel {
    Soil soil;
    double radius_m, width_m;
    int lug_count = 0;
    double lug_height_m = 0, lug_thickness_m = 0;
};

double friction_of(const Law& law, const Wheel& wheel, bool as_cylinder, bool today_smooth) {
    const double phi = radians(wheel.soil.friction_angle_deg);
    // Between lugs the soil shears on itself.
    if (wheel.lug_count > 0 && (law.is_granular || as_cylinder)) return std::tan(phi);
    const bool smooth = law.is_granular ? today_smooth : law.rules.smooth_metal;
    return std::tan(smooth ? 2 * phi / 3 : phi);
}

struct WheelForce {
    double pull_n = 0, side_n = 0, sinkage_m = 0, torque_n_m = 0;
};

/// Rim and lugs; one place of the lugs out of three. Made once.
const std::vector<oracle::Facet>& surface_of(const Wheel& wheel, bool as_cylinder, int phase,
                                             double edge_m) {
    static std::map<std::vector<double>, std::vector<oracle::Facet>> made;
    const bool has_lugs = wheel.lug_count > 0 && !as_cylinder;
    const double tip_m = wheel.lug_count > 0 ? wheel.lug_height_m : 0;
    const double r = wheel.radius_m + (as_cylinder ? tip_m : 0);
    std::vector<oracle::Facet>& out = made[{r, wheel.width_m, has_lugs ? wheel.lug_count + 0.0 : 0,
                                            tip_m, wheel.lug_thickness_m, phase + 0.0}];
    if (!out.empty()) return out;
    std::vector<ConvexShape> solids{cylinder(r, wheel.width_m, true)};
    for (int i = 0; i < (has_lugs ? wheel.lug_count : 0); ++i) {
        const double a = 2 * kPi * (i + (phase + 0.5) / 3) / wheel.lug_count;
        const double root = 0.9 * wheel.radius_m, top = wheel.radius_m + tip_m;
        ConvexShape& lug = solids.emplace_back();
        lug.half_extents_m = {wheel.lug_thickness_m / 2, wheel.width_m / 2, (top - root) / 2};
        lug.local.rotation = {0, std::sin(a / 2), 0, std::cos(a / 2)};
        lug.local.position = rotate(lug.local.rotation, {0, 0, (root + top) / 2});
    }
    return out = oracle::surface_of(solids, edge_m);
}

/// Rim and lugs as above, then the surface over the tips; and the row that each facet is of.
struct ToothedSurface {
    std::vector<oracle::Facet> facets;
    std::vector<ToothRow> teeth;
};
const ToothedSurface& toothed_surface_of(const Wheel& wheel, int phase, double edge_m) {
    static std::map<std::vector<double>, ToothedSurface> made;
    ToothedSurface& out = made[{wheel.radius_m, wheel.width_m, wheel.lug_count + 0.0,
                                wheel.lug_height_m, wheel.lug_thickness_m, phase + 0.0}];
    if (!out.facets.empty()) return out;
    const auto add = [&](const oracle::Facet& facet, bool is_over_tips) {
        const double r = std::hypot(facet.at.x, facet.at.z);
        const bool is_disc = std::abs(facet.normal.y) > 0.5 && r <= wheel.radius_m;
        if (is_disc && is_over_tips) return;
        out.facets.push_back(facet);
        out.teeth.push_back(
            is_disc ? ToothRow{}
                    : ToothRow{wheel.lug_height_m, wheel.lug_thickness_m,
                               2 * kPi * wheel.radius_m / wheel.lug_count, r - wheel.radius_m,
                               Vec3{facet.at.x, 0, facet.at.z} * (1 / r), is_over_tips});
    };
    for (const oracle::Facet& facet : surface_of(wheel, false, phase, edge_m)) add(facet, false);
    for (const oracle::Facet& facet : surface_of(wheel, true, phase, edge_m)) add(facet, true);
    return out;
}

oracle::Wrench wheel_at(const Law& law, const Wheel& wheel, double slip, double angle_rad,
                        double sinkage_m, bool as_cylinder, bool today_smooth) {
    const double tip_m = wheel.lug_count > 0 ? wheel.lug_height_m : 0;
    Case c;
    c.soil = wheel.soil;
    c.friction = friction_of(law, wheel, as_cylinder, today_smooth);
    c.radius_m = wheel.radius_m + tip_m;
    c.edge_m = wheel.radius_m / 16;
    // The data's slip is of the speed of travel, at any slip angle.
    const double rim = slip >= 0 ? 1 / (1 - std::min(slip, 0.999)) : 1 + slip;
    const Quat yaw{0, 0, std::sin(angle_rad / 2), std::cos(angle_rad / 2)};
    oracle::Wrench mean;
    const int phases = wheel.lug_count > 0 && !as_cylinder ? 3 : 1;
    for (int phase = 0; phase < phases; ++phase) {
        if (wheel.lug_count > 0 && law.rules.lugs == Rules::Lugs::trapped) {
            const ToothedSurface& surface = toothed_surface_of(wheel, phase, c.edge_m);
            c.surface = &surface.facets;
            c.teeth = &surface.teeth;
        } else {
            c.surface = &surface_of(wheel, as_cylinder, phase, c.edge_m);
        }
        c.motion.pose = {{0, 0, wheel.radius_m - sinkage_m}, yaw};
        c.motion.velocity_m_s = {1, 0, 0};
        c.motion.angular_velocity_rad_s = rotate(yaw, {0, rim / wheel.radius_m, 0});
        const oracle::Wrench found = force_of(law, c, sinkage_m + tip_m);
        mean.force_n += found.force_n * (1.0 / phases);
        mean.moment_n_m += found.moment_n_m * (1.0 / phases);
    }
    return mean;
}

/// Share of the soil between lugs that goes round with the wheel: the passive wedge before a lug
/// over the pitch.
double trapped_share(const Wheel& wheel) {
    const double pitch = 2 * kPi * wheel.radius_m / wheel.lug_count;
    const double wedge =
        wheel.lug_height_m * std::tan(kPi / 4 + radians(wheel.soil.friction_angle_deg) / 2);
    return std::min(1.0, (wedge + wheel.lug_thickness_m) / pitch);
}

WheelForce wheel_under_load(const Law& law, const Wheel& wheel, double slip, double angle_rad,
                            double load_n, bool today_smooth) {
    const auto at = [&](double sinkage_m) {
        if (wheel.lug_count == 0 || law.rules.lugs == Rules::Lugs::apart ||
            law.rules.lugs == Rules::Lugs::trapped || law.is_granular) {
            return wheel_at(law, wheel, slip, angle_rad, sinkage_m, false, today_smooth);
        }
        oracle::Wrench plug = wheel_at(law, wheel, slip, angle_rad, sinkage_m, true, today_smooth);
        if (law.rules.lugs == Rules::Lugs::cylinder) return plug;
        const double share = trapped_share(wheel);
        const oracle::Wrench apart =
            wheel_at(law, wheel, slip, angle_rad, sinkage_m, false, today_smooth);
        return oracle::Wrench{share * plug.force_n + (1 - share) * apart.force_n,
                              share * plug.moment_n_m + (1 - share) * apart.moment_n_m};
    };
    double low = wheel.lug_count > 0 ? -wheel.lug_height_m : 0, high = 1.1 * wheel.radius_m;
    for (int i = 0; i < 14; ++i) {
        const double middle = (low + high) / 2;
        (at(middle).force_n.z < load_n ? low : high) = middle;
    }
    const oracle::Wrench found = at(high);
    const Vec3 heading{std::cos(angle_rad), std::sin(angle_rad), 0};
    const Vec3 axle{-heading.y, heading.x, 0};
    return {dot(found.force_n, heading), dot(found.force_n, axle), high,
            -dot(found.moment_n_m, axle)};
}

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

const Soil kPavlov{1330, 29, 0, {}, {}, 0.025}, kDing{1605, 31.9, 250, {}, {}, 0.011},
    kObermayr{1440, 35};

Errors errors_of(const Law& law) {
    Errors errors;
    for (const Row& row : read("cmu_pavlov2022_wheel_means.csv")) {
        Wheel wheel{kPavlov, 0.058, 0.05};
        const bool lugs = row.at("wheel") != "smooth";
        if (lugs) {
            wheel.lug_count = 12;
            wheel.lug_height_m = 0.005;
            wheel.lug_thickness_m = 0.003;
        }
        const double angle = number(row, "slip_angle_deg"), load_n = number(row, "Fz_N");
        const WheelForce f = wheel_under_load(law, wheel, number(row, "slip_ratio"),
                                              radians(std::min(angle, 89.9)), load_n, false);
        const std::string set = std::string("pavlov ") + (lugs ? "lugs" : "smooth") +
                                (angle > 0 ? " at " + row.at("slip_angle_deg") : "");
        errors.add(set + ", pull", f.pull_n, number(row, "Fx_N"), load_n);
        errors.add(set + ", sinkage", f.sinkage_m, 1e-3 * number(row, "sinkage_mm"));
        if (lugs) {
            errors.add(set + ", sinkage of the tips", f.sinkage_m + wheel.lug_height_m,
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
        {"+ bow", false, {.bow = true}},
        {"wedge, trapped", false, {.wedge = true, .lugs = L::trapped}},
        {"wedge, trapped, K", false, {.wedge = true, .shear_k_m = 0.003, .lugs = L::trapped}},
    };
    return list;
}

void print_table() {
    std::vector<Errors> all;
    std::printf("| |");
    for (const Law& law : laws()) {
        all.push_back(errors_of(law));
        std::printf(" %s |", law.name.c_str());
    }
    std::printf("\n");
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
        std::printf("| all: %s (%zu) |", kind.c_str(), errors.front().size());
        for (const auto& own : errors) std::printf(" %.1f |", 100 * median(own));
        std::printf("\n");
    }
}

/// Decides by the pull on all wheels but one set, and looks at that one afterwards.
void print_leave_one_out() {
    std::vector<Errors> all;
    for (const Law& law : laws()) all.push_back(errors_of(law));
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

/// Largest pull over load of a wheel of 0.2 m radius less tan phi.
void print_thrust() {
    for (const double phi : {25.0, 29.0, 33.0, 38.0, 42.0}) {
        for (const auto& [count, height_m] :
             {std::pair{0, 0.0}, {12, 0.01}, {24, 0.01}, {12, 0.03}, {24, 0.03}}) {
            const Wheel wheel{{1500, phi, 0, {}, {}, 0.01}, 0.2, 0.15, count, height_m, 0.005};
            std::printf("| %.0f | %d x %.0f mm |", phi, count, 1e3 * height_m);
            for (const Law& law : laws()) {
                double most = -1e9;
                for (const double slip : {0.1, 0.3, 0.6, 0.9}) {
                    most = std::max(most,
                                    wheel_under_load(law, wheel, slip, 0, 200, false).pull_n / 200);
                }
                std::printf(" %.2f |", most - std::tan(radians(phi)));
            }
            std::printf("\n");
        }
    }
}

}  // namespace
}  // namespace bsoil

int main() {
    if (bsoil::read("obermayr2013_blade.csv").empty()) {
        std::printf("no measured data in %s\n", BULLETSOIL_DATA_DIR);
        return 77;
    }
    bsoil::print_table();
    bsoil::print_leave_one_out();
    bsoil::print_thrust();
}
