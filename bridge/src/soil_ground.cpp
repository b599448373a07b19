#include "soil_ground.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <utility>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// Soil further than this below a body's box does not touch it [voxels]. Ours: its surface and its
/// voxels differ by one at most. Larger: triangles are handed out for nothing.
constexpr double kReachVoxels = 1;
/// Rolling on soil is resisted by a moment of the load times this arm [m] (times the body's
/// friction, as Bullet has it). Ours: a stone of the size of a fist sinks in by some millimetres,
/// and meets the soil about so far ahead. Larger: debris stops at once; smaller: it rolls about on
/// the bumps of the ground for long.
constexpr btScalar kRollingArmM = btScalar(0.03);
/// But no more than this share of a body's radius. Ours: the faces of a tetrahedron lie at a third
/// of its radius. Larger: Bullet holds small debris on its edges, where it creeps on for good;
/// smaller: pebbles roll on farther.
constexpr btScalar kRollingShare = btScalar(0.3);

}  // namespace

/// A rigid body, so that a btDefaultVehicleRaycaster accepts its hits.
class SoilGround::Object final : public btRigidBody {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    Object(SoilGround& ground, const Pose& pose)
        : btRigidBody(0, nullptr, &ground.shape_), ground_(&ground) {
        setWorldTransform(transform_to_bullet(pose));
        setInterpolationWorldTransform(getWorldTransform());
        setCollisionFlags(getCollisionFlags() | CF_STATIC_OBJECT | CF_DISABLE_VISUALIZE_OBJECT);
        setFriction(1);  // what a pair has is the product: the other body's
        setRollingFriction(ground.rolling_arm_m_);
        setSpinningFriction(ground.spinning_arm_m_);
        ask_for_pairs();
    }
    ~Object() override {
        if (ground_) ground_->object_ = nullptr;
    }
    void release() { ground_ = nullptr; }
    /// Else Bullet does not call checkCollideWithOverride.
    void ask_for_pairs() { m_checkCollideWith = true; }
    bool checkCollideWithOverride(const btCollisionObject* other) const override {
        // Bullet's soft bodies keep a copy of each triangle they have met: it would go stale.
        const bool collides = btRigidBody::checkCollideWithOverride(other) && ground_ &&
                              other->getInternalType() != CO_SOFT_BODY &&
                              !ground_->is_coupled_(*other);
        if (collides) ground_->fit_arms(*other);
        return collides;
    }

  private:
    SoilGround* ground_;
};

SoilGround::SoilGround(btDiscreteDynamicsWorld& world, GroundSurface& surface,
                       const GridFrame& frame, const SoilActionDef& options,
                       std::function<bool(const btCollisionObject&)> is_coupled)
    : world_(world),
      grid_to_world_(frame.grid_to_world),
      surface_(surface),
      shape_(surface_, frame.size[2] * frame.voxel_m),
      is_coupled_(std::move(is_coupled)) {
    rolling_arm_m_ = spinning_arm_m_ = kRollingArmM;
    object_ = new Object(*this, grid_to_world_);
    world_.addRigidBody(object_, options.ground_group, options.ground_mask);
}

SoilGround::~SoilGround() {
    if (!object_) return;
    object_->release();
    // Both the world's destructor and taking it out reset the handle.
    if (object_->getBroadphaseHandle()) world_.removeRigidBody(object_);
    delete object_;
}

btRigidBody* SoilGround::object() const { return object_; }

void SoilGround::fit_arms(const btCollisionObject& other) {
    btVector3 center;
    btScalar radius_m = 0;
    other.getCollisionShape()->getBoundingSphere(center, radius_m);
    const btScalar arm_m = std::min(kRollingArmM, kRollingShare * radius_m);
    // What the host has set stays.
    if (object_->getRollingFriction() == rolling_arm_m_) {
        object_->setRollingFriction(rolling_arm_m_ = arm_m);
    }
    if (object_->getSpinningFriction() == spinning_arm_m_) {
        object_->setSpinningFriction(spinning_arm_m_ = arm_m);
    }
}

void SoilGround::open_substep() {
    if (object_) object_->ask_for_pairs();
}

bool SoilGround::is_ground(const btCollisionObject& object) {
    const btCollisionShape* shape = object.getCollisionShape();
    return shape && shape->getShapeType() == FAST_CONCAVE_MESH_PROXYTYPE &&
           dynamic_cast<const GroundShape*>(shape);
}

void SoilGround::drop_stale_contacts() {
    if (!object_ || !object_->getBroadphaseHandle()) return;
    const btTransform to_grid = transform_to_bullet(grid_to_world_).inverse();
    const double reach_m = kReachVoxels * surface_.voxel_m();
    btDispatcher& dispatcher = *world_.getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        const bool is_first = manifold.getBody0() == object_;
        if (!is_first && manifold.getBody1() != object_) continue;
        const auto* other = is_first ? manifold.getBody1() : manifold.getBody0();
        const btBroadphaseProxy* proxy = other->getBroadphaseHandle();
        if (!proxy) continue;
        btVector3 low, high;
        btTransformAabb(proxy->m_aabbMin, proxy->m_aabbMax, 0, to_grid, low, high);
        const Vec3 from = from_bullet(low), to = from_bullet(high);
        // What the soil has begun to carry is not asked about any more, but its old contacts hold.
        // A pair keeps its manifold for as long as the boxes meet, if it has contacts or not.
        const bool is_stale =
            is_coupled_(*other)
                ? manifold.getNumContacts() > 0
                : surface_.has_changed(surface_.cell_at(from.x, from.y),
                                       surface_.cell_at(to.x, to.y), from.z - reach_m, to.z);
        if (!is_stale) continue;
        dispatcher.clearManifold(&manifold);
        other->activate();
    }
    surface_.forget_changes();
}

}  // namespace bsoil::bullet
