#include "world_anchor.h"

#include <BulletCollision/CollisionShapes/btEmptyShape.h>

#include <utility>

namespace bsoil::bullet {
class WorldAnchor::Object final : public btCollisionObject {
    /// An empty shape that tells when it is asked for its box.
    class WatchedShape final : public btEmptyShape {
      public:
        explicit WatchedShape(std::function<void()> on_box) : on_box_(std::move(on_box)) {}
        void getAabb(const btTransform& pose, btVector3& low, btVector3& high) const override {
            low = high = pose.getOrigin();
            on_box_();
        }

      private:
        std::function<void()> on_box_;
    };

  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    Object(WorldAnchor& anchor, const btVector3& position)
        : anchor_(&anchor), shape_([this] {
              if (anchor_ && anchor_->listening_) anchor_->on_open_();
          }) {
        setCollisionShape(&shape_);
        setCollisionFlags(CF_STATIC_OBJECT | CF_NO_CONTACT_RESPONSE | CF_DISABLE_VISUALIZE_OBJECT);
        // Bullet may be told to update the boxes of active objects only.
        forceActivationState(DISABLE_DEACTIVATION);
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(position);
        setWorldTransform(pose);
    }
    ~Object() override {
        if (!anchor_) return;
        anchor_->object_ = nullptr;
        anchor_->listening_ = false;
        anchor_->on_deleted_();
    }
    void release() { anchor_ = nullptr; }
    const GridFrame* grid() const { return anchor_ ? &anchor_->grid_ : nullptr; }

  private:
    WorldAnchor* anchor_;
    WatchedShape shape_;
};

WorldAnchor::WorldAnchor(btCollisionWorld& world, const btVector3& position,
                         std::function<void()> on_open, std::function<void()> on_deleted,
                         const GridFrame& grid)
    : world_(world),
      position_(position),
      grid_(grid),
      on_open_(std::move(on_open)),
      on_deleted_(std::move(on_deleted)) {
    ensure_in_world();
}

WorldAnchor::~WorldAnchor() {
    if (!object_) return;
    object_->release();
    if (object_->getBroadphaseHandle()) world_.removeCollisionObject(object_);
    delete object_;
}

bool WorldAnchor::world_exists() const {
    // removeCollisionObject resets both; the destructor of the world the handle only.
    return !object_ || object_->getBroadphaseHandle() || object_->getWorldArrayIndex() < 0;
}

void WorldAnchor::ensure_in_world() {
    if (!object_) object_ = new Object(*this, position_);
    if (object_->getBroadphaseHandle()) return;
    listening_ = false;  // adding asks for the box
    world_.addCollisionObject(object_, 0, 0);
    listening_ = true;
}

const btCollisionObject* WorldAnchor::object() const { return object_; }

const GridFrame* WorldAnchor::grid_of(const btCollisionObject& object) {
    const btCollisionShape* shape = object.getCollisionShape();
    if (!shape || shape->getShapeType() != EMPTY_SHAPE_PROXYTYPE) return nullptr;
    const auto* anchor = dynamic_cast<const Object*>(&object);
    return anchor ? anchor->grid() : nullptr;
}

}  // namespace bsoil::bullet
