// What ContactCoupling finds of the bodies' contacts before it acts on them: faces, limits,
// patches.
#include <algorithm>

#include "contact_coupling.h"

namespace bsoil::bullet {

void ContactCoupling::find_pressed_around(BodyWork& work) const {
    if (work.kind != BodyWork::Kind::moved) return;
    CoupledBody& coupled = *work.coupled;
    ContactMemory::near(pressed_, work.voxels, coupled.body.id, *coupled.law, work.pressed_around);
    coupled.memory.look_around(work.pressed_around, *coupled.law, &threads_);
}

// What is kept has no new faces of its own, and is a part of its neighbours'.
void ContactCoupling::find_faces(std::span<BodyWork> works) {
    const bool are_kept = std::ranges::all_of(
        works, [](const BodyWork& work) { return work.kind == BodyWork::Kind::kept; });
    if (are_kept && works.size() == soles_.size()) return;
    // Neither needs the other: for each body first what it remembers, then its faces.
    for_ranges(&threads_, 2 * works.size(), 1, [&](size_t first, size_t last) {
        for (size_t job = first; job < last; ++job) {
            BodyWork& work = works[job / 2];
            if (job % 2 == 0) {
                find_pressed_around(work);
            } else {
                work.found.find_faces(work.voxels, work.coupled->body.motion.pose.rotation,
                                      *work.coupled->law, &threads_);
            }
        }
    });
    soles_.clear();
    for (BodyWork& work : works) {
        // A fixed body presses on nothing.
        const bool is_fixed = work.coupled->body.role == BodyRole::fixed;
        const auto voxels = is_fixed ? std::span<const ContactVoxel>{} : work.voxels;
        soles_.push_back({voxels, &work.found.faces()});
    }
    join_soles(soles_, soil_->up, &threads_);
    // A sleeper that has kept its own contacts may have lost or got a neighbour.
    for (BodyWork& work : works) {
        std::vector<FaceExtent>& slept = work.coupled->slept_faces;
        const std::span<const FaceExtent> faces = work.found.faces().faces();
        if (work.kind == BodyWork::Kind::kept && std::ranges::equal(slept, faces)) continue;
        if (work.kind == BodyWork::Kind::kept) work.kind = BodyWork::Kind::slept;
        slept.assign(faces.begin(), faces.end());
    }
}

void ContactCoupling::find_contact(BodyWork& work, double duration_s) const {
    if (work.kind == BodyWork::Kind::kept) return;
    CoupledBody& coupled = *work.coupled;
    const ContactLaw& law = *coupled.law;
    std::span<const ContactHistory> history;
    if (work.kind == BodyWork::Kind::slept) {
        history = coupled.memory.recall(work.voxels, law, &threads_);
    } else {
        const BodyMotion& now = coupled.body.motion;
        std::vector<ContactMotion> relative = coupled.motions;
        for (ContactMotion& past : relative) {
            past.motion.linear_velocity_m_s +=
                work.moved.linear_velocity_m_s - now.linear_velocity_m_s;
            past.motion.angular_velocity_rad_s +=
                work.moved.angular_velocity_rad_s - now.angular_velocity_rad_s;
        }
        history = coupled.memory.advance(work.voxels, work.moved, law, duration_s,
                                         work.pressed_around, relative, &threads_);
    }
    work.contact = work.found.find_on_faces(
        work.voxels, coupled.motions, law, history, &threads_,
        {.mobilized = is_given(coupled.body), .elements = !is_given(coupled.body)});
}

}  // namespace bsoil::bullet
