// A thousand small bodies dropped on soil, and what bodies do to others that sleep.
#include <array>
#include <cstdint>
#include <cstring>
#include <random>
#include <tuple>
#include <unordered_set>

#include "sand_bed.h"
#include "temporary_file.h"

namespace bsoil::bullet::many_bodies_test {
namespace {

/// Boxes, spheres, hulls and compounds, 2..10 cm across, in layers over a bed of sand.
struct Rain {
    static constexpr int kSide = 32, kCount = 1000;
    BulletScene scene;
    std::unique_ptr<SoilAction> soil;
    std::vector<btRigidBody*> bodies;

    Rain() {
        SoilDef def;
        def.size_m = {10, 0.6, 10};
        def.voxel_m = 0.05;
        def.backend = Backend::cpu;
        soil = sand_bed(*scene.world, def);
        std::mt19937 random(1);  // its numbers are the same everywhere; a distribution's are not
        const auto uniform = [&random](double low, double high) {
            return static_cast<btScalar>(
                low + (high - low) * (static_cast<uint32_t>(random()) / 4294967296.0));
        };
        constexpr double kGridM = 9.6 / kSide;
        for (int i = 0; i < kCount; ++i) {
            const int x = i % kSide, z = i / kSide % kSide, layer = i / (kSide * kSide);
            const btScalar size = uniform(0.01, 0.05);
            const btVector3 at(btScalar((x + 0.5) * kGridM - 4.8) + uniform(-0.02, 0.02),
                               btScalar(kBedTopM + 0.09 + 0.12 * layer),
                               btScalar((z + 0.5) * kGridM - 4.8) + uniform(-0.02, 0.02));
            btCollisionShape& shape = shape_of(i % 4, size);
            btRigidBody& body = scene.add(btScalar(1500) * 8 * size * size * size, shape, at);
            body.setFriction(btScalar(0.6));
            bodies.push_back(&body);
        }
    }
    btCollisionShape& shape_of(int kind, btScalar size) {
        if (kind == 0) return scene.shape<btBoxShape>(btVector3(size, size * btScalar(0.7), size));
        if (kind == 1) return scene.shape<btSphereShape>(size);
        if (kind == 2) {
            auto& hull = static_cast<btConvexHullShape&>(scene.shape<btConvexHullShape>());
            hull.setMargin(btScalar(0.1) * size);
            for (int corner = 0; corner < 4; ++corner) {
                hull.addPoint(size * btVector3((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1,
                                               (corner == 1 || corner == 2) ? -1 : 1));
            }
            return hull;
        }
        auto& compound = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
        btTransform at = btTransform::getIdentity();
        for (const btScalar side : {btScalar(-0.6), btScalar(0.6)}) {
            at.setOrigin(btVector3(side * size, 0, 0));
            compound.addChildShape(
                at, &scene.shape<btBoxShape>(size * btVector3(btScalar(0.4), btScalar(0.3), 1)));
        }
        return compound;
    }
    int asleep_count() const {
        int count = 0;
        for (const btRigidBody* body : bodies) count += body->isActive() ? 0 : 1;
        return count;
    }
    /// Of all poses and of the soil, to the bit.
    uint64_t state() const {
        uint64_t hash = soil->soil().checksum();
        for (const btRigidBody* body : bodies) {
            const btTransform& pose = body->getWorldTransform();
            for (int i = 0; i < 12; ++i) {
                const auto value = static_cast<double>(i < 3 ? pose.getOrigin()[i]
                                                             : pose.getBasis()[i / 3 - 1][i % 3]);
                uint64_t bits = 0;
                std::memcpy(&bits, &value, sizeof bits);
                hash = (hash ^ bits) * 1099511628211u;
            }
        }
        return hash;
    }
};

/// Depths of a body's contacts, in the order of the voxels.
std::vector<double> depths_of(const SoilAction& soil, const btCollisionObject& body) {
    std::vector<double> depths;
    for (const ContactVoxel& contact : soil.last_report().contacts) {
        if (contact.body == soil.body_id(body)) depths.push_back(contact.depth_m);
    }
    return depths;
}

TEST(Sleeping, nothing_changes_for_a_sleeper_when_bodies_nearby_wake_the_tiles_around_it) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {4, 1, 3};
    const auto soil = sand_bed(*scene.world, def);
    const btVector3 half(0.15f, 0.15f, 0.15f);
    btRigidBody& sleeper = scene.add_box(40, half, btVector3(-0.8f, 0.56f, 0));
    scene.run(5);
    ASSERT_FALSE(sleeper.isActive());
    const std::vector<double> depths = depths_of(*soil, sleeper);
    ASSERT_GT(depths.size(), 50u);
    const int tiles_awake = soil->last_report().tile_awake_count;
    // It comes down next to it, 0.7 m away, and stops above the soil.
    btRigidBody& other = scene.add_box(0, half, btVector3(0.2f, 0.7f, 0));
    other.setCollisionFlags(other.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    other.setActivationState(DISABLE_DEACTIVATION);
    for (int frame = 0; frame < 40; ++frame) {
        place(other, other.getWorldTransform().getOrigin() - btVector3(0, 0.003f, 0));
        scene.run(1.0 / 60);
    }
    ASSERT_GT(soil->last_report().tile_awake_count, tiles_awake) << "else nothing is tested";
    const std::vector<double> now = depths_of(*soil, sleeper);
    ASSERT_EQ(now.size(), depths.size());
    // The depths and the width of the contact follow from each other, so last bits may go round.
    for (size_t i = 0; i < depths.size(); ++i) EXPECT_NEAR(now[i], depths[i], 1e-12);
}

/// All that a contact says.
auto words_of(const ContactVoxel& v) {
    const auto of = [](Vec3 a) { return std::array{a.x, a.y, a.z}; };
    return std::tuple{v.body,          v.carrier,  of(v.center_m),    of(v.position_m),
                      of(v.normal),    v.area_m2,  v.depth_m,         v.gap_m,
                      v.compression_m, v.material, v.relative_density};
}

TEST(Sleeping, bodies_keep_their_contacts_without_a_step_of_the_soil) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const btVector3 half(0.1f, 0.1f, 0.1f);
    for (const btScalar x : {btScalar(-0.4), btScalar(0), btScalar(0.4)}) {
        scene.add_box(20, half, btVector3(x, 0.51f, 0));
    }
    scene.run(4);
    for (const auto& body : scene.bodies) ASSERT_FALSE(body->isActive());
    ASSERT_TRUE(soil->last_report().contacts_unchanged);
    const auto kept = soil->last_report().contacts;
    std::vector<decltype(words_of({}))> before, after;
    for (const ContactVoxel& contact : kept) before.push_back(words_of(contact));
    ASSERT_GT(before.size(), 100u);
    const BodyReport report = soil->body_report(*scene.bodies.front());
    const TemporaryFile file("sleeping_contacts.snapshot");
    ASSERT_TRUE(soil->save(file.path()));
    ASSERT_TRUE(soil->load(file.path()));
    scene.run(1.0 / 60);
    EXPECT_FALSE(soil->last_report().contacts_unchanged) << "after load() all is looked at anew";
    for (const ContactVoxel& contact : soil->last_report().contacts) {
        after.push_back(words_of(contact));
    }
    EXPECT_TRUE(before == after);
    EXPECT_EQ(soil->body_report(*scene.bodies.front()).sinkage_m, report.sinkage_m);
    EXPECT_EQ(soil->body_report(*scene.bodies.front()).force_n.y, report.force_n.y);
}

TEST(Sleeping, soil_that_comes_or_goes_beside_is_seen) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box =
        scene.add_box(20, btVector3(0.1f, 0.1f, 0.1f), btVector3(0.01f, 0.51f, 0.02f));
    scene.run(4);
    ASSERT_FALSE(box.isActive());
    ASSERT_TRUE(soil->last_report().contacts_unchanged);
    const size_t count = soil->last_report().contacts.size();
    ASSERT_TRUE(soil->fill(BoxFill{{{0.11, 0, -0.2}, {0.4, 0.5, 0.2}}, "dry_sand"}));
    scene.run(1.0 / 60);
    EXPECT_FALSE(soil->last_report().contacts_unchanged);
    EXPECT_GT(soil->last_report().contacts.size(), count);
    scene.run(10);
    ASSERT_TRUE(soil->last_report().contacts_unchanged);
    // A layer that leaves level ground, so that nothing slides.
    ConvexShape layer;
    layer.kind = ConvexShape::Kind::box;
    layer.half_extents_m = {3, 0.5, 3};
    ASSERT_TRUE(soil->soil().take_out(layer, {{0, kBedTopM + 0.45, 0}, {}}));
    scene.run(1.0 / 60);
    EXPECT_FALSE(soil->last_report().contacts_unchanged);
}

TEST(Sleeping, a_body_pressed_in_beside_wakes_nobody) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {4, 1, 3};
    const auto soil = sand_bed(*scene.world, def);
    const btVector3 half(0.15f, 0.15f, 0.15f);
    btRigidBody& sleeper = scene.add_box(40, half, btVector3(-0.8f, 0.56f, 0));
    scene.run(5);
    btRigidBody& other = scene.add_box(0, half, btVector3(0.2f, 0.56f, 0));
    other.setCollisionFlags(other.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    other.setActivationState(DISABLE_DEACTIVATION);
    for (int frame = 0; frame < 60; ++frame) {
        place(other, other.getWorldTransform().getOrigin() - btVector3(0, 0.002f, 0));
        scene.run(1.0 / 60);
        ASSERT_FALSE(sleeper.isActive()) << "pressed in by " << 2 * frame - 10 << " mm";
    }
}

TEST(Sleeping, soil_dug_away_under_a_sleeper_wakes_it) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const btVector3 half(0.15f, 0.15f, 0.15f);
    btRigidBody& sleeper = scene.add_box(40, half, btVector3(0, 0.56f, 0));
    scene.run(5);
    ASSERT_FALSE(sleeper.isActive());
    const double before_m = height_of(sleeper);
    btRigidBody& blade = scene.add_box(0, btVector3(0.1f, 0.1f, 0.4f), btVector3(-0.8f, 0.28f, 0));
    blade.setCollisionFlags(blade.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    blade.setActivationState(DISABLE_DEACTIVATION);
    for (int frame = 0; frame < 160; ++frame) {
        place(blade, blade.getWorldTransform().getOrigin() + btVector3(0.01f, 0, 0));
        scene.run(1.0 / 60);
    }
    EXPECT_LT(height_of(sleeper), before_m - 0.02);
}

TEST(SlowManyBodies, come_to_rest_on_the_soil_and_sleep) {
    Rain rain;
    const int64_t before = units_of(*rain.soil);
    rain.scene.run(3.5);
    EXPECT_EQ(units_of(*rain.soil), before);
    for (const btRigidBody* body : rain.bodies) {
        ASSERT_TRUE(is_finite(*body));
        const btVector3& at = body->getWorldTransform().getOrigin();
        // A pebble of 10 cm does not sink deeper than itself into sand that carries a man.
        EXPECT_GT(at.y(), btScalar(kBedTopM - 0.1));
        EXPECT_LT(std::max(std::abs(at.x()), std::abs(at.z())), btScalar(5));
    }
    // Some smaller than a voxel touch the soil in a single one and rock on it: 60 in double
    // precision.
    EXPECT_GE(rain.asleep_count(), 925);
    EXPECT_TRUE(rain.soil->refused().empty());
    EXPECT_EQ(rain.soil->soil().status_bits(), 0u);
    EXPECT_EQ(rain.scene.world->getNumConstraints(), 0);
}

int64_t columns_of(const WorkCounts& work) {
    int64_t sum = 0;
    for (const PassWork& pass : work.passes) sum += pass.column_count;
    return sum;
}

/// Bounds are a tenth above what was counted when they were written down, for both precisions of
/// Bullet. Columns: 250 of them are tetrahedra, which by their shape stand on edges for a while.
TEST(ManyBodies, a_thousand_are_looked_at_where_they_are) {
    Rain rain;
    rain.scene.run(0.5);
    const WorkCounts before = rain.soil->soil().work_counts();
    rain.scene.run(0.5);
    const WorkCounts after = rain.soil->soil().work_counts();
    EXPECT_GT(columns_of(after) - columns_of(before), 0);
    EXPECT_LE(columns_of(after) - columns_of(before), 4000000);
    EXPECT_LE(after.dispatch_count - before.dispatch_count, 990);
    EXPECT_LE(after.read_count - before.read_count, 74);
    EXPECT_LE(after.read_bytes - before.read_bytes, 41700000);
    EXPECT_LE(after.write_bytes - before.write_bytes, 8780000);
}

/// A hull of 3 m on two tracks, 20 t.
btRigidBody& add_machine(BulletScene& scene) {
    auto& shape = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
    btTransform at = btTransform::getIdentity();
    at.setOrigin(btVector3(0, 0.5f, 0));
    shape.addChildShape(at, &scene.shape<btBoxShape>(btVector3(1.5f, 0.3f, 0.9f)));
    for (const btScalar z : {btScalar(-0.9), btScalar(0.9)}) {
        at.setOrigin(btVector3(0, 0, z));
        shape.addChildShape(at, &scene.shape<btBoxShape>(btVector3(1.8f, 0.2f, 0.3f)));
    }
    return scene.add(20000, shape, btVector3(0, btScalar(kBedTopM + 0.21), 0));
}

SoilDef machine_bed() {
    SoilDef def = small_bed();
    def.size_m = {8, 2, 8};
    return def;
}

TEST(Parked, a_machine_of_20_t_that_sleeps_asks_the_soil_for_nothing) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, machine_bed());
    const btRigidBody& machine = add_machine(scene);
    scene.run(6);
    ASSERT_FALSE(machine.isActive());
    const WorkCounts before = soil->soil().work_counts();
    scene.run(1);
    const WorkCounts after = soil->soil().work_counts();
    EXPECT_EQ(columns_of(after), columns_of(before));
    EXPECT_EQ(after.dispatch_count, before.dispatch_count);
    EXPECT_EQ(after.read_count, before.read_count);
    EXPECT_EQ(after.write_bytes, before.write_bytes);
}

/// Bounds are a tenth above what was counted when they were written down, for both precisions of
/// Bullet. In a step its contacts are collected, and that is all.
TEST(Parked, a_machine_of_20_t_that_stays_awake_is_looked_at_where_it_touches) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, machine_bed());
    btRigidBody& machine = add_machine(scene);
    machine.setActivationState(DISABLE_DEACTIVATION);
    scene.run(6);
    const WorkCounts before = soil->soil().work_counts();
    scene.run(1);
    const WorkCounts after = soil->soil().work_counts();
    EXPECT_GT(columns_of(after) - columns_of(before), 0);
    for (size_t i = 0; i < after.passes.size(); ++i) {
        const int64_t columns = after.passes[i].column_count - before.passes[i].column_count;
        EXPECT_LE(columns, after.passes[i].name == "collect_contacts" ? 479000 : 0)
            << after.passes[i].name;
    }
    EXPECT_LE(after.dispatch_count - before.dispatch_count, 60);
    EXPECT_LE(after.read_bytes - before.read_bytes, 34200000);
    EXPECT_LE(after.write_bytes - before.write_bytes, 77100);
}

TEST(ManyBodies, a_thousand_fall_the_same_twice) {
    uint64_t states[2];
    for (uint64_t& state : states) {
        Rain rain;
        rain.scene.run(0.25);
        state = rain.state();
    }
    EXPECT_EQ(states[0], states[1]);
}

}  // namespace
}  // namespace bsoil::bullet::many_bodies_test
