#include "motion.h"

#include <algorithm>
#include <cmath>

namespace bsoil::scene {
namespace {

Curve::Interpolation interpolation_of(const MotionItem& item) {
    if (item.interpolation == "linear") return Curve::Interpolation::linear;
    if (item.interpolation == "step") return Curve::Interpolation::step;
    return Curve::Interpolation::smooth;
}

/// The shorter way from a to b at constant angular speed; u in 0..1.
Quat between(Quat a, Quat b, double u) {
    double cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
    if (cosine < 0) {
        b = {-b.x, -b.y, -b.z, -b.w};
        cosine = -cosine;
    }
    double p = 1 - u, q = u;
    if (cosine < 1 - 1e-9) {
        const double angle = std::acos(cosine);
        p = std::sin((1 - u) * angle) / std::sin(angle);
        q = std::sin(u * angle) / std::sin(angle);
    }
    return {p * a.x + q * b.x, p * a.y + q * b.y, p * a.z + q * b.z, p * a.w + q * b.w};
}

}  // namespace

Curve::Curve(std::vector<double> t_s, std::vector<double> values, Interpolation interpolation)
    : t_s_(std::move(t_s)),
      values_(std::move(values)),
      slopes_(t_s_.size(), 0.0),
      interpolation_(interpolation) {
    for (size_t i = 1; i + 1 < t_s_.size(); ++i) {
        const double h0 = t_s_[i] - t_s_[i - 1], h1 = t_s_[i + 1] - t_s_[i];
        const double d0 = (values_[i] - values_[i - 1]) / h0;
        const double d1 = (values_[i + 1] - values_[i]) / h1;
        if (d0 * d1 > 0) {  // else an extreme: at rest there
            slopes_[i] = 3 * (h0 + h1) / ((2 * h1 + h0) / d0 + (h1 + 2 * h0) / d1);
        }
    }
}

double Curve::value(double t_s) const {
    if (t_s <= t_s_.front()) return values_.front();
    if (t_s >= t_s_.back()) return values_.back();
    const auto after = std::upper_bound(t_s_.begin(), t_s_.end(), t_s);
    const size_t i = static_cast<size_t>(after - t_s_.begin()) - 1;
    const double h = t_s_[i + 1] - t_s_[i];
    const double u = (t_s - t_s_[i]) / h;
    const double a = values_[i], b = values_[i + 1];
    switch (interpolation_) {
        case Interpolation::step:
            return a;
        case Interpolation::linear:
            return a + (b - a) * u;
        case Interpolation::smooth:
            break;
    }
    const double v = 1 - u;  // cubic Hermite basis
    return a * v * v * (1 + 2 * u) + b * u * u * (3 - 2 * u) + h * slopes_[i] * u * v * v -
           h * slopes_[i + 1] * u * u * v;
}

Motion::Motion(const MotionItem& item)
    : period_s_(item.period_s), repeat_count_(item.repeat_count) {
    const Curve::Interpolation interpolation = interpolation_of(item);
    const std::vector<MotionKey>& keys = item.motion_keys;
    std::vector<double> t_s;
    for (const MotionKey& key : keys) t_s.push_back(key.t_s);
    const auto add = [&](auto&& value_of) {
        std::vector<double> values;
        for (const MotionKey& key : keys) values.push_back(value_of(key));
        curves_.emplace_back(t_s, std::move(values), interpolation);
    };
    const MotionKey& first = keys.front();
    if (!item.body.empty()) {
        quantity_ = Quantity::pose;
        add([](const MotionKey& k) { return k.position_m.value_or(Vec3{}).x; });
        add([](const MotionKey& k) { return k.position_m.value_or(Vec3{}).y; });
        add([](const MotionKey& k) { return k.position_m.value_or(Vec3{}).z; });
        for (const MotionKey& key : keys) rotations_.push_back(key.rotation.value_or(Quat{}));
        double index = -1;
        add([&index](const MotionKey&) { return ++index; });
        return;
    }
    const bool moves = first.velocity_rad_s || first.velocity_m_s;
    quantity_ = moves ? Quantity::velocity : Quantity::position;
    add([](const MotionKey& k) {
        for (const auto& value : {k.position_rad, k.offset_m, k.velocity_rad_s, k.velocity_m_s}) {
            if (value) return *value;
        }
        return 0.0;
    });
}

Pose Motion::pose(double t_s) const {
    const double t = local_time(t_s);
    const double place = curves_[3].value(t);
    const size_t last = rotations_.size() - 1;
    const size_t i = std::min(static_cast<size_t>(place), last);
    const Quat rotation =
        between(rotations_[i], rotations_[std::min(i + 1, last)], place - static_cast<double>(i));
    return {{curves_[0].value(t), curves_[1].value(t), curves_[2].value(t)}, rotation};
}

double Motion::local_time(double t_s) const {
    if (repeat_count_ <= 1) return t_s;
    const double round = std::min(std::floor(t_s / period_s_), repeat_count_ - 1.0);
    return t_s - std::max(round, 0.0) * period_s_;
}

}  // namespace bsoil::scene
