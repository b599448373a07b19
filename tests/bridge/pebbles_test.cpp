// Pebbles: many bodies that are smaller than a voxel, several in one.
#include <algorithm>
#include <numeric>
#include <random>

#include "sand_bed.h"

namespace bsoil::bullet::pebbles_test {
namespace {

constexpr double kDensity_kg_m3 = 2000;

enum class Form { cube, ball, tetrahedron, rod };
struct Pebbles {
    Form form = Form::cube;
    double size_m = 0.01;
};
void PrintTo(const Pebbles& p, std::ostream* out) {
    const char* names[] = {"cubes", "balls", "tetrahedra", "rods"};
    *out << names[static_cast<int>(p.form)] << " of " << 1e3 * p.size_m << " mm";
}

/// Fifty that fall from 0.15 to 0.45 m on 0.4 x 0.4 m of sand in voxels of 5 cm.
class FiftyPebbles : public testing::TestWithParam<Pebbles> {
  protected:
    static constexpr int kCount = 50;
    void SetUp() override {
        soil = sand_bed(*scene.world);
        const auto [form, size_m] = GetParam();
        const auto half = static_cast<btScalar>(size_m / 2);
        btCollisionShape* shape = nullptr;
        double volume_m3 = std::pow(size_m, 3);
        switch (form) {
            case Form::cube:
                shape = &scene.shape<btBoxShape>(btVector3(half, half, half));
                break;
            case Form::ball:
                shape = &scene.shape<btSphereShape>(half);
                volume_m3 *= 0.52;
                break;
            case Form::tetrahedron: {
                auto& hull = static_cast<btConvexHullShape&>(scene.shape<btConvexHullShape>());
                for (const btVector3& corner : {btVector3(1, 1, 1), btVector3(1, -1, -1),
                                                btVector3(-1, 1, -1), btVector3(-1, -1, 1)}) {
                    hull.addPoint(half * corner);
                }
                shape = &hull;
                volume_m3 /= 3;
                break;
            }
            case Form::rod:
                shape = &scene.shape<btBoxShape>(btVector3(half, half / 4, half / 4));
                volume_m3 /= 16;
                break;
        }
        shape->setMargin(half / 20);
        std::mt19937 random(7);
        std::uniform_real_distribution<double> part(-1, 1);
        for (int i = 0; i < kCount; ++i) {
            const double x = 0.2 * part(random), y = kBedTopM + 0.3 + 0.15 * part(random),
                         z = 0.2 * part(random);
            scene.add(static_cast<btScalar>(kDensity_kg_m3 * volume_m3), *shape,
                      btVector3(static_cast<btScalar>(x), static_cast<btScalar>(y),
                                static_cast<btScalar>(z)));
        }
    }
    BulletScene scene;
    std::unique_ptr<SoilAction> soil;
};

// They come down at 3 m/s at most. By hand, for a tetrahedron of 20 mm that falls on its tip: its
// 23 mJ go into a force that grows with the cube of the depth, k z^3 / 2 with k from 0.1 to 1 MPa/m
// for faces so steep. So the tip goes 2 to 4 cm deep, its middle no deeper than its size. What is
// hit by another one goes deeper than by its own fall; half of them lie with their middles at the
// surface.
TEST_P(FiftyPebbles, lie_on_the_sand_that_carries_their_weight_and_sleep) {
    const double size_m = GetParam().size_m;
    // On rigid ground balls roll for ever; on sand they go on from sample to sample at 1 mm/s, and
    // all sleep together once the last one stands, after 30 to 40 s. Rods that rock creep at 0.5
    // mm/s, and sand holds them once it has sheared by its K of 2 mm: after 13 to 17 s.
    const Form form = GetParam().form;
    const int frames_most = 60 * (form == Form::ball ? 45 : form == Form::rod ? 20 : 8);
    double weight_n = 0;
    for (const auto& body : scene.bodies) {
        weight_n += kGravity_m_s2 / static_cast<double>(body->getInvMass());
    }
    // Rods rock until they sleep, so that each is carried by turns: of the last half second.
    std::vector<double> forces_n;
    int awake_count = kCount;
    for (int i = 0; i < frames_most && awake_count > 0; ++i) {
        scene.run(1.0 / 60);
        awake_count = 0;
        forces_n.push_back(0);
        for (const auto& body : scene.bodies) {
            awake_count += body->isActive();
            forces_n.back() += soil->body_report(*body).force_n.y;
        }
    }
    constexpr int kMean = 30;
    ASSERT_GT(forces_n.size(), kMean);
    const double force_n = std::accumulate(forces_n.end() - kMean, forces_n.end(), 0.0) / kMean;
    std::vector<double> depths_m;
    for (const auto& body : scene.bodies) depths_m.push_back(kBedTopM - height_of(*body));
    std::sort(depths_m.begin(), depths_m.end());
    EXPECT_LT(depths_m[kCount / 2], size_m / 8);
    EXPECT_LT(depths_m.back(), size_m);
    EXPECT_EQ(awake_count, 0);
    EXPECT_NEAR(force_n, weight_n, 0.02 * weight_n);
    EXPECT_EQ(soil->soil().status_bits(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Pebbles, FiftyPebbles,
                         testing::Values(Pebbles{Form::cube, 0.01}, Pebbles{Form::cube, 0.02},
                                         Pebbles{Form::ball, 0.02},
                                         Pebbles{Form::tetrahedron, 0.02},
                                         Pebbles{Form::rod, 0.04}));

}  // namespace
}  // namespace bsoil::bullet::pebbles_test
