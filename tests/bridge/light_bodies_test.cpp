// Bodies from a pebble to a machine at rest on sand, in grids from fine to coarse.
#include <cmath>
#include <numbers>
#include <optional>

#include "bsoil/host/soil_below.h"
#include "flat_soil.h"
#include "sand_bed.h"

namespace bsoil::bullet::light_bodies_test {
namespace {

constexpr double kDensity_kg_m3 = 1500;

enum class Form { ball, box };
struct Resting {
    Form form = Form::ball;
    double mass_kg = 1, voxel_m = 0.05;
};
void PrintTo(const Resting& r, std::ostream* out) {
    *out << (r.form == Form::ball ? "ball" : "box") << " of " << r.mass_kg << " kg, voxels of "
         << 1e3 * r.voxel_m << " mm";
}

/// A body let go where it just touches the soil, somewhere within a voxel.
class RestingBody : public testing::TestWithParam<Resting> {
  protected:
    void SetUp() override {
        const auto [form, mass_kg, voxel_m] = GetParam();
        half_m = form == Form::ball ? std::cbrt(0.75 / std::numbers::pi * mass_kg / kDensity_kg_m3)
                                    : 0.5 * std::cbrt(mass_kg / kDensity_kg_m3);
        SoilDef def = small_bed();
        def.voxel_m = voxel_m;
        const double side_m = std::max(6 * half_m, 16 * voxel_m);
        def.size_m = {side_m, kBedTopM + 8 * voxel_m, side_m};
        soil = sand_bed(*scene.world, def);
        btCollisionShape& shape =
            form == Form::ball ? scene.shape<btSphereShape>(btScalar(half_m))
                               : scene.shape<btBoxShape>(btScalar(half_m) * btVector3(1, 1, 1));
        body = &scene.add(btScalar(mass_kg), shape,
                          btVector3(btScalar(0.3 * voxel_m), btScalar(kBedTopM + half_m),
                                    btScalar(0.2 * voxel_m)));
    }
    /// Below the level that the bed had: what there is beside the body but for its own rim.
    double depth_m() const {
        double lowest = HUGE_VAL;
        for (int corner = 0; corner < 8; ++corner) {
            const btVector3 at =
                btScalar(half_m) *
                btVector3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
            lowest = std::min(lowest, static_cast<double>((body->getWorldTransform() * at).y()));
        }
        return kBedTopM - (GetParam().form == Form::ball ? height_of(*body) - half_m : lowest);
    }

    BulletScene scene;
    std::unique_ptr<SoilAction> soil;
    btRigidBody* body = nullptr;
    double half_m = 0;
};

TEST_P(RestingBody, sinkage_is_what_its_pose_shows) {
    scene.run(3);
    EXPECT_FALSE(body->isActive());
    const BodyReport report = soil->body_report(*body);
    EXPECT_NEAR(report.sinkage_m, depth_m(), 0.1 * GetParam().voxel_m);
    // In Bullet's float solver; at rest a body is held by what it weighs.
    EXPECT_NEAR(report.force_n.y / (GetParam().mass_kg * kGravity_m_s2), 1, 0.02);
}

/// From pebbles to machines; or those alone whose beds have so many voxels that they take seconds.
std::vector<Resting> from_fine_to_coarse(bool is_slow) {
    std::vector<Resting> all;
    for (const double voxel_m : {0.01, 0.02, 0.05}) {
        for (const double mass_kg : {1, 10, 100, 1000}) {
            if ((voxel_m == 0.01 && mass_kg >= 100) != is_slow) continue;
            for (const Form form : {Form::ball, Form::box}) all.push_back({form, mass_kg, voxel_m});
        }
    }
    return all;
}

INSTANTIATE_TEST_SUITE_P(FromFineToCoarse, RestingBody,
                         testing::ValuesIn(from_fine_to_coarse(false)));
INSTANTIATE_TEST_SUITE_P(SlowFromFineToCoarse, RestingBody,
                         testing::ValuesIn(from_fine_to_coarse(true)));

struct Drop {
    double voxel_m = 0.05, radius_m = 0.3, mass_kg = 200, height_m = 0.7;
    bool carries_soil = false;  ///< sand on its top, of which some 50 g are left when it lands
    bool is_sensed = false;     ///< a sensor around where it lands
    bool broke_off = false;     ///< a joint that broke hangs on it
    bool is_aside = false;      ///< of the centre of mass of a body that its host keeps upright
};

/// An object that feels others come into its box and pushes none of them.
struct Sensor {
    BulletScene& scene;
    btBoxShape box{btVector3(2, 1, 2)};
    btCollisionObject object;

    explicit Sensor(BulletScene& in) : scene(in) {
        object.setCollisionShape(&box);
        object.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT |
                                 btCollisionObject::CF_NO_CONTACT_RESPONSE);
        // Of the soil's ground() it asks nothing.
        scene.world->addCollisionObject(&object, btBroadphaseProxy::SensorTrigger,
                                        btBroadphaseProxy::DefaultFilter);
    }
    ~Sensor() { scene.world->removeCollisionObject(&object); }
};

/// What held a body, as Bullet leaves it when it breaks.
struct BrokenJoint {
    BulletScene& scene;
    btPoint2PointConstraint joint;

    BrokenJoint(BulletScene& in, btRigidBody& body) : scene(in), joint(body, btVector3(0, 0, 0)) {
        joint.setEnabled(false);
        scene.world->addConstraint(&joint);
    }
    ~BrokenJoint() { scene.world->removeConstraint(&joint); }
};

/// Deepest point of a ball's fall, with substeps of this length or, for 0, of 1 to 33 ms.
double impact_depth_m(const Drop& drop, double substep_s) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.voxel_m = drop.voxel_m;
    def.size_m = {5 * drop.radius_m, drop.carries_soil ? 2.0 : 1.0, 5 * drop.radius_m};
    const auto soil = sand_bed(*scene.world, def);
    btCollisionShape* shape = &scene.shape<btSphereShape>(btScalar(drop.radius_m));
    btVector3 at(btScalar(0.015), btScalar(kBedTopM + drop.radius_m + drop.height_m), 0);
    if (drop.is_aside) {
        btTransform local = btTransform::getIdentity();
        local.setOrigin(btVector3(btScalar(0.25), 0, 0));
        auto& compound = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
        compound.addChildShape(local, shape);
        shape = &compound;
        at -= local.getOrigin();
    }
    btRigidBody& ball = scene.add(btScalar(drop.mass_kg), *shape, at);
    if (drop.is_aside) ball.setAngularFactor(0);
    if (drop.carries_soil) {
        const double top_m = kBedTopM + 2 * drop.radius_m + drop.height_m;
        EXPECT_TRUE(soil->fill(BoxFill{{{-0.1, top_m - 0.05, -0.1}, {0.1, top_m, 0.1}}, {}}));
    }
    std::optional<Sensor> sensor;
    if (drop.is_sensed) sensor.emplace(scene);
    std::optional<BrokenJoint> joint;
    if (drop.broke_off) joint.emplace(scene, ball);
    uint32_t random = 7;
    double deepest_m = 0;
    for (double time_s = 0; time_s < 0.8;) {
        random = random * 1664525u + 1013904223u;
        const double step_s = substep_s > 0 ? substep_s : (1 + 31 * (random / 4294967296.0)) / 960;
        scene.world->stepSimulation(btScalar(step_s), 0);
        time_s += step_s;
        deepest_m = std::max(deepest_m, kBedTopM + drop.radius_m - height_of(ball));
    }
    return deepest_m;
}

// By hand: m g (h + D) = 1520 J is the work of the bearing force, which grows with D^2. At 75 mm
// the cap is a sole of 0.35 m square (0.89 of its diameter), in the mean 38 mm deep. Dry sand of a
// relative density of 0.6 has 41.4 deg there (Bolton at 39 kPa, 3 deg a unit), Nq 78, Ngamma 105,
// sgamma 1.39: 490 kPa on 0.124 m2 are 60 kN, and D = 75 mm. The soil's momentum takes a sixteenth
// of the work: 73 mm. Uehara and others (2003) have measured 0.14 / tan phi sqrt(density ratio)
// diameter^(2/3) (h + D)^(1/3) [cm] in loose grains: 148 mm.
constexpr double kByHandM = 0.073;

TEST(Impact, depth_does_not_hang_on_bullets_substep) {
    for (const double substep_s : {1.0 / 60, 1.0 / 240, 1.0 / 960, 0.0}) {
        EXPECT_NEAR(impact_depth_m({}, substep_s), kByHandM, 0.1 * kByHandM) << substep_s;
    }
}

// A body that carried any soil waited for the soil's step: a crumb, and it fell through the bed.
TEST(Impact, depth_does_not_hang_on_soil_that_the_body_carries) {
    for (const double substep_s : {1.0 / 30, 1.0 / 60}) {
        EXPECT_NEAR(impact_depth_m({.carries_soil = true}, substep_s), kByHandM, 0.1 * kByHandM)
            << substep_s;
    }
}

// The sensor counted as a body that lies on it.
TEST(Impact, depth_does_not_hang_on_a_sensor) {
    EXPECT_EQ(impact_depth_m({.is_sensed = true}, 1.0 / 60), impact_depth_m({}, 1.0 / 60));
}

// It waited for the soil's step, as what hangs on joints does, and fell deeper.
TEST(Impact, depth_does_not_hang_on_a_joint_that_broke) {
    for (const double substep_s : {1.0 / 30, 1.0 / 60}) {
        EXPECT_NEAR(impact_depth_m({.broke_off = true}, substep_s), kByHandM, 0.1 * kByHandM)
            << substep_s;
    }
}

// As if it could turn, a part of its mass was behind the point that meets the soil, and it went in
// deeper.
TEST(Impact, depth_does_not_hang_on_where_the_mass_of_an_upright_body_is) {
    EXPECT_NEAR(impact_depth_m({.is_aside = true}, 1.0 / 60), impact_depth_m({}, 1.0 / 60),
                0.1 * kByHandM);
}

TEST(Impact, depth_does_not_hang_on_the_voxel) {
    const double coarse_m = impact_depth_m({.voxel_m = 0.1}, 1.0 / 120);
    EXPECT_NEAR(impact_depth_m({.voxel_m = 0.03}, 1.0 / 120), coarse_m, 0.1 * coarse_m);
}

/// How deep a box of 100 kg and 0.4 m lies that fell flat on sand, by `above_m` higher than
/// kBedTopM.
double fallen_box_depth_m(double height_m, double above_m) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.voxel_m = 0.05;
    def.size_m = {1.6, 2, 1.6};
    const auto soil = sand_bed(*scene.world, def);
    const double top_m = kBedTopM + above_m;
    EXPECT_TRUE(above_m == 0 || soil->fill(BoxFill{{{-1, kBedTopM, -1}, {1, top_m, 1}}, {}}));
    btRigidBody& box = scene.add(100, scene.shape<btBoxShape>(btVector3(0.2f, 0.2f, 0.2f)),
                                 btVector3(0, btScalar(top_m + 0.2 + height_m), 0));
    scene.run(1);
    return top_m + 0.2 - height_of(box);
}

// Where the top is that of a voxel, the faces of the voxels below are above it until the box
// reaches them. The flow of momentum into those stopped it in the air. By hand m g (h + D) is the
// work of the force of a plate of its size: 14 mm from 0.2 m.
TEST(Impact, depth_does_not_hang_on_where_in_a_voxel_the_top_lies) {
    for (const double height_m : {0.05, 0.1, 0.15, 0.2, 0.4}) {
        const double within_m = fallen_box_depth_m(height_m, 0.02);
        EXPECT_NEAR(fallen_box_depth_m(height_m, 0), within_m, 0.03 * within_m) << height_m;
    }
    EXPECT_NEAR(fallen_box_depth_m(0.2, 0), 0.014, 0.0014);
}

TEST(Impact, depth_does_not_hang_on_where_the_substep_ends) {
    // At 60 Hz the ball falls by 62 mm a step.
    for (int i = 0; i < 4; ++i) {
        const double depth_m = impact_depth_m({.height_m = 0.7 + 0.015 * i}, 1.0 / 60);
        EXPECT_NEAR(depth_m, kByHandM, 0.1 * kByHandM) << i;
    }
}

// Limits are found in the soil's steps, and grow meanwhile as the body sinks: else it would fall on
// freely until the next one.
TEST(LightBodies, under_a_heavy_load_sink_in_proportion_within_a_step_of_the_soil) {
    constexpr int kSubsteps = 32;
    for (const double step_s : {1.0 / 60, 1.0 / 240}) {
        BulletScene scene;
        const auto h = btScalar(0.1);
        btRigidBody& body = scene.add_box(1, btVector3(h, h, h), btVector3(0, h, 0));
        body.setActivationState(DISABLE_DEACTIVATION);
        FlatSoil soil(*scene.world, MaterialDef{}, step_s);
        const auto depth_under_m = [&](double weights) {
            body.setGravity(btVector3(0, btScalar(-weights * kGravity_m_s2), 0));
            scene.run(1, kSubsteps);
            return static_cast<double>(h - body.getWorldTransform().getOrigin().y());
        };
        // It sinks to where the work of its weight is that of a limit in proportion to depth. By
        // hand two depths one after the other add up to twice what the weight needs: z0 + z1 = 2 d
        // under ten weights, z1 + z2 = 6 d under thirty.
        const double before_m = depth_under_m(0.1), light_m = depth_under_m(10);
        const double wanted_m = 2 * light_m + 3 * before_m;
        // What the solver takes out of its fall makes it stop earlier, at half of that at the
        // least.
        const double depth_m = depth_under_m(30);
        EXPECT_LT(depth_m, 1.1 * wanted_m) << step_s;
        EXPECT_GT(depth_m, 0.5 * wanted_m) << step_s;
    }
}

/// A bank of loam that stands upright, 1 m high, before a floor of it.
std::unique_ptr<SoilAction> upright_bank(BulletScene& scene) {
    SoilDef def = small_bed();
    def.voxel_m = 0.1;
    def.size_m = {3.2, 2.4, 1.6};
    def.material = materials::loam();
    auto soil = SoilAction::create(*scene.world, def);
    EXPECT_TRUE(soil) << soil.error();
    if (!soil) return nullptr;
    EXPECT_TRUE((*soil)->fill(BoxFill{{{-9, -9, -9}, {9, 0.2, 9}}, "loam"}));
    EXPECT_TRUE((*soil)->fill(BoxFill{{{-9, -9, -9}, {0, 1.2, 9}}, "loam"}));
    return std::move(*soil);
}

// The surface falls by 1 m within a voxel beside the bank. As a plane under a body that lies across
// the edge it would rise to 4 m at the body's other end, and hold it there.
TEST(LightBodies, lie_on_a_bank_and_not_on_the_plane_of_its_face) {
    BulletScene scene;
    const auto soil = upright_bank(scene);
    ASSERT_TRUE(soil);
    const btScalar radius = 0.1f;
    auto& shape = scene.shape<btCapsuleShapeX>(radius, btScalar(0.6));
    btRigidBody& body = scene.add(btScalar(0.001), shape, btVector3(-0.04f, 1.9f, 0));
    scene.run(0.9);
    EXPECT_LT(height_of(body), 1.2 + 2 * 0.1);
}

// On level ground the plane is that of the surface. Beside a bank its rim is no higher than the
// ground under the body and half a voxel.
TEST(LightBodies, have_a_plane_below_them_no_higher_than_the_ground) {
    BulletScene scene;
    const auto soil = upright_bank(scene);
    ASSERT_TRUE(soil);
    const GroundSurface surface(soil->soil());
    const SoilBelow below(soil->soil(), surface, {0, 1, 0});
    const auto rim_m = [&](Vec3 middle, Vec3 half, Vec3 at) {
        const auto found = below.under({middle - half, middle + half});
        EXPECT_TRUE(found);
        if (!found) return 0.0;
        const Vec3 n = found->plane.normal;
        return found->plane.position_m.y -
               (n.x * (at.x - middle.x) + n.z * (at.z - middle.z)) / n.y;
    };
    const Vec3 half{0.4, 0.1, 0.1};
    EXPECT_NEAR(rim_m({-0.8, 1.5, 0}, half, {-1.2, 0, 0}), 1.2, 1e-6);
    for (const double x : {-0.048, -0.045, -0.04}) {
        const double uphill_m = rim_m({x, 1.5, 0}, half, {x - 0.4, 0, 0});
        EXPECT_LE(uphill_m, 1.2 + 0.05 + 1e-6) << x;
        EXPECT_GE(uphill_m, 1.2 - 1e-6) << x;
    }
    const auto level = below.at({-0.8, 1.5, 0}),
               under = below.under({{-1, 1.4, -0.1}, {-0.6, 1.6, 0.1}});
    ASSERT_TRUE(level && under);
    EXPECT_EQ(level->plane.normal, under->plane.normal);
}

}  // namespace
}  // namespace bsoil::bullet::light_bodies_test
