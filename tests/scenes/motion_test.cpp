/// Key frames and what lies between them.
#include "world/motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bsoil::scene::motion_test {
namespace {

TEST(Motion, smooth_curve_meets_its_keys_and_never_leaves_their_range) {
    const std::vector<double> t{0, 1, 1.5, 4, 5}, v{0, 2, 2, -3, -2.5};
    const Curve curve(t, v, Curve::Interpolation::smooth);
    for (size_t i = 0; i < t.size(); ++i) EXPECT_DOUBLE_EQ(curve.value(t[i]), v[i]);
    for (size_t i = 0; i + 1 < t.size(); ++i) {
        for (double u = 0; u < 1; u += 0.01) {
            const double value = curve.value(t[i] + u * (t[i + 1] - t[i]));
            EXPECT_GE(value, std::min(v[i], v[i + 1]) - 1e-12);
            EXPECT_LE(value, std::max(v[i], v[i + 1]) + 1e-12);
        }
    }
}

TEST(Motion, smooth_curve_has_no_jump_in_speed) {
    const Curve curve({0, 1, 3}, {0, 1, 5}, Curve::Interpolation::smooth);
    constexpr double h = 1e-4;
    const double before = (curve.value(1) - curve.value(1 - h)) / h;
    const double after = (curve.value(1 + h) - curve.value(1)) / h;
    EXPECT_NEAR(before, after, 1e-2);  // differences of first order: curvature times h
    EXPECT_NEAR(curve.value(h) / h, 0, 1e-2);
}

TEST(Motion, curve_stands_still_outside_its_keys) {
    const Curve curve({1, 2}, {3, 4}, Curve::Interpolation::linear);
    EXPECT_EQ(curve.value(0), 3);
    EXPECT_EQ(curve.value(1.5), 3.5);
    EXPECT_EQ(curve.value(9), 4);
    EXPECT_EQ(Curve({1, 2}, {3, 4}, Curve::Interpolation::step).value(1.99), 3);
}

MotionItem joint_motion() {
    MotionItem item;
    item.joint = "j";
    item.interpolation = "linear";
    for (const auto& [t_s, position_rad] : {std::pair{0.0, 0.0}, {1.0, 1.0}, {2.0, 0.0}}) {
        MotionKey key;
        key.t_s = t_s;
        key.position_rad = position_rad;
        item.motion_keys.push_back(key);
    }
    return item;
}

TEST(Motion, rounds_repeat_and_then_the_last_one_stays) {
    MotionItem item = joint_motion();
    item.motion_keys.pop_back();
    item.period_s = 2;
    item.repeat_count = 3;
    const Motion motion(item);
    EXPECT_DOUBLE_EQ(motion.value(0.5), 0.5);
    EXPECT_DOUBLE_EQ(motion.value(2.5), 0.5);
    EXPECT_DOUBLE_EQ(motion.value(4.5), 0.5);
    EXPECT_DOUBLE_EQ(motion.value(100), 1.0);
}

TEST(Motion, body_turns_the_shorter_way_at_constant_speed) {
    MotionItem item;
    item.body = "b";
    item.interpolation = "linear";
    for (const double angle : {0.0, 1.0}) {
        MotionKey key;
        key.t_s = 2 * angle;
        key.position_m = Vec3{angle, 2 * angle, 0};
        key.rotation =
            Quat{0, 0, -std::sin(angle / 2), -std::cos(angle / 2)};  // minus the same turn
        item.motion_keys.push_back(key);
    }
    const Pose half = Motion(item).pose(1);
    EXPECT_DOUBLE_EQ(half.position.y, 1);
    EXPECT_NEAR(2 * std::atan2(half.rotation.z, half.rotation.w), 0.5 - 2 * 3.14159265358979, 1e-9);
}

}  // namespace
}  // namespace bsoil::scene::motion_test
