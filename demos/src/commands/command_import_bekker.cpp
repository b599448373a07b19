/// `bsoil import-bekker`: a soil given by Bekker's, Mohr and Coulomb's and Janosi's parameters as a
/// [[material]] to paste into a scene, with the error of the translation.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <memory>
#include <numbers>

#include "bsoil/contact/bekker_soil.h"
#include "commands.h"

namespace bsoil::command {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFrictionMost_deg = 68;  // as in scenes

struct ImportArguments {
    BekkerSoil soil;
    BekkerOptions options;
    double friction_deg = 33;
    std::vector<double> scm;
    std::string name = "bekker_soil";
};

/// The parameters in the order of SCM's SetSoilParameters; its last two, elastic stiffness and
/// damping, are not used.
void take_scm_order(ImportArguments& arguments) {
    const std::vector<double>& scm = arguments.scm;
    if (scm.empty()) return;
    BekkerSoil& soil = arguments.soil;
    soil.kphi_pa_m_n = scm[0];
    soil.kc_pa_m_n1 = scm[1];
    soil.n = scm[2];
    soil.cohesion_pa = scm[3];
    arguments.friction_deg = scm[4];
    soil.shear_displacement_m = scm[5];
}

std::string percent(double share) { return fmt::format("{:+.0f} %", 100 * share); }

/// TOML as a whole: what is not the material is a comment.
std::string toml_text(const ImportArguments& arguments, const BekkerTranslation& found) {
    const BekkerSoil& soil = arguments.soil;
    const BekkerOptions& options = arguments.options;
    const MaterialDef& material = found.material;
    std::string out = fmt::format(
        "[[material]]\n"
        "# p = (kc / b + kphi) z^n, kphi {:.6g} N/m^(n+2), kc {:.6g} N/m^(n+1), n {:.6g}\n"
        "name = \"{}\"\n"
        "density_kg_m3 = {:.1f}\n"
        "loose_density_kg_m3 = {:.1f}\n"
        "compacted_density_kg_m3 = {:.1f}\n"
        "friction_angle_deg = {:.6g}\n"
        "cohesion_pa = {:.6g}\n"
        "shear_displacement_m = {:.6g}\n\n",
        soil.kphi_pa_m_n, soil.kc_pa_m_n1, soil.n, arguments.name, material.density_kg_m3,
        material.loose_density_kg_m3, material.compacted_density_kg_m3, arguments.friction_deg,
        material.cohesion_pa, material.shear_displacement_m);
    out += fmt::format("# relative density as placed: {:.2f}\n", found.relative_density);
    if (found.relative_density == 0 || found.relative_density == 1) {
        out +=
            "# it lies at the end of its range: Bekker's plates are beyond what density can do\n";
    }
    if (!soil.density_kg_m3 && (material.density_kg_m3 == options.density_least_kg_m3 ||
                                material.density_kg_m3 == options.density_most_kg_m3)) {
        out +=
            "# the density lies at the end of its range: give --density where it is known, for it "
            "is the soil's weight too\n";
    }
    out +=
        fmt::format("# error of the bearing against Bekker's: median {:.0f} %, largest {:.0f} %\n",
                    100 * found.median_error, 100 * found.largest_error);
    out += fmt::format("#\n# {:>8}  {:>9}  {:>10}  {:>10}  {:>7}\n", "radius m", "sinkage m",
                       "Bekker kPa", "soil kPa", "error");
    for (const BearingComparison& c : found.comparisons) {
        out += fmt::format("# {:8.3f}  {:9.3f}  {:10.2f}  {:10.2f}  {:>7}\n", c.plate_radius_m,
                           c.sinkage_m, c.bekker_pa / 1e3, c.soil_pa / 1e3,
                           percent(c.relative_error()));
    }
    return out;
}

int import_bekker(ImportArguments& arguments) {
    take_scm_order(arguments);
    // Here, so that the error speaks of degrees.
    if (!(arguments.friction_deg >= 0 && arguments.friction_deg <= kFrictionMost_deg)) {
        fmt::print(stderr, "friction-deg is {}, must be 0 to {}\n", arguments.friction_deg,
                   kFrictionMost_deg);
        return kCouldNotRun;
    }
    arguments.soil.friction_angle_rad = arguments.friction_deg * kDegree;
    const auto found = translate(arguments.soil, arguments.options);
    if (!found) {
        fmt::print(stderr, "{}\n", found.error());
        return kCouldNotRun;
    }
    fmt::print("{}", toml_text(arguments, *found));
    return kPassed;
}

}  // namespace

void add_import_bekker(CLI::App& app, int& exit_code) {
    auto arguments = std::make_shared<ImportArguments>();
    CLI::App* command = app.add_subcommand(
        "import-bekker",
        "turn Bekker, Mohr-Coulomb and Janosi parameters into a [[material]], with the error of "
        "the translation: 0 done, 2 a value is out of range");
    CLI::Option* scm =
        command
            ->add_option("scm", arguments->scm,
                         "all at once, in SCM's order: Kphi Kc n cohesion friction_deg janosi "
                         "[elastic_stiffness damping]; the last two are not used")
            ->expected(6, 8);
    const auto parameter = [&](const char* name, double& place, const char* help) {
        return command->add_option(name, place, help)->excludes(scm);
    };
    BekkerSoil& soil = arguments->soil;
    parameter("--kphi", soil.kphi_pa_m_n, "frictional modulus [N/m^(n+2)]");
    parameter("--kc", soil.kc_pa_m_n1, "cohesive modulus [N/m^(n+1)]");
    parameter("--n", soil.n, "exponent of sinkage")->capture_default_str();
    parameter("--cohesion", soil.cohesion_pa, "Mohr cohesion [Pa]")->capture_default_str();
    parameter("--friction-deg", arguments->friction_deg, "Mohr friction angle [deg]")
        ->capture_default_str();
    parameter("--janosi", soil.shear_displacement_m, "Janosi shear displacement K [m]")
        ->capture_default_str();
    command->add_option("--density", soil.density_kg_m3,
                        "bulk density [kg/m3]; searched for where it is not given");
    command
        ->add_option("--gravity", arguments->options.gravity_m_s2,
                     "where the parameters were measured [m/s2]")
        ->capture_default_str();
    command
        ->add_option("--radii", arguments->options.plate_radii_m,
                     "radii of the plates compared [m]")
        ->capture_default_str();
    command
        ->add_option("--sinkages", arguments->options.sinkages_m,
                     "sinkages at which they are compared [m]")
        ->capture_default_str();
    command->add_option("--name", arguments->name, "name of the material")
        ->check(CLI::Validator(
            [](std::string& name) {
                const bool plain =
                    !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
                        return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
                    });
                return plain ? std::string() : "must be letters, digits, _ and -";
            },
            ""))
        ->capture_default_str();
    command->callback([arguments, &exit_code] { exit_code = import_bekker(*arguments); });
}

}  // namespace bsoil::command
