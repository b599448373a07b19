/// What the window knows of the world: handed over by the simulation's thread, complete in itself.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/render/renderer.h"
#include "bsoil/soil.h"
#include "run/soil_field.h"

namespace bsoil::viewer {

/// What of the world has a surface of its own.
enum class SurfaceKind { soil, terrain, slice };

/// A part of a surface that has changed: takes the place of the part with the same kind and index.
struct SurfacePatch {
    SurfaceKind kind = SurfaceKind::soil;
    int index = 0;
    Mesh mesh;  ///< without triangles: there is nothing any more
};

/// What a lever stands at and what its joint does.
struct LeverState {
    double position = 0;  ///< of the joint [rad or m]
};

/// What is said of the simulation beside the picture.
struct RunStatus {
    double time_s = 0;
    long long step_count = 0;
    double step_s = 0;
    bool is_paused = true;
    bool is_finished = false;
    double steps_per_s = 0;  ///< of the wall clock
    double bullet_ms = 0;    ///< of the last step, without the soil
    double soil_ms = 0;      ///< of the last step: all stages
    double mesh_ms = 0;      ///< of the last picture
    StageTimes stage_ms;
    int block_active_count = 0, tile_awake_count = 0, contact_count = 0;
    double soil_mass_kg = 0;
    std::string units_text;               ///< soil at the start, put in and taken out since
    std::string hand_text;                ///< what the hand holds
    std::string failure;                  ///< of the soil's device: it goes no further
    std::vector<std::string> conditions;  ///< what went wrong, then what the soil has run into
    size_t note_count = 0;                ///< of those, the first ones
    std::vector<double> loads_kg;         ///< by probe
    std::vector<double> forces_n;         ///< soil on body, by body
    std::vector<LeverState> levers;
    scene::ColorBar bar;  ///< empty title: none
};

/// One picture of the world. Patches are those that changed since the last one that was taken.
struct WorldPicture {
    RunStatus status;
    std::vector<Pose> bodies;
    std::vector<SurfacePatch> patches;
    std::vector<render::Line> lines;
    std::vector<render::GrainGroup> grains;            ///< loose soil
    std::vector<render::DustPuff> dust;                ///< over it
    std::optional<Plane> slice;                        ///< where the slice through the soil lies
    std::optional<render::Volume> volume;              ///< in place of the soil's surface
    std::shared_ptr<const render::VolumeData> voxels;  ///< of it, where they have changed
    uint64_t world = 0;  ///< grows when the world was built anew: all patches before are void
};

}  // namespace bsoil::viewer
