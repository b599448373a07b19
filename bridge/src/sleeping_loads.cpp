#include "sleeping_loads.h"

#include <algorithm>

#include "coupling_def.h"

namespace bsoil::bullet {

void SleepingLoads::set_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads,
                              Vec3 gravity_m_s2, double step_s) {
    std::map<int, Sleeper> before;
    before.swap(sleepers_);
    for (const BodyState& body : bodies) {
        const bool feels = body.role == BodyRole::rigid || body.role == BodyRole::link;
        if (!feels || !body.is_asleep) continue;
        Sleeper sleeper;
        if (const auto known = before.find(body.id); known != before.end()) sleeper = known->second;
        const auto load =
            std::ranges::find_if(loads, [&](const BodyLoad& l) { return l.body == body.id; });
        const Vec3 force_n = load == loads.end() ? Vec3{} : force_of(*load, gravity_m_s2, step_s);
        if (has_changed(body, force_n, sleeper)) {
            wake_object(world_, body);
        } else {
            sleepers_.emplace(body.id, sleeper);
        }
    }
}

bool SleepingLoads::has_changed(const BodyState& body, Vec3 force_n, Sleeper& sleeper) const {
    sleeper.step_count = std::min(sleeper.step_count, kCoupling.wake_steps) + 1;
    const int mean_count = std::min(sleeper.step_count, kCoupling.wake_steps);
    sleeper.mean_n += (1.0 / mean_count) * (force_n - sleeper.mean_n);
    if (sleeper.step_count <= kCoupling.wake_steps) {
        sleeper.at_sleep_n = sleeper.mean_n;
        return false;
    }
    const double most_n = wake_weight_fraction_ * (body.weight_n + length(sleeper.at_sleep_n));
    return length(sleeper.mean_n - sleeper.at_sleep_n) > most_n;
}

}  // namespace bsoil::bullet
