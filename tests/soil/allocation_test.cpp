// A warm step allocates nothing.
#include "allocation_count.h"
#include "soil_fixture.h"

namespace bsoil::allocation_test {
namespace {

TEST(Allocation, none_in_a_warm_step) {
    auto soil = make_soil(grid_def(48, 32, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 32, 6})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{2, 4, 2} * 0.05), Vec3{24, 16, 6.5} * 0.05);
    movers.emplace_back(2, octahedron_shape(0.15), Vec3{12, 12, 6.5} * 0.05);
    movers.emplace_back(3, round_shape(ConvexShape::Kind::cylinder, 0.1, 0.2),
                        Vec3{36, 24, 6} * 0.05, true);
    std::vector<SoilBody> bodies = bodies_of(movers);
    const auto step = [&](int i) {
        for (size_t m = 0; m < 2; ++m) {
            movers[m].set_velocity(
                {0.5 * std::sin(0.2 * i + static_cast<double>(m)), 0.3 * std::cos(0.3 * i), 0},
                {0, 0, 1});
            movers[m].advance(1.0 / 60);
            bodies[m] = movers[m].body;
        }
        return soil->step(bodies);
    };
    int i = 0;
    while (i < 240) step(i++);
    // A tile that falls asleep or wakes keeps its soil in another place, so such steps do not
    // count.
    int64_t allocated = 0, contact_count = 0;
    int64_t asleep_bytes = -1;
    int steady_count = 0, awake_count = -1;
    while (i < 480) {
        const int64_t before = allocation_count();
        const StepReport report = step(i++);
        const int64_t allocation_end = allocation_count();
        // One may fall asleep in the step in which another one wakes.
        const int64_t asleep_now_bytes = soil->memory_use().asleep_bytes;
        const bool steady =
            report.tile_awake_count == awake_count && asleep_now_bytes == asleep_bytes;
        awake_count = report.tile_awake_count;
        asleep_bytes = asleep_now_bytes;
        steady_count += steady;
        allocated += steady ? allocation_end - before : 0;
        contact_count += static_cast<int64_t>(report.contacts.size());
    }
    EXPECT_EQ(allocated, 0);
    EXPECT_GT(steady_count, 200);
    EXPECT_GT(contact_count, 1000);
}

// A condition that goes on in every step, and one that comes anew.
TEST(Allocation, none_for_a_condition) {
    auto soil = make_soil(grid_def(32, 24, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 24, 6})));
    std::vector<Mover> movers;
    movers.emplace_back(1, sphere_shape(0.1), Vec3{-2, 0, 0});
    std::vector<SoilBody> bodies = bodies_of(movers);
    for (int i = 0; i < 60; ++i) soil->step(bodies);
    soil->clear_status();
    const int64_t before = allocation_count();
    const StepReport report = soil->step(bodies);
    EXPECT_EQ(report.condition_new_count, 1);
    EXPECT_EQ(soil->step(bodies).condition_new_count, 0);
    EXPECT_EQ(allocation_count() - before, 0);
}

}  // namespace
}  // namespace bsoil::allocation_test
