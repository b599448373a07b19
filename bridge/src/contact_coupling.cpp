#include "contact_coupling.h"

#include <algorithm>
#include <cmath>

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// A tangential force below this fraction of the normal limit gives no direction to the tangential rows.
constexpr double kNoDirectionFraction = 1e-6;
/// Patches whose normals differ by more than this cosine are not the same contact.
constexpr double kSamePatchCosine = 0.5;

Vec3 tangential(Vec3 v, Vec3 normal) { return v - dot(v, normal) * normal; }

/// A unit vector across the normal: along the friction that acts, else along the sliding, else any.
Vec3 first_tangent(Vec3 normal, Vec3 friction_n, double limit_n, Vec3 slide_m_s) {
    if (length(friction_n) > kNoDirectionFraction * limit_n)
        return friction_n * (1 / length(friction_n));
    if (length(slide_m_s) > kCreepSpeedMS) return slide_m_s * (1 / length(slide_m_s));
    const Vec3 axis = std::abs(normal.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 t = tangential(axis, normal);
    return t * (1 / length(t));
}

}  // namespace

ContactCoupling::ContactCoupling(btDiscreteDynamicsWorld& world, Vec3 up,
                                 std::vector<SoilStrength> strengths, const SoilActionDef& options)
    : world_(world),
      multibody_world_(dynamic_cast<btMultiBodyDynamicsWorld*>(&world)),
      up_(up),
      strengths_(std::move(strengths)),
      wake_limit_fraction_(options.wake_limit_fraction),
      wake_weight_fraction_(options.wake_weight_fraction) {}

ContactCoupling::~ContactCoupling() = default;

void ContactCoupling::set_contacts(std::span<const BodyState> bodies,
                                   std::span<const ContactVoxel> contacts) {
    // The soil sorts contacts by voxel; a stable sort by body keeps that order within a body.
    by_body_.assign(contacts.begin(), contacts.end());
    std::stable_sort(by_body_.begin(), by_body_.end(),
                     [](const ContactVoxel& a, const ContactVoxel& b) { return a.body < b.body; });
    const auto voxels_of = [this](int id) {
        const auto first = std::partition_point(
            by_body_.begin(), by_body_.end(), [id](const ContactVoxel& v) { return v.body < id; });
        const auto last = std::partition_point(
            first, by_body_.end(), [id](const ContactVoxel& v) { return v.body == id; });
        return std::span<const ContactVoxel>(first, last);
    };

    for (auto& [id, coupled] : coupled_) coupled.seen = false;
    for (const BodyState& body : bodies) {
        const std::span<const ContactVoxel> voxels = voxels_of(body.id);
        if (voxels.empty() && !coupled_.contains(body.id)) continue;
        Coupled& coupled = coupled_[body.id];
        coupled.seen = true;
        if (coupled.body.role != body.role) {  // the host has turned it kinematic or back
            coupled.rigid_rows.clear();
            coupled.link_rows.reset();
            coupled.patches.clear();
        }
        coupled.body = body;
        set_body_contacts(coupled, voxels);
        wake_if_changed(coupled);
    }
    std::erase_if(coupled_, [](const auto& entry) { return !entry.second.seen; });
}

void ContactCoupling::set_body_contacts(Coupled& coupled, std::span<const ContactVoxel> voxels) {
    const BodyMotion& motion = coupled.body.motion;
    const BodyContact contact = group_contacts(voxels, motion, up_, strengths_, patches_);
    coupled.report.contact_area_m2 = contact.area_m2;
    coupled.report.sinkage_m = contact.depth_m;
    coupled.report.compression_m = contact.compression_m;
    coupled.report.patch_count = static_cast<int>(patches_.size());
    if (coupled.body.role == BodyRole::driven || coupled.body.role == BodyRole::fixed) {
        coupled.report.force_n = contact.mobilized_force_n;
        coupled.report.torque_n_m = contact.mobilized_torque_n_m;
        coupled.report.peak_force_n =
            std::max(coupled.report.peak_force_n, length(contact.mobilized_force_n));
        return;
    }
    if (patches_.empty()) coupled.report.force_n = coupled.report.torque_n_m = {};

    // A new patch takes over how much of its limit the nearest old one was using. Patches are numbered in the
    // body's frame, so on a spinning wheel the number says nothing about the place.
    previous_.swap(coupled.patches);
    coupled.patches.clear();
    double extent_m = 0;
    for (const ContactPatch& p : patches_)
        extent_m = std::max(extent_m, length(p.point_m - motion.center_of_mass_m));
    for (const ContactPatch& p : patches_) {
        CoupledPatch next;
        next.patch = p;
        next.offset_m = p.point_m - motion.center_of_mass_m;
        next.friction_normal_n = p.normal_limit_n;  // where there was none: it yields while it comes in
        double nearest = std::numeric_limits<double>::infinity();
        for (const CoupledPatch& old : previous_) {
            const double cosine = dot(old.patch.normal, p.normal);
            const Vec3 apart = old.offset_m - next.offset_m;
            const double distance = dot(apart, apart) + (1 - cosine) * extent_m * extent_m;
            if (cosine < kSamePatchCosine || distance >= nearest) continue;
            nearest = distance;
            const double scale = p.normal_limit_n / old.patch.normal_limit_n;
            next.friction_normal_n = std::min(1.0, scale) * old.friction_normal_n;
            next.applied_force_n = old.applied_force_n;
        }
        coupled.patches.push_back(next);
    }
}

void ContactCoupling::wake_if_changed(Coupled& coupled) {
    const BodyState& body = coupled.body;
    if (body.role != BodyRole::rigid && body.role != BodyRole::link) return;
    if (!body.is_asleep) {
        coupled.was_asleep = false;
        return;
    }
    std::array<double, kNormalBinCount> limits_n{};
    for (const CoupledPatch& p : coupled.patches) limits_n[p.patch.bin] += p.patch.normal_limit_n;
    if (!coupled.was_asleep) {
        coupled.was_asleep = true;
        coupled.limits_at_sleep_n = limits_n;
        return;
    }
    double change_n = 0, sum_n = 0;
    for (int bin = 0; bin < kNormalBinCount; ++bin) {
        change_n += std::abs(limits_n[bin] - coupled.limits_at_sleep_n[bin]);
        sum_n += coupled.limits_at_sleep_n[bin];
    }
    if (change_n <= wake_limit_fraction_ * sum_n + wake_weight_fraction_ * body.weight_n) return;
    coupled.was_asleep = false;
    if (body.role == BodyRole::link)
        static_cast<btMultiBodyLinkCollider*>(body.object)->m_multiBody->wakeUp();
    body.object->activate();
}

bool ContactCoupling::is_in_world(const BodyState& body) const {
    const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
    const int index = objects.findLinearSearch(body.object);
    if (index == objects.size()) return false;
    const btBroadphaseProxy* proxy = body.object->getBroadphaseHandle();
    return proxy && proxy->getUid() == body.proxy_id;
}

PatchRow ContactCoupling::row_of(const Coupled& coupled, const CoupledPatch& patch) const {
    const ContactPatch& p = patch.patch;
    const BodyMotion& motion = coupled.body.motion;
    const Vec3 slide = tangential(motion.velocity_at(p.point_m), p.normal);
    const Vec3 t = first_tangent(p.normal, tangential(patch.applied_force_n, p.normal),
                                 p.normal_limit_n, slide);
    PatchRow row;
    row.offset_m = to_bullet(patch.offset_m);
    row.normal = to_bullet(p.normal);
    row.tangent[0] = to_bullet(t);
    row.tangent[1] = to_bullet(cross(p.normal, t));
    row.normal_limit_n = static_cast<btScalar>(p.normal_limit_n);
    row.tangential_limit_n = static_cast<btScalar>(p.friction * patch.friction_normal_n);
    return row;
}

void ContactCoupling::open_substep() {
    take_rows_out();
    for (auto& [id, coupled] : coupled_) {
        if (coupled.patches.empty() || !is_in_world(coupled.body)) continue;
        open(coupled);
        opened_.push_back(id);
    }
}

void ContactCoupling::open(Coupled& coupled) {
    if (coupled.body.role == BodyRole::rigid) {
        btRigidBody& body = *static_cast<btRigidBody*>(coupled.body.object);
        for (size_t i = 0; i < coupled.patches.size(); ++i) {
            if (i == coupled.rigid_rows.size())
                coupled.rigid_rows.push_back(std::make_unique<RigidPatchConstraint>(body));
            coupled.rigid_rows[i]->row = row_of(coupled, coupled.patches[i]);
            world_.addConstraint(coupled.rigid_rows[i].get());
        }
    } else {
        auto& collider = *static_cast<btMultiBodyLinkCollider*>(coupled.body.object);
        if (!coupled.link_rows) coupled.link_rows = std::make_unique<LinkPatchConstraint>(collider);
        coupled.link_rows->rows.clear();
        for (const CoupledPatch& patch : coupled.patches)
            coupled.link_rows->rows.push_back(row_of(coupled, patch));
        multibody_world_->addMultiBodyConstraint(coupled.link_rows.get());
    }
    coupled.is_open = true;
}

void ContactCoupling::close(Coupled& coupled) {
    coupled.is_open = false;
    if (coupled.body.role == BodyRole::rigid) {
        // Last in, first out: Bullet fills a gap with its last constraint and would reorder the host's.
        for (size_t i = coupled.patches.size(); i-- > 0;)
            world_.removeConstraint(coupled.rigid_rows[i].get());
    } else {
        multibody_world_->removeMultiBodyConstraint(coupled.link_rows.get());
    }
}

void ContactCoupling::take_rows_out() {
    for (; !opened_.empty(); opened_.pop_back()) close(coupled_.at(opened_.back()));
}

void ContactCoupling::close_substep(btScalar substep_s) {
    for (const int id : opened_) {
        Coupled& coupled = coupled_.at(id);
        Vec3 force, torque;
        bool solved = true;
        for (size_t i = 0; i < coupled.patches.size(); ++i) {
            CoupledPatch& patch = coupled.patches[i];
            if (coupled.body.role == BodyRole::rigid) {
                RigidPatchConstraint& row = *coupled.rigid_rows[i];
                solved = row.take_solved();
                if (!solved) break;
                patch.applied_force_n = from_bullet(row.applied_force_n());
                torque += from_bullet(row.applied_torque_n_m());
            } else {
                if (i == 0) solved = coupled.link_rows->take_solved();
                if (!solved) break;
                patch.applied_force_n = from_bullet(
                    coupled.link_rows->applied_force_n(static_cast<int>(i), substep_s));
                torque += cross(patch.offset_m, patch.applied_force_n);
            }
            patch.friction_normal_n =
                std::max(0.0, -dot(patch.applied_force_n, patch.patch.normal));
            force += patch.applied_force_n;
        }
        if (!solved) continue;  // asleep: what held it when it fell asleep still does
        coupled.report.force_n = force;
        coupled.report.torque_n_m = torque;
        coupled.report.peak_force_n = std::max(coupled.report.peak_force_n, length(force));
    }
    take_rows_out();
}

BodyReport ContactCoupling::report(int body_id) const {
    const auto found = coupled_.find(body_id);
    return found == coupled_.end() ? BodyReport{} : found->second.report;
}

}  // namespace bsoil::bullet
