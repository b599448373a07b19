// Progress in words, and when a log gets a line.
#include "run/run_progress.h"

#include <gtest/gtest.h>

namespace bsoil::scene::run_progress_test {
namespace {

TEST(RunProgress, says_percent_time_and_what_is_left) {
    EXPECT_EQ(progress_text({40, 100, 0, 0.667, 12}), " 40%  0.67 s simulated, 12 s, 18 s to go");
    EXPECT_EQ(progress_text({100, 100, 0, 1.667, 30}), "100%  1.67 s simulated, 30 s");
    EXPECT_EQ(progress_text({0, 100, 0, 0, 0}), "  0%  0.00 s simulated, 0 s");
}

TEST(RunProgress, reckons_what_is_left_from_the_steps_of_this_process) {
    // Goes on from step 50: 10 steps in 20 s, 40 are left.
    EXPECT_DOUBLE_EQ(remaining_s({60, 100, 50, 1, 20}), 80);
    EXPECT_LT(remaining_s({50, 100, 50, 1, 0}), 0);
}

TEST(RunProgress, durations_are_for_people) {
    EXPECT_EQ(duration_text(59.4), "59 s");
    EXPECT_EQ(duration_text(59.6), "1 min 00 s");
    EXPECT_EQ(duration_text(185), "3 min 05 s");
    EXPECT_EQ(duration_text(7620), "2 h 07 min");
}

int lines_of(double wall_per_step_s, int steps) {
    LogCadence cadence;
    int lines = 0;
    for (int i = 1; i <= steps; ++i) lines += cadence.is_due({i, steps, 0, 0, i * wall_per_step_s});
    return lines;
}

TEST(RunProgress, a_log_gets_a_line_each_tenth_and_each_minute_and_a_short_run_none) {
    EXPECT_EQ(lines_of(0.005, 1000), 0);  // 5 s
    EXPECT_EQ(lines_of(0.2, 1000), 10);   // 200 s, a tenth takes 20 s
    EXPECT_EQ(lines_of(0.05, 1000), 5);   // 50 s, a tenth takes 5 s
    EXPECT_EQ(lines_of(6, 1000), 100);    // 6000 s, a tenth takes 600 s
}

}  // namespace
}  // namespace bsoil::scene::run_progress_test
