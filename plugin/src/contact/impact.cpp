#include "bsoil/contact/impact.h"

#include <algorithm>
#include <cmath>

#include "bsoil/contact/momentum_flux.h"

namespace bsoil {
namespace {

/// Parts in which a fall is solved. Ours: a body that stops within one stops to a hundredth of the
/// distance. More takes longer; fewer lets the body go deeper than its resistance lets it.
constexpr int kPartCount = 128;

}  // namespace

void Impact::start(const ContactLaw& law, std::span<const ContactVoxel> elements,
                   const ImpactBody& body) {
    law_ = &law;
    elements_ = elements;
    body_ = body;
    rise_ = dot(body.normal, law.up());
    still_ = body.motion;
    still_.linear_velocity_m_s = still_.angular_velocity_rad_s = {};
    double depth_m = 0;
    for (const ContactVoxel& element : elements) depth_m = std::max(depth_m, element.depth_m);
    met_m_ = std::max(0.0, body.most_m - depth_m * rise_);
    here_n_ = at(0).force_n;
    // More closely where it starts: a ball's resistance grows with the square of its depth.
    for (int i = 0; i <= kDepthCount; ++i) {
        const double part = static_cast<double>(i) / kDepthCount;
        known_[static_cast<size_t>(i)] = at(met_m_ + part * part * (body.most_m - met_m_));
    }
}

Vec3 Impact::center_m(std::span<const ContactVoxel> elements, double most_m, Vec3 normal) {
    Vec3 center;
    double weight = 0;
    for (const ContactVoxel& element : elements) {
        center += element.area_m2 * element.depth_m * element.position_m;
        weight += element.area_m2 * element.depth_m;
    }
    return center * (1 / weight) + most_m * normal;
}

Resistance Impact::at(double way_m) {
    const Vec3 n = body_.normal;
    lifted_.clear();
    Resistance out;
    for (ContactVoxel element : elements_) {
        element.depth_m -= (body_.most_m - way_m) / rise_;
        if (!(element.depth_m > 0)) continue;
        element.bearing_depth_m = element.depth_m;
        element.position_m += (body_.most_m - way_m) * n;
        element.center_m = element.position_m;
        lifted_.push_back(element);
        // At a speed of one: the element's own speed along its normal is its facing.
        const double facing = std::max(0.0, -dot(element.normal, n));
        out.drag_kg_m += momentum_flux(body_.density_kg_m3 * element.area_m2, facing) * facing;
    }
    const ContactMotion on_ground{-1, still_, body_.direction, {}, {}};
    found_.find(lifted_, {&on_ground, 1}, *law_, {}, nullptr,
                {.apart_m = body_.apart_m, .mobilized = false});
    for (const ContactPatch& patch : found_.patches()) {
        out.force_n -= patch.normal_limit_n * dot(patch.normal, n);
    }
    return out;
}

Resistance Impact::between(double way_m) const {
    if (way_m <= met_m_) return known_[0];
    const double part = std::min(1.0, (way_m - met_m_) / (body_.most_m - met_m_));
    const int i = std::min(static_cast<int>(std::sqrt(part) * kDepthCount), kDepthCount - 1);
    const double low = i * i, high = (i + 1) * (i + 1);
    const double t = (part * kDepthCount * kDepthCount - low) / (high - low);
    const Resistance &a = known_[static_cast<size_t>(i)], &b = known_[static_cast<size_t>(i) + 1];
    return {a.force_n + t * (b.force_n - a.force_n), a.drag_kg_m + t * (b.drag_kg_m - a.drag_kg_m)};
}

Stopping Impact::stop(const Fall& fall, double duration_s) const {
    const double part_s = duration_s / kPartCount;
    Stopping out{0, fall.speed_m_s};
    for (int part = 0; part < kPartCount; ++part) {
        const Resistance now = between(out.way_m + 0.5 * part_s * out.speed_m_s);
        const double held = now.force_n / fall.mass_kg;
        const double drag = now.drag_kg_m / fall.mass_kg * part_s * out.speed_m_s;
        const double next =
            std::max(0.0, (out.speed_m_s + part_s * (fall.acceleration_m_s2 - held)) / (1 + drag));
        out.way_m += 0.5 * part_s * (out.speed_m_s + next);
        out.speed_m_s = next;
    }
    return out;
}

double Impact::first_way_m() const {
    return met_m_ + (body_.most_m - met_m_) / (kDepthCount * kDepthCount);
}

}  // namespace bsoil
