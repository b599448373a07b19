/// Tables a run leaves behind: telemetry.csv and profiles.csv.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "scene_run.h"

namespace bsoil::scene {

/// Writes a row every RecordItem::every_s. Columns of telemetry.csv: time_s; of each body x_m, y_m,
/// z_m, qx, qy, qz, qw, vx_m_s, vy_m_s, vz_m_s, fx_n, fy_n, fz_n, tx_n_m, ty_n_m, tz_n_m (force and
/// torque of the soil, mean over the step, torque about the centre of mass) and sinkage_m; behind
/// them load_kg, the soil it carries; of each joint its position in deg or m; of each mass probe
/// kg. profiles.csv: time_s, probe, distance_m along the line, height_m above the grid's floor.
class Telemetry {
  public:
    /// The error names the file that cannot be written.
    static Result<Telemetry> create(const SceneRun& run, const std::string& folder);
    /// After every step, and once before the first.
    void observe();
    /// After the last one. Error: a file that could not be written whole, as on a full disk.
    Status finish();

  private:
    explicit Telemetry(const SceneRun& run);
    void write_row();
    void write_profiles();

    const SceneRun* run_;
    long long every_steps_;
    std::vector<size_t> bodies_;
    std::string folder_;
    std::ofstream table_, profiles_;
};

}  // namespace bsoil::scene
