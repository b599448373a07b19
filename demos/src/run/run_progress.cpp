#include "run_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bsoil::scene {
namespace {

constexpr double kLineGapS = 10;   ///< a short run needs no lines, a log no flood
constexpr double kLineMostS = 60;  ///< longer without a word looks like a hang
constexpr double kMinuteS = 60, kHourS = 3600;

}  // namespace

int percent_of(const Progress& p) {
    return static_cast<int>(100 * p.step_count / std::max(1LL, p.step_target));
}

double remaining_s(const Progress& p) {
    const long long made = p.step_count - p.step_first;
    if (made <= 0) return -1;
    return p.wall_s / static_cast<double>(made) *
           static_cast<double>(std::max(0LL, p.step_target - p.step_count));
}

std::string duration_text(double seconds) {
    const double whole_s = std::round(seconds);
    if (whole_s < kMinuteS) return fmt::format("{:.0f} s", whole_s);
    if (whole_s < kHourS) {
        return fmt::format("{:.0f} min {:02.0f} s", std::floor(whole_s / kMinuteS),
                           std::fmod(whole_s, kMinuteS));
    }
    return fmt::format("{:.0f} h {:02.0f} min", std::floor(whole_s / kHourS),
                       std::floor(std::fmod(whole_s, kHourS) / kMinuteS));
}

std::string progress_text(const Progress& p) {
    std::string text = fmt::format("{:3}%  {:.2f} s simulated, {}", percent_of(p), p.time_s,
                                   duration_text(p.wall_s));
    const double left_s = remaining_s(p);
    if (left_s >= 0 && p.step_count < p.step_target) {
        text += ", " + duration_text(left_s) + " to go";
    }
    return text;
}

bool LogCadence::is_due(const Progress& p) {
    const int tenth = percent_of(p) / 10;
    const double waited_s = p.wall_s - last_s_;
    const bool due = (tenth > tenth_ && waited_s >= kLineGapS) || waited_s >= kLineMostS;
    if (due) {
        tenth_ = tenth;
        last_s_ = p.wall_s;
    }
    return due;
}

}  // namespace bsoil::scene
