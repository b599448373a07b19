#include "telemetry.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <cmath>

#include "files/csv_cell.h"
#include "scene/rotations.h"

namespace bsoil::scene {

Telemetry::Telemetry(const SceneRun& run)
    : run_(&run),
      every_steps_(std::max(1LL, std::llround(run.scene().record.every_s / run.step_s()))) {
    const std::vector<std::string>& wanted = run.scene().record.bodies;
    const auto& bodies = run.bullet().bodies();
    for (size_t b = 0; b < bodies.size(); ++b) {
        const bool named = std::find(wanted.begin(), wanted.end(), bodies[b].name) != wanted.end();
        const bool moves = bodies[b].item->mass_kg > 0 || bodies[b].item->kinematic;
        if (wanted.empty() ? moves : named) bodies_.push_back(b);
    }
}

Result<Telemetry> Telemetry::create(const SceneRun& run, const std::string& folder) {
    Telemetry telemetry(run);
    const std::string path = folder + "/telemetry.csv";
    telemetry.folder_ = folder;
    telemetry.table_.open(path);
    telemetry.table_ << "time_s";
    // Names of a URDF's links may hold commas.
    const auto heading = [&](const std::string& name, const std::string& what) {
        telemetry.table_ << ',' << csv_cell(name + '.' + what);
    };
    for (const size_t b : telemetry.bodies_) {
        for (const char* column :
             {"x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", "vx_m_s", "vy_m_s", "vz_m_s", "fx_n",
              "fy_n", "fz_n", "tx_n_m", "ty_n_m", "tz_n_m", "sinkage_m", "load_kg"}) {
            heading(run.bullet().bodies()[b].name, column);
        }
    }
    for (const SceneJoint& joint : run.bullet().joints()) {
        heading(joint.name, joint.item->kind == "slider" ? "position_m" : "position_deg");
    }
    bool has_profiles = false;
    for (const ProbeItem& probe : run.scene().probes) {
        if (probe.kind == "mass_inside") {
            heading(probe.name, "kg");
        } else {
            has_profiles = true;
        }
    }
    telemetry.table_ << '\n';
    if (!telemetry.table_) {
        return Error{path + ": cannot be written; check its folder and the disk"};
    }
    if (has_profiles) {
        const std::string profiles = folder + "/profiles.csv";
        telemetry.profiles_.open(profiles);
        telemetry.profiles_ << "time_s,probe,distance_m,height_m\n";
        if (!telemetry.profiles_) {
            return Error{profiles + ": cannot be written; check its folder and the disk"};
        }
    }
    return telemetry;
}

void Telemetry::observe() {
    if (run_->step_count() % every_steps_ != 0) return;
    write_row();
    if (profiles_.is_open()) write_profiles();
}

Status Telemetry::finish() {
    const auto close = [&](std::ofstream& file, const char* name) -> Status {
        if (!file.is_open()) return Done{};
        file.close();
        if (file) return Done{};
        return Error{fmt::format("{}/{}: cannot be written whole; look whether the disk is full",
                                 folder_, name)};
    };
    const Status table = close(table_, "telemetry.csv");
    const Status profiles = close(profiles_, "profiles.csv");
    return table ? profiles : table;
}

void Telemetry::write_row() {
    const auto numbers = [&](Vec3 v) {
        fmt::print(table_, ",{:.6g},{:.6g},{:.6g}", v.x, v.y, v.z);
    };
    // Nine digits: steps of 0.5 ms after a day, and Bullet's floats as they are, far from the
    // origin.
    fmt::print(table_, "{:.9g}", run_->time_s());
    for (const size_t b : bodies_) {
        const SceneBody& body = run_->bullet().bodies()[b];
        const BodyReading& reading = run_->readings()[b];
        const Pose pose = body.pose();
        const Vec3 arm = rotate(pose.rotation, -body.frame_to_center.position);
        const Vec3 omega = body.angular_velocity_rad_s();
        const Vec3 at_m = pose.position;
        fmt::print(table_, ",{:.9g},{:.9g},{:.9g}", at_m.x, at_m.y, at_m.z);
        fmt::print(table_, ",{:.6g},{:.6g},{:.6g},{:.6g}", pose.rotation.x, pose.rotation.y,
                   pose.rotation.z, pose.rotation.w);
        numbers(body.linear_velocity_m_s() + cross(omega, arm));
        numbers(reading.force_n);
        numbers(reading.torque_n_m);
        fmt::print(table_, ",{:.6g},{:.6g}", reading.sinkage_m, reading.load_kg);
    }
    for (const SceneJoint& joint : run_->bullet().joints()) {
        fmt::print(table_, ",{:.6g}",
                   joint.item->kind == "slider" ? joint.position : joint.position / kDegree);
    }
    for (const ProbeItem& probe : run_->scene().probes) {
        if (probe.kind == "mass_inside") fmt::print(table_, ",{:.6g}", run_->probe_mass_kg(probe));
    }
    table_ << '\n';
}

void Telemetry::write_profiles() {
    for (const ProbeItem& probe : run_->scene().probes) {
        if (probe.kind != "profile") continue;
        for (int i = 0; i < probe.sample_count; ++i) {
            const double u = static_cast<double>(i) / (probe.sample_count - 1);
            const Vec3 at_m = probe.from_m * (1 - u) + probe.to_m * u;
            fmt::print(profiles_, "{:.9g},{},{:.6g},{:.6g}\n", run_->time_s(), csv_cell(probe.name),
                       u * length(probe.to_m - probe.from_m), surface_height_m(run_->soil(), at_m));
        }
    }
}

}  // namespace bsoil::scene
