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
