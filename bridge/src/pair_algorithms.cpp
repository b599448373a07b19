#include "pair_algorithms.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <vector>

#include "soil_ground.h"

namespace bsoil::bullet {
namespace {

/// While it lives, an object counts as awake: algorithms for two sleepers come without a manifold.
class Awake {
  public:
    explicit Awake(btCollisionObject& object)
        : object_(object), state_(object.getActivationState()) {
        object_.forceActivationState(ACTIVE_TAG);
    }
    ~Awake() { object_.forceActivationState(state_); }
    Awake(const Awake&) = delete;
    Awake& operator=(const Awake&) = delete;

  private:
    btCollisionObject& object_;
    int state_;
};

/// In place of a soil's ground while algorithms are made: in reading, the soil is not that of the
/// snapshot yet, and a GImpact shape has a manifold only where it meets a triangle. This one hands
/// out a triangle that spans whatever box is asked for.
class AnyGround final : public btConcaveShape {
  public:
    explicit AnyGround(const btCollisionShape& ground) : ground_(ground) {
        m_shapeType = ground.getShapeType();
    }
    void processAllTriangles(btTriangleCallback* callback, const btVector3& low,
                             const btVector3& high) const override {
        btVector3 corners[] = {low, high, {low.x(), high.y(), low.z()}};
        callback->processTriangle(corners, 0, 0);
    }
    void getAabb(const btTransform& pose, btVector3& low, btVector3& high) const override {
        ground_.getAabb(pose, low, high);
    }
    void setLocalScaling(const btVector3&) override {}
    const btVector3& getLocalScaling() const override { return ground_.getLocalScaling(); }
    void calculateLocalInertia(btScalar, btVector3& inertia) const override {
        inertia.setValue(0, 0, 0);
    }
    const char* getName() const override { return ground_.getName(); }

  private:
    const btCollisionShape& ground_;
};

/// Takes none of what is found: with such a ground they are no contacts.
class NoContacts final : public btManifoldResult {
  public:
    using btManifoldResult::btManifoldResult;
    void addContactPoint(const btVector3&, const btVector3&, btScalar) override {}
};

/// Whether a pair's algorithm keeps nothing but the points of its one manifold.
bool keeps_points_only(const btCollisionObject& object) {
    const btCollisionShape& shape = *object.getCollisionShape();
    return shape.isConvex() || shape.getShapeType() == STATIC_PLANE_PROXYTYPE;
}

btCollisionObject& object_of(const btBroadphaseProxy* proxy) {
    return *static_cast<btCollisionObject*>(proxy->m_clientObject);
}

}  // namespace

btManifoldArray manifolds_of(const btBroadphasePair& pair) {
    btManifoldArray manifolds;
    if (pair.m_algorithm) pair.m_algorithm->getAllContactManifolds(manifolds);
    return manifolds;
}

void make_algorithm(btDiscreteDynamicsWorld& world, btBroadphasePair& pair) {
    btCollisionObject &a = object_of(pair.m_pProxy0), &b = object_of(pair.m_pProxy1);
    const Awake a_awake(a), b_awake(b);
    const bool is_ground_a = SoilGround::is_ground(a), is_ground_b = SoilGround::is_ground(b);
    const AnyGround ground_a(*a.getCollisionShape()), ground_b(*b.getCollisionShape());
    const btCollisionObjectWrapper wrap_a(nullptr, is_ground_a ? &ground_a : a.getCollisionShape(),
                                          &a, a.getWorldTransform(), -1, -1);
    const btCollisionObjectWrapper wrap_b(nullptr, is_ground_b ? &ground_b : b.getCollisionShape(),
                                          &b, b.getWorldTransform(), -1, -1);
    pair.m_algorithm = world.getDispatcher()->findAlgorithm(&wrap_a, &wrap_b, nullptr,
                                                            BT_CONTACT_POINT_ALGORITHMS);
    if (!pair.m_algorithm) return;
    btManifoldResult contacts(&wrap_a, &wrap_b);
    NoContacts none(&wrap_a, &wrap_b);
    pair.m_algorithm->processCollision(&wrap_a, &wrap_b, world.getDispatchInfo(),
                                       is_ground_a || is_ground_b ? &none : &contacts);
}

void renew_algorithm(btDiscreteDynamicsWorld& world, btBroadphasePair& pair) {
    const btCollisionObject &a = object_of(pair.m_pProxy0), &b = object_of(pair.m_pProxy1);
    if (!pair.m_algorithm || (keeps_points_only(a) && keeps_points_only(b))) return;
    std::vector<std::vector<btManifoldPoint>> points;
    const btManifoldArray before = manifolds_of(pair);
    for (int m = 0; m < before.size(); ++m) {
        points.emplace_back();
        for (int i = 0; i < before[m]->getNumContacts(); ++i) {
            points.back().push_back(before[m]->getContactPoint(i));
            points.back().back().m_userPersistentData = nullptr;
        }
    }
    world.getPairCache()->cleanOverlappingPair(pair, world.getDispatcher());
    make_algorithm(world, pair);
    const btManifoldArray after = manifolds_of(pair);
    // Others than before: then what they had of impulses is lost.
    if (static_cast<size_t>(after.size()) != points.size()) return;
    for (int m = 0; m < after.size(); ++m) {
        after[m]->clearManifold();
        after[m]->setNumContacts(static_cast<int>(points[static_cast<size_t>(m)].size()));
        for (int i = 0; i < after[m]->getNumContacts(); ++i) {
            after[m]->getContactPoint(i) = points[static_cast<size_t>(m)][static_cast<size_t>(i)];
        }
    }
}

}  // namespace bsoil::bullet
