// A bed of dry sand in a Bullet world, for tests of bodies and worlds.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "bsoil/bullet/soil_action.h"
#include "bullet_scene.h"

namespace bsoil::bullet {

constexpr double kGravity_m_s2 = 9.81;
constexpr double kBedTopM = 0.4;  ///< height of the bed's surface

/// 2 x 1 x 2 m with voxels of 5 cm, Y up, on the CPU.
inline SoilDef small_bed() {
    SoilDef def;
    def.size_m = {2, 1, 2};
    def.voxel_m = 0.05;
    def.backend = Backend::cpu;
    def.thread_count = 1;
    return def;
}

inline std::unique_ptr<SoilAction> sand_bed(btDiscreteDynamicsWorld& world,
                                            const SoilDef& def = small_bed(),
                                            const SoilActionDef& options = {}) {
    auto soil = SoilAction::create(world, def, options);
    EXPECT_TRUE(soil) << soil.error();
    if (!soil) return nullptr;
    const double far = 2 * length(def.size_m) + length(def.floor_center_m);
    BoxFill fill{{{-far, -far, -far}, {far, far, far}}, def.material.name};
    (def.up == UpAxis::y ? fill.box.max.y : fill.box.max.z) = kBedTopM;
    const Status filled = (*soil)->fill(fill);
    EXPECT_TRUE(filled) << filled.error();
    return std::move(*soil);
}

inline int64_t units_of(const SoilAction& soil) {
    int64_t sum = 0;
    for (const int64_t u : soil.soil().totals().units) sum += u;
    return sum;
}

inline double height_of(const btCollisionObject& object) {
    return static_cast<double>(object.getWorldTransform().getOrigin().y());
}

inline void place(btCollisionObject& object, const btVector3& position) {
    btTransform pose = object.getWorldTransform();
    pose.setOrigin(position);
    object.setWorldTransform(pose);
    object.setInterpolationWorldTransform(pose);
}

inline bool is_finite(const btCollisionObject& object) {
    const btTransform& pose = object.getWorldTransform();
    btScalar sum = 0;
    for (int i = 0; i < 3; ++i) sum += pose.getOrigin()[i] + pose.getRotation()[i];
    return std::isfinite(sum);
}

}  // namespace bsoil::bullet
