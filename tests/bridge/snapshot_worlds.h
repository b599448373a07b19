// Worlds that can be built any number of times, always alike, and what tests of their snapshots
// share.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bsoil/bullet/soil_raycaster.h"
#include "bsoil/bullet/world_snapshot.h"
#include "bullet_scene.h"
#include "raycast_car.h"
#include "snapshot_files.h"
#include "world_hash.h"

namespace bsoil::bullet {

constexpr btScalar kFrameS = btScalar(1) / 60;

/// A world that can be built any number of times, always alike.
struct TestWorld {
    BulletScene scene;
    std::vector<std::unique_ptr<btMotionState>> motion_states;
    std::vector<std::unique_ptr<btTypedConstraint>> constraints;
    std::unique_ptr<btMultiBody> multibody;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
    std::vector<std::unique_ptr<btMultiBodyConstraint>> multibody_constraints;
    std::unique_ptr<SoilAction> soil;
    std::unique_ptr<SoilRaycaster> caster;
    std::unique_ptr<Car> car;
    btRigidBody* driven = nullptr;
    std::function<void(TestWorld&)> command;  ///< before each frame
    int frame = 0;
    btScalar frame_s = kFrameS, substep_s = kFrameS / 2;

    ~TestWorld();
    btDiscreteDynamicsWorld& world() { return *scene.world; }
    void step();
    void run(int frames) {
        for (int i = 0; i < frames; ++i) step();
    }
    std::vector<SoilAction*> soils() {
        return soil ? std::vector<SoilAction*>{soil.get()} : std::vector<SoilAction*>{};
    }
    Status save(const std::string& path) { return save_world(world(), soils(), path); }
    Status load(const std::string& path) { return load_world(world(), soils(), path); }
    /// Of every pose and velocity and of the soil.
    uint64_t checksum() const;
};
using Build = std::function<std::unique_ptr<TestWorld>()>;

void add_soil(TestWorld& w, const SoilActionDef& options = {});
/// A blade that TestWorld::driven moves.
void add_driven_blade(TestWorld& w);

/// Soil, a wheel with a motor, a plate, a scoop of several boxes full of soil, a blade that is
/// driven, and a stone that comes in later.
std::unique_ptr<TestWorld> build_machine();
/// No soil: a heap of all kinds of shapes that falls apart and goes to sleep piece by piece.
std::unique_ptr<TestWorld> build_heap();
/// A car that spins its wheels, is steered over a block that lifts it, coasts, is braked and goes
/// to sleep; each command is given once. substeps: of 1/60 s, as is the soil's step.
std::unique_ptr<TestWorld> build_car(int substeps, const SoilWheelDef& wheel = {.width_m = 0.24});

class WorldSnapshot : public SnapshotFiles {
  protected:
    /// Runs a world, saves it, goes on; restores another and compares every step after.
    /// saving_shows: the run that saved goes on otherwise than one that did not.
    void expect_goes_on(const Build& build, int before, int after, bool saving_shows = false);
};

}  // namespace bsoil::bullet
