#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include "../bridge/bullet_scene.h"
#include "../bridge/raycast_car.h"
#include "bsoil/bullet/soil_raycaster.h"
#include "bsoil/bullet/world_snapshot.h"
#include "targets.h"

namespace bsoil::fuzz {
namespace {

using bullet::SoilAction;

/// A soil with a box on it, a hinge, a multibody and a car.
struct World {
    bullet::BulletScene scene;
    std::unique_ptr<SoilAction> soil;
    std::unique_ptr<bullet::SoilRaycaster> caster;
    std::unique_ptr<bullet::Car> car;
    std::unique_ptr<btHingeConstraint> hinge;
    std::unique_ptr<btMultiBody> multibody;
    std::unique_ptr<btMultiBodyLinkCollider> collider;

    World() {
        SoilDef def;
        def.size_m = {3.2, 1, 1.6};
        def.voxel_m = 0.1;
        def.backend = Backend::cpu;
        def.thread_count = 1;
        soil = std::move(*SoilAction::create(*scene.world, def));
        require(soil->fill(BoxFill{{{-2, 0, -2}, {2, 0.4, 2}}, ""}).ok(), "no soil");
        btRigidBody& a = scene.add_box(10, {0.2f, 0.1f, 0.2f}, {-1, 0.5f, 0.2f});
        btRigidBody& b =
            scene.add(5, scene.shape<btSphereShape>(btScalar(0.15)), {-0.6f, 0.6f, 0.2f});
        hinge =
            std::make_unique<btHingeConstraint>(a, b, btVector3(0.3f, 0, 0), btVector3(-0.1f, 0, 0),
                                                btVector3(0, 0, 1), btVector3(0, 0, 1));
        hinge->enableAngularMotor(true, 1, 2);
        scene.world->addConstraint(hinge.get());
        multibody = std::make_unique<btMultiBody>(1, btScalar(5), btVector3(1, 1, 1), false, true);
        multibody->setBasePos({-1, 1.5f, -0.4f});
        multibody->setupRevolute(0, 4, btVector3(0.1f, 0.1f, 0.1f), -1, btQuaternion::getIdentity(),
                                 btVector3(0, 0, 1), btVector3(0.2f, 0, 0), btVector3(0.2f, 0, 0),
                                 true);
        multibody->finalizeMultiDof();
        scene.world->addMultiBody(multibody.get());
        collider = std::make_unique<btMultiBodyLinkCollider>(multibody.get(), 0);
        collider->setCollisionShape(&scene.shape<btBoxShape>(btVector3(0.1f, 0.1f, 0.1f)));
        scene.world->addCollisionObject(collider.get());
        multibody->getLink(0).m_collider = collider.get();
        caster = std::make_unique<bullet::SoilRaycaster>(*soil);
        car = std::make_unique<bullet::Car>(scene, *caster, 300, btVector3(0.8f, 1.0f, 0));
        require(caster->attach(*car->vehicle, bullet::SoilWheelDef{.width_m = 0.2}).ok(),
                "the car cannot be attached");
        step(2);
    }
    ~World() {
        car.reset();
        caster.reset();
        soil.reset();
        scene.world->removeConstraint(hinge.get());
        scene.world->removeCollisionObject(collider.get());
        scene.world->removeMultiBody(multibody.get());
    }
    void step(int count) {
        for (int i = 0; i < count; ++i) scene.world->stepSimulation(btScalar(1) / 60, 0);
    }
    Status save(const std::string& path) {
        SoilAction* soils[] = {soil.get()};
        return bullet::save_world(*scene.world, soils, path);
    }
    Status load(const std::string& path) {
        SoilAction* soils[] = {soil.get()};
        return bullet::load_world(*scene.world, soils, path);
    }
};

const std::vector<SnapshotSection>& good_sections() {
    static const std::vector<SnapshotSection> kSections = [] {
        World world;
        const std::string path = scratch_path("good.snapshot");
        require(world.save(path).ok(), "the world cannot be saved");
        auto sections = read_snapshot_file(path);
        require(sections.ok(), "its snapshot cannot be read");
        return *sections;
    }();
    return kSections;
}

}  // namespace

void fuzz_world_snapshot(Bytes bytes) {
    std::vector<SnapshotSection> sections = good_sections();
    Choices choices(bytes);
    // Most are refused for one change; more than one section is rarely worth it.
    SnapshotSection& changed =
        sections[static_cast<size_t>(choices.below(static_cast<int>(sections.size())))];
    if (!choices.at_end()) edit(changed.bytes, choices);
    const std::string path = scratch_path("changed.snapshot");
    if (!write_snapshot_file(path, sections)) return;
    World world;
    const uint64_t before = world.soil->soil().checksum();
    const Status loaded = world.load(path);
    if (!loaded) {
        require(world.soil->soil().checksum() == before, "a refused snapshot has changed the soil");
        world.step(1);
        return;
    }
    const std::vector<int64_t> units = world.soil->soil().totals().units;
    world.step(3);
    require(world.soil->soil().totals().units == units, "soil is not conserved");
}

}  // namespace bsoil::fuzz
