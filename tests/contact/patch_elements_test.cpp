#include "bsoil/contact/patch_elements.h"

#include <gtest/gtest.h>

#include <vector>

namespace bsoil::patch_elements_test {
namespace {

constexpr Vec3 kUp{0, 0, 1};

/// Of one patch of a single element, 10 mm deep. Its soil follows what lifts by 1 mm.
double share_after(const PatchElement& element, Vec3 shift_m) {
    double share = 0;
    limit_shares({&element, 1}, shift_m, kUp, {}, {&share, 1});
    return share;
}

PatchElement sole(double retreat_m) { return {0, {0, 0, -1}, 100, 0.01, retreat_m}; }

TEST(PatchElements, limit_follows_depth_and_what_has_drawn_back) {
    EXPECT_EQ(share_after(sole(0), {}), 1);
    EXPECT_NEAR(share_after(sole(0), {0, 0, -0.005}), 1.5, 1e-9);
    // 10 times as stiffly: 9.5 mm are left of the depth, of which 0.5 are 0.0526.
    EXPECT_NEAR(share_after(sole(0), {0, 0, 0.0005}), 0.95 * (1 - 0.5 / 0.95), 1e-9);
    EXPECT_LE(share_after(sole(0), {0, 0, 0.002}), kDrawnBackShare);
}

TEST(PatchElements, what_has_drawn_back_bears_again_when_it_comes_back) {
    // Of 100 N the element has half, 105 N once it is as deep as it was and half a millimetre more.
    EXPECT_NEAR(share_after(sole(0.0005), {0, 0, -0.0005}), 1.05 / 0.5, 1e-9);
    EXPECT_GT(share_after(sole(0.005), {0, 0, -0.006}), 1e5) << "all of it had drawn back";
    EXPECT_NEAR(share_after(sole(0.005), {0, 0, -0.003}), 1.3, 1e-9) << "not there yet";
}

TEST(PatchElements, wheel_that_rolls_on_level_bears_what_it_did) {
    for (const double forward : {-0.4, 0.0, 0.4}) {
        const PatchElement element{0, {forward, 0, -0.9}, 100, 0.01, forward < 0 ? 5e-4 : 0};
        EXPECT_EQ(share_after(element, {0.1, 0, 0}), 1) << forward;
    }
    // It rises, and its front goes into the soil all the same.
    EXPECT_NEAR(share_after({0, {0.4, 0, -0.9}, 100, 0.01, 0}, {0.1, 0, 0.001}), 0.9, 1e-9);
}

TEST(PatchElements, limits_of_a_patch_add_up) {
    const std::vector<PatchElement> elements{
        {0, {0, 0, -1}, 100, 0.01, 0}, {0, {0, 0, -1}, 300, 0.03, 0}, {2, {0, 0, -1}, 1, 0.01, 0}};
    std::vector<double> shares(3);
    limit_shares(elements, {0, 0, -0.01}, kUp, {}, shares);
    EXPECT_NEAR(shares[0], (200 + 400) / 400.0, 1e-9);
    EXPECT_EQ(shares[1], 1) << "no elements";
    EXPECT_NEAR(shares[2], 2, 1e-9);
}

}  // namespace
}  // namespace bsoil::patch_elements_test
