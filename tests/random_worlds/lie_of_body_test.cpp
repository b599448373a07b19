// Where a body's surface is, by which the checks of random worlds judge how deep it may lie.
#include "lie_of_body.h"

#include <btBulletCollisionCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

namespace bsoil::random_worlds::lie_of_body_test {
namespace {

// Bullet's box about a compound or a hull turns with it, and reaches lower than any of its points.
TEST(LieOfBody, knows_the_lowest_point_of_a_turned_shape) {
    btSphereShape ball(btScalar(0.5));
    btCompoundShape turned;
    turned.addChildShape(btTransform::getIdentity(), &ball);
    const btTransform pose(btQuaternion(btVector3(1, 1, 0).normalized(), btScalar(0.7)),
                           btVector3(3, 2, 1));
    btVector3 low, high;
    turned.getAabb(pose, low, high);
    EXPECT_LT(low.y(), btScalar(1.4));
    EXPECT_NEAR(lowest_point(turned, pose, {0, 1, 0}).y, 1.5, 1e-5);
}

double mean(const std::vector<double>& of) {
    return std::reduce(of.begin(), of.end()) / static_cast<double>(of.size());
}

// A cone on its tip looks down with all of its side: two thirds of its height up in the mean. On
// its base it does so with that.
TEST(LieOfBody, knows_what_of_a_cone_looks_down) {
    constexpr double kRadius_m = 0.3, kHeight_m = 0.6;
    btConeShape cone{static_cast<btScalar>(kRadius_m), static_cast<btScalar>(kHeight_m)};
    cone.setMargin(0);
    btCollisionObject object;
    object.setCollisionShape(&cone);
    const auto side = [&](double turned_rad) {
        object.setWorldTransform(
            btTransform(btQuaternion({1, 0, 0}, btScalar(turned_rad)), btVector3(3, 2, 1)));
        return underside_of(object, {0, 1, 0}, 0.5);
    };
    const double area_m2 = std::numbers::pi * kRadius_m * kRadius_m;
    for (const auto& [turned_rad, height_m] :
         {std::pair{std::numbers::pi, 2 * kHeight_m / 3}, std::pair{0.0, 0.0}}) {
        const Underside found = side(turned_rad);
        const auto count = static_cast<double>(found.heights_m.size());
        EXPECT_NEAR(count * found.each_m2, area_m2, 0.1 * area_m2);
        EXPECT_NEAR(mean(found.heights_m), height_m, 0.05 * kHeight_m);
    }
}

// A rod of 1 m goes over from one end to the other, and its middle comes down meanwhile.
TEST(LieOfBody, knows_how_far_a_turn_has_taken_the_other_end_down) {
    btBoxShape rod{btVector3(btScalar(0.5), btScalar(0.01), btScalar(0.01))};
    btCollisionObject object;
    object.setCollisionShape(&rod);
    Turns turns;
    const auto lean = [&](double turned_rad, double middle_m, bool is_borne) {
        object.setWorldTransform(btTransform(btQuaternion({0, 0, 1}, btScalar(turned_rad)),
                                             btVector3(3, btScalar(middle_m), 1)));
        turns.note(object, {0, 1, 0}, is_borne);
    };
    lean(-0.6, 5, false);
    lean(0.8, 3, false);
    EXPECT_EQ(turns.most_m(&object), 0) << "in the air";
    lean(0.3, 2.9, true);
    lean(-0.2, 2.8, true);
    const double down_m = 0.5 * (std::sin(0.3) + std::sin(0.2));
    EXPECT_NEAR(turns.most_m(&object), down_m, 0.01);
    turns.forget(&object);
    lean(1.5, 2.8, true);
    EXPECT_NEAR(turns.most_m(&object), down_m, 0.01) << "somebody else has turned it";
}

}  // namespace
}  // namespace bsoil::random_worlds::lie_of_body_test
