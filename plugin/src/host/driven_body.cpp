#include "bsoil/host/driven_body.h"

#include <algorithm>
#include <iterator>

namespace bsoil {

namespace {

std::unique_ptr<const ContactLaw> law_of(const Soil& soil, const SurfaceFriction& surface) {
    return ContactLaw::make(std::make_shared<const ContactSoil>(soil.contact_soil()), surface);
}

}  // namespace

DrivenBody::DrivenBody(Soil& soil, int body, const SurfaceFriction& surface)
    : soil_(soil),
      body_(body),
      surface_(surface),
      def_revision_(soil.def_revision()),
      law_(law_of(soil, surface)) {}

BodyContact DrivenBody::advance(const SoilBody& body, std::span<const ContactVoxel> contacts) {
    if (def_revision_ != soil_.def_revision()) {
        def_revision_ = soil_.def_revision();
        law_ = law_of(soil_, surface_);
    }
    own_.clear();
    std::ranges::copy_if(contacts, std::back_inserter(own_),
                         [this](const ContactVoxel& v) { return v.body == body_; });
    const double step_s = soil_.def().step_s;
    const BodyMotion now{body.pose, body.center_of_mass_m, body.linear_velocity_m_s,
                         body.angular_velocity_rad_s};
    const WorkThreads* threads = &soil_.threads();
    motion_.advance(now, nullptr, own_, step_s, {false, false, law_->voxel_m()}, threads);
    const auto history = memory_.advance(own_, now, *law_, step_s, {}, {}, threads);
    const BodyContact out = found_.find(own_, {&motion_, 1}, *law_, history, threads);
    soil_.known_contacts().set_width(body_, out.width_m);
    soil_.known_contacts().set_pressure(body_, out.mobilized_pressure_pa);
    return out;
}

}  // namespace bsoil
