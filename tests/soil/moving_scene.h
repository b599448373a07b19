/// A scene in which much happens, built from a seed: terrain, piles of several materials, bodies
/// that plough through them.
#pragma once

#include <random>

#include "soil_fixture.h"

namespace bsoil {

class MovingScene {
  public:
    /// A soil of 40 x 32 x 24 voxels with three materials. Everything is placed in the grid's own
    /// frame, so that scenes of differently turned grids are the same scene.
    MovingScene(unsigned seed, SoilDef def);
    static SoilDef default_def();

    StepReport step();
    void run(int steps);
    Soil& soil() { return *soil_; }
    /// Start the soil anew (after load()); bodies keep their course.
    void replace_soil(std::unique_ptr<Soil> soil) { soil_ = std::move(soil); }
    int64_t step_count() const { return step_count_; }
    /// Bodies as they are after `steps` steps, without stepping the soil.
    void skip_to(int64_t steps);

  private:
    void place_bodies();

    std::unique_ptr<Soil> soil_;
    std::vector<Mover> movers_;
    std::vector<SoilBody> bodies_;
    std::vector<double> phases_;
    int64_t step_count_ = 0;
};

}  // namespace bsoil
