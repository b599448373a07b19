/// A GPU that fails while the soil runs: it is said, and nothing false is saved.
#include <cstdlib>

#include "device/egl_context.h"
#include "soil_fixture.h"
#include "temporary_file.h"

namespace bsoil::device_lost_test {
namespace {

/// Takes all of this process's contexts away, as a driver does that goes down.
void lose_all_contexts() {
    const auto displays = device::find_egl_displays();
    ASSERT_TRUE(displays) << displays.error();
    for (const device::EglDisplay& display : *displays) eglTerminate(display.handle);
}

void expect_it_is_said() {
    SoilDef def = grid_def(16, 16, 16);
    def.backend = Backend::gl;
    auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {4, 4, 2}, {12, 12, 10})));
    EXPECT_EQ(soil->step({}).status_bits, 0u);
    EXPECT_EQ(soil->device_failure(), "");

    lose_all_contexts();
    const StepReport report = soil->step({});
    EXPECT_NE(soil->device_failure().find("cannot be made current"), std::string::npos)
        << soil->device_failure();
    EXPECT_EQ(report.status_bits, static_cast<uint32_t>(StatusBit::device_lost));
    ASSERT_EQ(report.conditions.size(), 1u);
    EXPECT_EQ(report.conditions[0].first_step, 2);

    const TemporaryFile file("lost.snapshot");
    const Status saved = soil->save(file.path());
    ASSERT_FALSE(saved);
    EXPECT_NE(saved.error().find("it is lost"), std::string::npos) << saved.error();
    EXPECT_TRUE(soil->state().empty());
    ASSERT_FALSE(soil->load(file.path()));
    const auto settled = soil->settle(10);
    ASSERT_FALSE(settled);
    EXPECT_EQ(settled.error(), soil->device_failure());
    // Whoever goes on harms nothing, and a new soil is as good as any.
    for (int i = 0; i < 3; ++i) soil->step({});
    const auto another = make_soil(def);
    ASSERT_TRUE(another);
    ASSERT_TRUE(another->fill(voxel_box(*another, {4, 4, 2}, {12, 12, 10})));
    EXPECT_EQ(another->step({}).status_bits, 0u);
}

class NoMemory : public testing::TestWithParam<Backend> {};

// A list that grows past all the memory there is. Before, the step wrote it to a buffer that was
// gone.
TEST_P(NoMemory, for_a_list_is_said_and_nothing_false_is_saved) {
    if (GetParam() == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
    SoilDef def = grid_def(16, 16, 16);
    def.backend = GetParam();
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {4, 4, 2}, {12, 12, 10})));
    EXPECT_EQ(soil->step({}).status_bits, 0u);

    size_t capacity = 0;
    SoilProbe::impl(*soil).ensure_capacity(layout::Buffer::block_list, capacity, size_t{1} << 45);
    EXPECT_EQ(capacity, 0u);
    std::vector<Mover> movers;
    movers.emplace_back(1, sphere_shape(0.1), Vec3{0.4, 0.4, 0.5});
    for (int i = 0; i < 3; ++i) {
        const StepReport report = soil->step(bodies_of(movers));
        EXPECT_EQ(report.status_bits, static_cast<uint32_t>(StatusBit::device_lost));
        EXPECT_TRUE(report.contacts.empty());
    }
    EXPECT_NE(soil->device_failure().find("buffer block_list: cannot allocate"), std::string::npos)
        << soil->device_failure();
    const TemporaryFile file("no_memory.snapshot");
    EXPECT_FALSE(soil->save(file.path()));
    EXPECT_FALSE(soil->settle(10));
    EXPECT_TRUE(soil->state().empty());
}

// The same of what sources need: the tables of all materials lie in the same buffer.
TEST_P(NoMemory, is_said_once_and_for_all) {
    if (GetParam() == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
    SoilDef def = grid_def(16, 16, 16);
    def.backend = GetParam();
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    device::Device& device = *SoilProbe::impl(*soil).device;
    const Status refused = device.allocate(layout::Buffer::tables, int64_t{1} << 45);
    ASSERT_FALSE(refused);
    EXPECT_EQ(device.failure(), "");  // who asked may do without
    device.give_up(refused.error());
    device.give_up("another reason");
    EXPECT_EQ(device.failure(), refused.error());
    EXPECT_FALSE(device.allocate(layout::Buffer::tables, 16));
    const std::vector<int32_t> ones(16, 1);
    device.write(layout::Buffer::tables, 0, ones);
    std::vector<int32_t> back(16, 1);
    device.read(layout::Buffer::tables, 0, back);
    EXPECT_EQ(back, std::vector<int32_t>(16, 0));
}

INSTANTIATE_TEST_SUITE_P(Backends, NoMemory, testing::Values(Backend::cpu, Backend::gl),
                         [](const auto& tested) {
                             return tested.param == Backend::cpu ? "cpu" : "gl";
                         });

// In a process of its own: other tests keep contexts.
TEST(DeviceLostDeathTest, is_said_and_nothing_false_is_saved) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    const auto in_child = [] {
        expect_it_is_said();
        std::exit(testing::Test::HasFailure() ? 1 : 0);
    };
    EXPECT_EXIT(in_child(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace bsoil::device_lost_test
