// Loops whose parts run at the same time, and that the contacts' give the same bits on any number
// of threads.
#include "bsoil/work_threads.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "bsoil/contact/contact_memory.h"

namespace bsoil::work_threads_test {
namespace {

TEST(WorkThreads, do_each_part_once) {
    const WorkThreads threads(4);
    for (const size_t count : {0, 1, 7, 1000}) {
        for (const size_t least : {1, 64, 5000}) {
            std::vector<int> done(count);
            threads.for_ranges(count, least, [&](size_t first, size_t last) {
                EXPECT_LT(first, last);
                for (size_t i = first; i < last; ++i) ++done[i];
            });
            EXPECT_EQ(done, std::vector<int>(count, 1)) << count << " " << least;
        }
    }
}

TEST(WorkThreads, work_within_a_part) {
    const WorkThreads threads(4);
    std::array<std::vector<int>, 8> done;
    threads.for_ranges(done.size(), 1, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            done[i].resize(300);
            threads.for_ranges(done[i].size(), 16, [&, i](size_t from, size_t to) {
                for (size_t k = from; k < to; ++k) ++done[i][k];
            });
        }
    });
    for (const std::vector<int>& part : done) EXPECT_EQ(part, std::vector<int>(300, 1));
}

// SurfaceMeshDef::thread_count comes as its host has set it, and TBB crashes for 2^31 of them.
TEST(WorkThreads, as_many_as_nobody_has_are_no_more_than_may_be) {
    for (const int count : {std::numeric_limits<int>::max(), -5}) {
        const WorkThreads threads(count);
        std::vector<int> done(1000);
        threads.for_ranges(done.size(), 1, [&](size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) ++done[i];
        });
        EXPECT_EQ(done, std::vector<int>(1000, 1)) << count;
    }
}

TEST(WorkThreads, no_threads_is_this_thread) {
    int calls = 0;
    for_ranges(nullptr, 5, 1, [&](size_t first, size_t last) {
        EXPECT_EQ(first, 0u);
        EXPECT_EQ(last, 5u);
        ++calls;
    });
    for_ranges(nullptr, 0, 1, [&](size_t, size_t) { ++calls; });
    EXPECT_EQ(calls, 1);
}

/// A ball of 1 m that rolls into sand, in voxels of 5 cm.
std::vector<ContactVoxel> ball_contacts(double way_m) {
    std::vector<ContactVoxel> out;
    const int rings = 60;
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < 2 * rings; ++j) {
            const double theta = std::numbers::pi * (i + 0.5) / rings;
            const double phi = std::numbers::pi * (j + 0.5) / rings;
            ContactVoxel& v = out.emplace_back();
            v.normal = {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                        std::cos(theta)};
            v.position_m = v.center_m = v.normal + Vec3{way_m, 0, 0};
            v.area_m2 = 0.0025 * std::sin(theta);
            v.depth_m = v.bearing_depth_m = std::max(0.0, 0.2 - v.position_m.z);
        }
    }
    return out;
}

TEST(ContactThreads, give_the_bits_of_one) {
    auto soil = std::make_shared<ContactSoil>();
    MaterialDef sand;
    sand.friction_angle_rad = 0.6;
    sand.shear_displacement_m = 0.02;
    soil->materials = {sand};
    const auto law = ContactLaw::make(soil);
    const WorkThreads threads(4);
    BodyMotion motion;
    motion.linear_velocity_m_s = {0.6, 0.1, -0.05};
    motion.angular_velocity_rad_s = {0, 0.7, 0};
    const ContactMotion on_ground{-1, motion, motion, {}, {}};

    ContactMemory alone_memory, shared_memory;
    ContactPatches alone, shared;
    for (int step = 0; step < 4; ++step) {
        const auto voxels = ball_contacts(0.01 * step);
        const auto find = [&](ContactMemory& memory, ContactPatches& patches,
                              const WorkThreads* on) {
            // Of another body, whose soil has sheared further.
            std::vector<PressedSoil> around(memory.soil().begin(), memory.soil().end());
            for (PressedSoil& entry : around) entry.slid_m = 2.0 * entry.slid_m;
            if (on) memory.look_around(around, *law, on);
            const auto history = memory.advance(voxels, motion, *law, 1.0 / 60, around, {}, on);
            return patches.find(voxels, {&on_ground, 1}, *law, history, on);
        };
        const BodyContact a = find(alone_memory, alone, nullptr);
        const BodyContact b = find(shared_memory, shared, &threads);
        EXPECT_GT(length(a.mobilized_force_n), 100);
        EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
        ASSERT_EQ(alone.patches().size(), shared.patches().size());
        for (size_t i = 0; i < alone.patches().size(); ++i) {
            EXPECT_EQ(alone.patches()[i].normal_limit_n, shared.patches()[i].normal_limit_n);
            EXPECT_EQ(alone.patches()[i].shear_point_m.x, shared.patches()[i].shear_point_m.x);
            EXPECT_EQ(alone.patches()[i].friction, shared.patches()[i].friction);
        }
    }
}

}  // namespace
}  // namespace bsoil::work_threads_test
