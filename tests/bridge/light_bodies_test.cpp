// Bodies from a pebble to a machine at rest on sand, in grids from fine to coarse.
#include <cmath>
#include <numbers>

#include "sand_bed.h"

namespace bsoil::bullet {
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

std::vector<Resting> from_pebble_to_machine() {
    std::vector<Resting> all;
    for (const double voxel_m : {0.01, 0.02, 0.05})
        for (const double mass_kg : {1, 10, 100, 1000})
            for (const Form form : {Form::ball, Form::box}) all.push_back({form, mass_kg, voxel_m});
    return all;
}

INSTANTIATE_TEST_SUITE_P(FromFineToCoarse, RestingBody,
                         testing::ValuesIn(from_pebble_to_machine()));

}  // namespace
}  // namespace bsoil::bullet
