#include "bsoil/contact/bekker_soil.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include "bsoil/contact/granular_law.h"

namespace bsoil {
namespace {

/// Bounds of the search. Ours: MaterialDef takes densities up to 4000 kg/m3, and loose soil still
/// has to become compacted. A larger least one: light soils are refused.
constexpr double kDensityLeast_kg_m3 = 200, kDensityMost_kg_m3 = 4000 * kLooseOverCompacted;
constexpr size_t kCountMost = 64;
/// Cells of the coarse search; a basin of the error narrower than one may be missed.
constexpr int kCellCount = 20;
/// Golden sections that follow it, each leaves 0.618 of the cell's neighbourhood.
constexpr int kSectionCount = 25;

std::string text(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

/// NaN fails.
Status check(const std::string& field, double value, double low, double high) {
    if (value >= low && value <= high) return Done{};
    return Error{field + " is " + text(value) + ", must be " + text(low) + " to " + text(high)};
}

Status check_list(const std::string& field, const std::vector<double>& values, double low,
                  double high) {
    if (values.empty() || values.size() > kCountMost) {
        return Error{field + " has " + std::to_string(values.size()) + " values, must have 1 to " +
                     std::to_string(kCountMost)};
    }
    for (const double value : values) {
        if (Status s = check(field, value, low, high); !s) return s;
    }
    return Done{};
}

double bekker_modulus(const BekkerSoil& soil, double plate_radius_m) {
    return soil.kc_pa_m_n1 / plate_radius_m + soil.kphi_pa_m_n;
}

Status check_soil(const BekkerSoil& soil, const BekkerOptions& options) {
    if (Status s = soil.validate(); !s) return s;
    for (const double radius_m : options.plate_radii_m) {
        if (!(bekker_modulus(soil, radius_m) > 0)) {
            return Error{"kc is " + text(soil.kc_pa_m_n1) + ", must exceed " +
                         text(-soil.kphi_pa_m_n * radius_m) + " (kphi " + text(soil.kphi_pa_m_n) +
                         "): under a plate of radius " + text(radius_m) +
                         " m the pressure would not be positive"};
        }
    }
    return Done{};
}

/// The place of the least value of f in [low, high]: the best of evenly spaced points, then golden
/// section around it.
template <typename F>
double least_place(double low, double high, const F& f) {
    if (!(high > low)) return low;
    const auto point = [&](int i) {  // both ends exactly
        return std::lerp(low, high, static_cast<double>(std::clamp(i, 0, kCellCount)) / kCellCount);
    };
    int best = 0;
    double least = f(low);
    for (int i = 1; i <= kCellCount; ++i) {
        const double value = f(point(i));
        if (value < least) {
            least = value;
            best = i;
        }
    }
    constexpr double ratio = std::numbers::phi - 1;
    double a = point(best - 1), b = point(best + 1);
    double c = b - ratio * (b - a), d = a + ratio * (b - a);
    double at_c = f(c), at_d = f(d);
    for (int i = 0; i < kSectionCount; ++i) {
        if (at_c < at_d) {
            b = d;
            d = c;
            at_d = at_c;
            c = b - ratio * (b - a);
            at_c = f(c);
        } else {
            a = c;
            c = d;
            at_c = at_d;
            d = a + ratio * (b - a);
            at_d = f(d);
        }
    }
    // An end of the range is a possible answer that sections only come near to.
    const double middle = (a + b) / 2;
    return f(middle) < least ? middle : point(best);
}

/// The material of a soil, with a density as placed and a relative density.
MaterialDef material_of(const BekkerSoil& soil, double density_kg_m3, double relative_density) {
    MaterialDef out;
    out.density_kg_m3 = density_kg_m3;
    // MaterialDef::relative_density solved for the loose density.
    out.loose_density_kg_m3 = density_kg_m3 * (1 - relative_density * (1 - kLooseOverCompacted));
    out.compacted_density_kg_m3 =
        std::max(density_kg_m3, out.loose_density_kg_m3 / kLooseOverCompacted);
    out.friction_angle_rad = soil.friction_angle_rad;
    out.cohesion_pa = soil.cohesion_pa;
    out.shear_displacement_m = soil.shear_displacement_m;
    return out;
}

std::vector<BearingComparison> compare(const BekkerSoil& soil, const MaterialDef& material,
                                       const BekkerOptions& options) {
    std::vector<BearingComparison> out;
    out.reserve(options.plate_radii_m.size() * options.sinkages_m.size());
    for (const double radius_m : options.plate_radii_m) {
        for (const double sinkage_m : options.sinkages_m) {
            out.push_back({radius_m, sinkage_m,
                           bekker_modulus(soil, radius_m) * std::pow(sinkage_m, soil.n),
                           plate_bearing_pa(material, options.gravity_m_s2, radius_m, sinkage_m)});
        }
    }
    return out;
}

double mean_square_log_ratio(const std::vector<BearingComparison>& comparisons) {
    double sum = 0;
    for (const BearingComparison& c : comparisons) {
        const double log_ratio = std::log(c.soil_pa / c.bekker_pa);
        sum += log_ratio * log_ratio;
    }
    return sum / static_cast<double>(comparisons.size());
}

}  // namespace

Status BekkerSoil::validate() const {
    for (const Status& status :
         {check("kphi", kphi_pa_m_n, 0, 1e9), check("kc", kc_pa_m_n1, -1e8, 1e8),
          check("n", n, 0, 2.5), check("cohesion_pa", cohesion_pa, 0, 200e3),
          check("friction_angle_rad", friction_angle_rad, 0, 1.2),
          check("shear_displacement_m", shear_displacement_m, 0, 0.2)}) {
        if (!status) return status;
    }
    if (density_kg_m3) {
        const Status s =
            check("density_kg_m3", *density_kg_m3, kDensityLeast_kg_m3, kDensityMost_kg_m3);
        if (!s) return s;
    }
    if (kphi_pa_m_n == 0 && kc_pa_m_n1 == 0) {
        return Error{"kphi and kc are 0: one of them must be positive"};
    }
    return Done{};
}

Status BekkerOptions::validate() const {
    for (const Status& status : {check("gravity_m_s2", gravity_m_s2, 0.1, 30),
                                 check_list("plate_radii_m", plate_radii_m, 1e-3, 10),
                                 check_list("sinkages_m", sinkages_m, 1e-4, 10),
                                 check("density_least_kg_m3", density_least_kg_m3,
                                       kDensityLeast_kg_m3, kDensityMost_kg_m3),
                                 check("density_most_kg_m3", density_most_kg_m3,
                                       density_least_kg_m3, kDensityMost_kg_m3)}) {
        if (!status) return status;
    }
    return Done{};
}

double plate_bearing_pa(const MaterialDef& material, double gravity_m_s2, double plate_radius_m,
                        double sinkage_m) {
    ContactVoxel contact;
    contact.normal = {0, 0, -1};
    contact.depth_m = contact.bearing_depth_m = sinkage_m;
    // A disc has the second moments of area of a square of this side.
    const double side_m = std::sqrt(3.0) * plate_radius_m;
    const FaceExtent plate{
        side_m, side_m, sinkage_m,
        material.has_density_range() ? material.relative_density(material.density_kg_m3) : 0};
    const auto soil = std::make_shared<ContactSoil>();
    soil->gravity_m_s2 = gravity_m_s2;
    soil->materials = {material};
    return GranularLaw(soil, SurfaceFriction{}).yield({contact, plate}, {}, {}).normal_limit_pa;
}

Result<BekkerTranslation> translate(const BekkerSoil& soil, const BekkerOptions& options) {
    if (Status s = options.validate(); !s) return Error{s.error()};
    if (Status s = check_soil(soil, options); !s) return Error{s.error()};

    const double density_low = soil.density_kg_m3.value_or(options.density_least_kg_m3);
    const double density_high = soil.density_kg_m3.value_or(options.density_most_kg_m3);
    const auto error_of = [&](double density_kg_m3, double relative_density) {
        return mean_square_log_ratio(
            compare(soil, material_of(soil, density_kg_m3, relative_density), options));
    };
    const auto best_density = [&](double relative_density) {
        return least_place(density_low, density_high,
                           [&](double density) { return error_of(density, relative_density); });
    };

    BekkerTranslation out;
    out.relative_density = least_place(0, 1, [&](double relative_density) {
        return error_of(best_density(relative_density), relative_density);
    });
    out.material = material_of(soil, best_density(out.relative_density), out.relative_density);
    out.comparisons = compare(soil, out.material, options);

    std::vector<double> errors;
    for (const BearingComparison& c : out.comparisons) {
        if (!std::isfinite(c.soil_pa) || !(c.soil_pa > 0)) {
            return Error{"a soil of cohesion_pa " + text(soil.cohesion_pa) +
                         " and friction_angle_rad " + text(soil.friction_angle_rad) +
                         " bears no plate: one of them must be larger"};
        }
        errors.push_back(std::abs(c.relative_error()));
    }
    std::sort(errors.begin(), errors.end());
    const size_t half = errors.size() / 2;
    out.median_error = errors.size() % 2 ? errors[half] : (errors[half - 1] + errors[half]) / 2;
    out.largest_error = errors.back();
    return out;
}

}  // namespace bsoil
