#include "bsoil/contact/contact_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace bsoil::contact_memory_test {
namespace {

constexpr double kVoxel = 0.1;
constexpr double kStep = 0.1;

/// Sand with z up.
const ContactLaw& law() {
    static const auto made = [] {
        auto soil = std::make_shared<ContactSoil>();
        soil->voxel_m = kVoxel;
        MaterialDef sand;
        sand.friction_angle_rad = std::numbers::pi / 6;
        soil->materials = {sand};
        return ContactLaw::make(std::move(soil));
    }();
    return *made;
}

/// A contact in the voxel (x, z) of a grid with z up, pressed in by 1 cm.
ContactVoxel contact(int x, int z, Vec3 normal = {0, 0, -1}) {
    ContactVoxel v;
    v.center_m = {(x + 0.5) * kVoxel, 0, (z + 0.5) * kVoxel};
    v.position_m = v.center_m;
    v.normal = normal;
    v.area_m2 = kVoxel * kVoxel;
    v.depth_m = v.bearing_depth_m = 0.01;
    return v;
}

BodyMotion moving(Vec3 velocity_m_s) {
    BodyMotion motion;
    motion.linear_velocity_m_s = velocity_m_s;
    return motion;
}

std::vector<double> advanced(ContactMemory& memory, std::vector<ContactVoxel> voxels,
                             Vec3 velocity_m_s) {
    std::vector<double> sheared_m;
    for (const ContactHistory& h : memory.advance(voxels, moving(velocity_m_s), law(), kStep)) {
        sheared_m.push_back(h.sheared_m);
    }
    return sheared_m;
}

TEST(ContactMemory, adds_up_the_sliding_and_not_the_approach) {
    ContactMemory memory;
    double expected_m = 0;
    for (int step = 0; step < 5; ++step) {
        expected_m += 0.03 * kStep;
        EXPECT_NEAR(advanced(memory, {contact(0, 0)}, {0.03, 0, -0.5})[0], expected_m, 1e-12);
    }
    EXPECT_NEAR(advanced(memory, {contact(0, 0)}, {-0.03, 0, 0})[0], expected_m - 0.003, 1e-12)
        << "sliding back";
}

TEST(ContactMemory, soil_that_a_rolling_wheel_comes_to_has_not_sheared) {
    ContactMemory memory;
    // The contact of a wheel goes from voxel to voxel; only its normal leans forward.
    const Vec3 leaning{std::sin(0.4), 0, -std::cos(0.4)};
    for (int step = 0; step < 10; ++step) {
        const auto slid =
            advanced(memory, {contact(step, 0), contact(step + 1, 0, leaning)}, {-0.02, 0, 0});
        EXPECT_NEAR(slid[0], (step == 0 ? 1 : 1 + std::cos(0.4)) * 0.002, 1e-4) << step;
        EXPECT_NEAR(slid[1], 0.002 * std::cos(0.4), 1e-12) << "just met, step " << step;
    }
}

TEST(ContactMemory, a_wheels_steep_front_takes_no_soil_along) {
    ContactMemory memory;
    const double c = std::sqrt(0.5);
    // Its surface goes forwards along itself, as high as it was; two voxels of each column touch
    // it.
    for (int step = 0; step < 10; ++step) {
        std::vector<ContactVoxel> front;
        for (int k = 0; k < 3; ++k) {
            for (int layer = 0; layer < 2; ++layer) {
                front.push_back(contact(step + k, k + layer, {c, 0, -c}));
            }
        }
        const auto slid = advanced(memory, front, {0, 0, -0.02});
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(slid[2 * k], 0.002 * c * std::min(step + 1, 3 - k), 1e-9) << step << k;
        }
    }
}

TEST(ContactMemory, soil_pushed_on_along_the_normal_keeps_its_shear) {
    ContactMemory memory;
    for (int step = 0; step < 10; ++step) {
        // a wall's contact, drawn aside along itself while it moves on by a voxel a step
        const auto slid = advanced(memory, {contact(step, 0, {1, 0, 0})}, {1, 0.05, 0});
        EXPECT_NEAR(slid[0], 0.005 * (step + 1), 1e-12);
    }
}

// Soil before a wall rises along it, at 0.577 of the push with phi = 30 deg. A wall that rises with
// it shears nothing; one that rises faster, the rest.
TEST(ContactMemory, sliding_that_the_soil_goes_along_with_is_none) {
    ContactMemory with_it, faster;
    for (int step = 0; step < 10; ++step) {
        const ContactVoxel wall = contact(step, 0, {1, 0, 0});
        EXPECT_EQ(advanced(with_it, {wall}, {1, 0, 0.5})[0], 0);
        EXPECT_NEAR(advanced(faster, {wall}, {1, 0, 1})[0],
                    (1 - std::tan(std::numbers::pi / 6)) * kStep * (step + 1), 1e-9);
    }
}

TEST(ContactMemory, what_is_not_pressed_is_not_sheared) {
    ContactMemory memory;
    ContactVoxel brushing = contact(0, 0);
    brushing.depth_m = brushing.bearing_depth_m = 0;
    EXPECT_EQ(advanced(memory, {brushing}, {1, 0, 0})[0], 0);
    brushing.compression_m = brushing.bearing_depth_m = 1e-3;
    EXPECT_NEAR(advanced(memory, {brushing}, {1, 0, 0})[0], 0.1, 1e-12);
}

TEST(ContactMemory, remembers_how_far_a_surface_has_drawn_back) {
    ContactMemory memory;
    const ContactVoxel sole = contact(0, 0);
    const auto retreat_m = [&](double rise_m) {
        return memory.advance({&sole, 1}, moving({0.3, 0, rise_m / kStep}), law(), kStep)[0]
            .retreat_m;
    };
    EXPECT_EQ(retreat_m(-0.005), 0) << "pressed in";
    EXPECT_NEAR(retreat_m(0.003), 0.003, 1e-12);
    EXPECT_NEAR(retreat_m(0.002), 0.005, 1e-12);
    EXPECT_NEAR(retreat_m(-0.004), 0.001, 1e-12) << "comes back";
    EXPECT_EQ(retreat_m(-0.002), 0) << "and goes on";
    EXPECT_EQ(retreat_m(0.5), kVoxel) << "parted";
}

// By hand: at x behind its axle a wheel has risen by x^2 / 2 r since it was over that soil.
TEST(ContactMemory, a_rolling_wheel_draws_back_as_far_at_any_step) {
    constexpr double kRadius = 0.5, kSpeed = 1;
    for (const double step_s : {0.01, 0.04}) {
        ContactMemory memory;
        double retreat_m = 0;
        for (double ahead_m = 0.07; ahead_m > -0.1; ahead_m -= kSpeed * step_s) {
            ContactVoxel v = contact(0, 0);
            BodyMotion wheel;
            wheel.linear_velocity_m_s = {kSpeed, 0, 0};
            wheel.angular_velocity_rad_s = {0, kSpeed / kRadius, 0};
            const double sine = ahead_m / kRadius, cosine = std::sqrt(1 - sine * sine);
            v.normal = {sine, 0, -cosine};
            wheel.center_of_mass_m = v.position_m - kRadius * v.normal;
            retreat_m = memory.advance({&v, 1}, wheel, law(), step_s)[0].retreat_m;
            const double expected_m = ahead_m < 0 ? ahead_m * ahead_m / (2 * kRadius) : 0;
            EXPECT_NEAR(retreat_m, expected_m, 0.02 * expected_m + 1e-12) << step_s;
        }
        EXPECT_GT(retreat_m, 0.006);
    }
}

TEST(ContactMemory, soil_passes_from_link_to_link_with_its_shear) {
    // Two links of three voxels slide on as one plate of six, a voxel every fifth step.
    ContactMemory front, rear, plate;
    const Vec3 velocity{kVoxel / kStep / 5, 0, 0};
    for (int step = 0; step < 40; ++step) {
        const int at = step / 5;
        std::vector<ContactVoxel> behind, ahead, whole;
        for (int i = 0; i < 6; ++i) {
            (i < 3 ? behind : ahead).push_back(contact(at + i, 0));
            whole.push_back(contact(at + i, 0));
        }
        const std::vector<PressedSoil> known[] = {{rear.soil().begin(), rear.soil().end()},
                                                  {front.soil().begin(), front.soil().end()}};
        const std::vector<PressedList> lists{PressedList(known[0], 0), PressedList(known[1], 1)};
        std::vector<double> of_links;
        for (ContactMemory* link : {&rear, &front}) {
            std::vector<PressedSoil> around;
            const auto& voxels = link == &rear ? behind : ahead;
            ContactMemory::near(lists, voxels, link == &front, law(), around);
            const auto slid = link->advance(voxels, moving(velocity), law(), kStep, around);
            for (const ContactHistory& h : slid) of_links.push_back(h.sheared_m);
        }
        EXPECT_EQ(of_links, advanced(plate, whole, velocity)) << "step " << step;
    }
}

// As if all lists were merged.
TEST(ContactMemory, soil_of_several_bodies_is_sorted_and_bounded) {
    const auto row = [](int first, int y) {
        std::vector<PressedSoil> soil;
        for (int i = first; i < first + 6; i += 2) {
            soil.push_back({contact(i, y).center_m, {0, 0, -1}, {0, y * 1.0, 0}, 0});
        }
        return soil;
    };
    const auto own = row(0, 0), even = row(0, 1), odd = row(1, 0), same = row(0, 2),
               far = row(60, 0);
    const std::vector<PressedList> lists{PressedList(own, 7), PressedList(even, 8),
                                         PressedList(odd, 9), PressedList(same, 10),
                                         PressedList(far, 11)};
    std::vector<ContactVoxel> voxels{contact(0, 0), contact(4, 2)};
    std::vector<PressedSoil> around;
    ContactMemory::near(lists, voxels, 7, law(), around);
    ASSERT_EQ(around.size(), 9u) << "not its own, and not what is far off";
    EXPECT_TRUE(std::ranges::is_sorted(around, lies_before));
    for (const size_t i : {0u, 3u, 6u}) {
        EXPECT_EQ(length(around[i].center_m - even[i / 3].center_m), 0) << "the first list's first";
        EXPECT_EQ(length(around[i + 1].center_m - same[i / 3].center_m), 0);
        EXPECT_EQ(length(around[i + 2].center_m - odd[i / 3].center_m), 0);
    }
    ContactMemory::near(lists, {}, 7, law(), around);
    EXPECT_TRUE(around.empty());
}

TEST(ContactMemory, another_face_in_the_same_voxel_keeps_its_own) {
    ContactMemory sole, wall;
    advanced(sole, {contact(0, 0)}, {0.5, 0, 0});
    const auto slid = wall.advance(std::vector{contact(0, 0, {1, 0, 0})}, moving({0, 0.01, 0}),
                                   law(), kStep, sole.soil());
    EXPECT_NEAR(slid[0].sheared_m, 0.001, 1e-12);
}

TEST(ContactMemory, two_faces_in_one_voxel_are_told_apart) {
    ContactMemory memory;
    const Vec3 down{0, 0, -1}, ahead{1, 0, 0};
    for (int step = 1; step <= 3; ++step) {
        const auto slid =
            advanced(memory, {contact(0, 0, down), contact(0, 0, ahead)}, {0.02, 0, 0});
        EXPECT_NEAR(slid[0], 0.002 * step, 1e-12);
        EXPECT_NEAR(slid[1], 0, 1e-12);
    }
}

/// What recall() is to find, by asking all entries.
const PressedSoil* nearest_of_all(const std::vector<PressedSoil>& soil, const ContactVoxel& v) {
    const ContactLawDef& def = law().def();
    const double across_m = def.same_across_voxels * kVoxel;
    const Vec3 way = v.normal.z < -def.looks_down_cosine ? Vec3{0, 0, 1} : v.normal;
    const PressedSoil* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const PressedSoil& entry : soil) {
        const Vec3 apart = entry.center_m - v.center_m;
        const double square = dot(apart, apart), along = dot(apart, way);
        if (std::abs(along) > def.same_along_voxels * kVoxel ||
            square - along * along > across_m * across_m) {
            continue;
        }
        const double unlike = square + (1 - dot(entry.normal, v.normal)) * across_m * across_m;
        if (unlike < least) {
            least = unlike;
            nearest = &entry;
        }
    }
    return nearest;
}

TEST(ContactMemory, finds_what_a_search_through_all_entries_finds) {
    std::mt19937 random(7);
    const auto number = [&random](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    const Vec3 normals[] = {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {0.6, 0, -0.8}, {0, 0.8, -0.6}};
    // Dense and sparse, in the middles of voxels and, where a body carries soil, anywhere.
    for (const double side_voxels : {3.0, 8.0, 200.0}) {
        for (const bool is_carried : {false, true}) {
            const auto place = [&] {
                const auto along = [&] {
                    const double at = number(0, side_voxels);
                    return (is_carried ? at : std::floor(at) + 0.5) * kVoxel;
                };
                return Vec3{along(), along(), 0.2 * along()};
            };
            std::vector<PressedSoil> soil(300);
            for (PressedSoil& entry : soil) {
                entry = {place(), normals[random() % 5], {number(0.001, 1), 0, 0}, number(0, 0.1)};
            }
            std::ranges::stable_sort(soil, lies_before);
            ContactMemory memory;
            memory.set_soil(soil);
            std::vector<ContactVoxel> voxels(300);
            for (ContactVoxel& v : voxels) {
                v = contact(0, 0, normals[random() % 5]);
                v.center_m = place();
            }
            const auto history = memory.recall(voxels, law());
            for (size_t i = 0; i < voxels.size(); ++i) {
                const PressedSoil* nearest = nearest_of_all(soil, voxels[i]);
                EXPECT_EQ(history[i].sheared_m, nearest ? nearest->slid_m.x : 0) << i;
                EXPECT_EQ(history[i].retreat_m, nearest ? nearest->retreat_m : 0) << i;
            }
        }
    }
}

}  // namespace
}  // namespace bsoil::contact_memory_test
