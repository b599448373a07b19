/// A host that takes its world from a .bullet file and lays soil under it.
///
///   world_from_file FILE.bullet
///
/// Exit codes: 0 everything rests on the sand, 1 it does not, 2 could not run, 77 FILE is not
/// there.
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <bsoil/bullet/world_snapshot.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "robots/bullet_file.h"

namespace {

constexpr double kSandM = 0.4;  // deep

int could_not(const std::string& why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    return 2;
}

bool moves(const btCollisionObject& object) {
    if (object.getInternalType() == btCollisionObject::CO_FEATHERSTONE_LINK) return true;
    return !object.isStaticOrKinematicObject();
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return could_not("usage: world_from_file FILE.bullet");
    if (!std::filesystem::exists(argv[1])) {
        std::printf("SKIP %s is not there\n", argv[1]);
        return 77;
    }
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, 0, btScalar(-9.81)});

    auto file = bsoil::scene::BulletFile::load(argv[1], world);
    if (!file) return could_not(file.error());
    for (const std::string& missing : (*file)->missing()) std::printf("%s\n", missing.c_str());

    // Soil around the things that move, its surface just below the lowest of them.
    bsoil::Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
    int moving_count = 0;
    for (int i = 0; i < world.getNumCollisionObjects(); ++i) {
        btCollisionObject& object = *world.getCollisionObjectArray()[i];
        if (!moves(object)) continue;
        ++moving_count;
        btVector3 min, max;
        object.getCollisionShape()->getAabb(object.getWorldTransform(), min, max);
        low = {std::fmin(low.x, min.x()), std::fmin(low.y, min.y()), std::fmin(low.z, min.z())};
        high = {std::fmax(high.x, max.x()), std::fmax(high.y, max.y()), std::fmax(high.z, max.z())};
    }
    if (moving_count == 0) {
        return could_not("nothing in the file moves; give one with a body that has mass");
    }
    bsoil::SoilDef def;
    def.up = bsoil::UpAxis::z;
    def.voxel_m = 0.1;
    def.size_m = {high.x - low.x + 3, high.y - low.y + 3, high.z - low.z + kSandM + 1};
    def.floor_center_m = {(low.x + high.x) / 2, (low.y + high.y) / 2, low.z - kSandM - 0.05};
    bsoil::bullet::SoilActionDef options;
    for (const auto& body : (*file)->bodies()) {  // a ground that came along would lie in the sand
        if (!moves(*body.body)) options.ignored.push_back(body.body);
    }
    auto soil = bsoil::bullet::SoilAction::create(world, def, options);
    if (!soil) return could_not(soil.error());
    const bsoil::Vec3 floor = def.floor_center_m, half = def.size_m * 0.5;
    const auto filled =
        (*soil)->fill(bsoil::BoxFill{{{floor.x - half.x, floor.y - half.y, floor.z},
                                      {floor.x + half.x, floor.y + half.y, floor.z + kSandM}},
                                     "dry_sand"});
    if (!filled) return could_not(filled.error());

    for (int frame = 0; frame < 180; ++frame) world.stepSimulation(btScalar(1.0 / 60));

    int resting_count = 0;
    for (int i = 0; i < world.getNumCollisionObjects(); ++i) {
        const btCollisionObject& object = *world.getCollisionObjectArray()[i];
        if (!moves(object)) continue;
        const auto report = (*soil)->body_report(object);
        const double height_m =
            static_cast<double>(object.getWorldTransform().getOrigin().z()) - floor.z;
        std::printf(
            "object %d: %.3f m above the floor, %.3f m deep in the sand, carried by %.1f N\n", i,
            height_m, report.sinkage_m, bsoil::length(report.force_n));
        resting_count += height_m > kSandM / 2 && report.sinkage_m < kSandM / 2;
    }
    std::printf("%d of %d objects rest on the sand\n", resting_count, moving_count);
    return resting_count == moving_count ? 0 : 1;
}
