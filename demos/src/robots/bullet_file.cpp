#include "bullet_file.h"

#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletWorldImporter/btBulletWorldImporter.h>
#include <BulletWorldImporter/btMultiBodyWorldImporter.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "bullet_vectors.h"
#include "files/text_file.h"

namespace bsoil::scene {
namespace {

/// Bytes of a file.
constexpr size_t kBulletFileCapacity = size_t{256} << 20;

/// Bullet's importer, placing bodies where they are wanted.
template <typename Base>
class PlacingImporter final : public Base {
  public:
    template <typename World>
    PlacingImporter(World& world, const btTransform& pose) : Base(&world), pose_(pose) {}
    void setDynamicsWorldInfo(const btVector3&, const btContactSolverInfo&) override {}
    btRigidBody* createRigidBody(bool is_dynamic, btScalar mass_kg, const btTransform& start,
                                 btCollisionShape* shape, const char* name) override {
        return Base::createRigidBody(is_dynamic, mass_kg, pose_ * start, shape, name);
    }
    btCollisionObject* createCollisionObject(const btTransform& start, btCollisionShape* shape,
                                             const char* name) override {
        return Base::createCollisionObject(pose_ * start, shape, name);
    }

  private:
    btTransform pose_;
};

}  // namespace

Result<BulletFileContent> check_bullet_file(const std::string& path) {
    auto bytes = read_file(path, kBulletFileCapacity);
    if (!bytes) return Error{bytes.error()};
    auto content = check_bullet_bytes(*bytes);
    if (!content) return Error{path + ": " + content.error()};
    return content;
}

Result<std::unique_ptr<BulletFile>> BulletFile::load(const std::string& path,
                                                     btDiscreteDynamicsWorld& world,
                                                     const btTransform& pose) {
    auto bytes = read_file(path, kBulletFileCapacity);
    if (!bytes) return Error{bytes.error()};
    const auto content = check_bullet_bytes(*bytes);
    if (!content) return Error{path + ": " + content.error()};
    std::unique_ptr<BulletFile> file(new BulletFile);
    auto* multibody_world = dynamic_cast<btMultiBodyDynamicsWorld*>(&world);
    const int multibodies_before = multibody_world ? multibody_world->getNumMultibodies() : 0;
    file->multibody_world_ = multibody_world;
    if (multibody_world) {
        file->importer_ =
            std::make_unique<PlacingImporter<btMultiBodyWorldImporter>>(*multibody_world, pose);
    } else {
        file->importer_ = std::make_unique<PlacingImporter<btBulletWorldImporter>>(world, pose);
    }
    const bool is_loaded =
        file->importer_->loadFileFromMemory(bytes->data(), static_cast<int>(bytes->size()));
    if (multibody_world) {
        file->own_multibodies(multibodies_before);
        file->place_multibodies(pose);
    }
    if (!is_loaded) return Error{path + ": Bullet cannot read it; save it anew from Bullet"};

    btBulletWorldImporter& importer = *file->importer_;
    const bool is_moved = !(pose == btTransform::getIdentity());
    for (int i = 0; i < importer.getNumConstraints(); ++i) {
        const btTypedConstraint& c = *importer.getConstraintByIndex(i);
        if (is_moved && (&c.getRigidBodyA() == &btTypedConstraint::getFixedBody() ||
                         &c.getRigidBodyB() == &btTypedConstraint::getFixedBody())) {
            return Error{path +
                         ": a constraint holds a body to the world; such a file must "
                         "stay where it was saved"};
        }
    }
    std::set<std::string> taken;
    for (int i = 0; i < importer.getNumRigidBodies(); ++i) {
        btRigidBody* body = btRigidBody::upcast(importer.getRigidBodyByIndex(i));
        if (!body) continue;
        const char* own = importer.getNameForPointer(body);
        std::string name = own ? own : "";
        if (name.empty() || taken.contains(name)) name = std::to_string(file->bodies_.size());
        taken.insert(name);
        file->bodies_.push_back({name, body});
    }
    const auto compare = [&](const char* what, int in_file, int made) {
        if (made < in_file) {
            file->missing_.push_back(fmt::format("{}: {} of its {} {} are not in the world", path,
                                                 in_file - made, in_file, what));
        }
    };
    compare(
        "rigid bodies and collision objects (Bullet's importer drops heightfields and shapes "
        "of its host's own)",
        content->rigid_body_count + content->collision_object_count, importer.getNumRigidBodies());
    compare("constraints", content->constraint_count, importer.getNumConstraints());
    compare("multibodies", content->multibody_count, static_cast<int>(file->multibodies_.size()));
    compare("colliders of multibodies", content->link_collider_count,
            static_cast<int>(file->link_colliders_.size()));
    compare("soft bodies", content->soft_body_count, 0);
    return file;
}

namespace {

/// Appends a shape's surface. What is endless or has no triangles is left out.
void append_surface(const btCollisionShape& shape, const btTransform& pose, TriangleMesh& mesh) {
    const auto add = [&](const btVector3& point) {
        mesh.vertices.push_back(from_bullet(pose * point));
        return static_cast<int>(mesh.vertices.size()) - 1;
    };
    if (shape.isCompound()) {
        const auto& parts = static_cast<const btCompoundShape&>(shape);
        for (int i = 0; i < parts.getNumChildShapes(); ++i) {
            append_surface(*parts.getChildShape(i), pose * parts.getChildTransform(i), mesh);
        }
    } else if (shape.isConvex()) {
        btShapeHull hull(static_cast<const btConvexShape*>(&shape));
        if (!hull.buildHull(0)) return;
        const int first = static_cast<int>(mesh.vertices.size());
        for (int i = 0; i < hull.numVertices(); ++i) add(hull.getVertexPointer()[i]);
        const unsigned* corner = hull.getIndexPointer();
        for (int t = 0; t < hull.numTriangles(); ++t, corner += 3) {
            mesh.triangles.push_back({first + static_cast<int>(corner[0]),
                                      first + static_cast<int>(corner[1]),
                                      first + static_cast<int>(corner[2])});
        }
    } else if (shape.isConcave() && !shape.isInfinite()) {
        struct Collector final : btTriangleCallback {
            std::vector<btVector3> corners;
            void processTriangle(btVector3* triangle, int, int) override {
                corners.insert(corners.end(), triangle, triangle + 3);
            }
        } found;
        btVector3 low, high;
        shape.getAabb(btTransform::getIdentity(), low, high);
        static_cast<const btConcaveShape&>(shape).processAllTriangles(&found, low, high);
        for (size_t i = 0; i + 2 < found.corners.size(); i += 3) {
            const int a = add(found.corners[i]);
            const int b = add(found.corners[i + 1]);
            mesh.triangles.push_back({a, b, add(found.corners[i + 2])});
        }
    }
}

}  // namespace

Result<BulletFileSurvey> survey_bullet_file(const std::string& path) {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    const auto file = BulletFile::load(path, world);
    if (!file) return Error{file.error()};
    BulletFileSurvey survey;
    survey.has_multibodies = world.getNumMultibodies() > 0;
    survey.missing = (*file)->missing();
    for (const BulletFile::Body& body : (*file)->bodies()) {
        BulletFileBody& found = survey.bodies.emplace_back();
        found.name = body.name;
        const btScalar inverse_mass = body.body->getInvMass();
        if (inverse_mass > 0) found.mass_kg = 1 / static_cast<double>(inverse_mass);
        found.pose = from_bullet(body.body->getWorldTransform());
        append_surface(*body.body->getCollisionShape(), btTransform::getIdentity(), found.surface);
    }
    return survey;
}

BulletFile::BulletFile() = default;

BulletFile::~BulletFile() {
    for (const auto& collider : link_colliders_) {
        multibody_world_->removeCollisionObject(collider.get());
    }
    for (const auto& multibody : multibodies_) multibody_world_->removeMultiBody(multibody.get());
    if (importer_) importer_->deleteAllData();  // shapes too, which the colliders have
}

void BulletFile::own_multibodies(int first) {
    std::set<const btMultiBody*> own;
    for (int i = first; i < multibody_world_->getNumMultibodies(); ++i) {
        multibodies_.emplace_back(multibody_world_->getMultiBody(i));
        own.insert(multibodies_.back().get());
    }
    for (int i = 0; i < multibody_world_->getNumCollisionObjects(); ++i) {
        auto* collider =
            btMultiBodyLinkCollider::upcast(multibody_world_->getCollisionObjectArray()[i]);
        if (collider && own.contains(collider->m_multiBody)) link_colliders_.emplace_back(collider);
    }
}

void BulletFile::place_multibodies(const btTransform& pose) {
    const btQuaternion turn = pose.getRotation();
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> positions;
    for (const auto& multibody : multibodies_) {
        multibody->setBasePos(pose * multibody->getBasePos());
        multibody->setWorldToBaseRot(multibody->getWorldToBaseRot() * turn.inverse());
        multibody->setBaseVel(quatRotate(turn, multibody->getBaseVel()));
        multibody->setBaseOmega(quatRotate(turn, multibody->getBaseOmega()));
        multibody->forwardKinematics(rotations, positions);
        multibody->updateCollisionObjectWorldTransforms(rotations, positions);
    }
    // For rays and contacts before the world's next step.
    for (const auto& collider : link_colliders_) multibody_world_->updateSingleAabb(collider.get());
}

}  // namespace bsoil::scene
