#include "../bridge/bullet_scene.h"
#include "robots/bullet_file.h"
#include "targets.h"

namespace bsoil::fuzz {
namespace {

using bullet::BulletScene;

/// A file with most of what Bullet writes: shapes of every kind, a compound, a mesh, constraints.
const std::vector<uint8_t>& good_bullet_file() {
    static const std::vector<uint8_t> kFile = [] {
        BulletScene s;
        auto& compound = static_cast<btCompoundShape&>(s.shape<btCompoundShape>());
        btTransform at = btTransform::getIdentity();
        for (const float side : {-1.0f, 1.0f}) {
            at.setOrigin({0.3f * side, 0, 0});
            compound.addChildShape(at, &s.shape<btBoxShape>(btVector3(0.1f, 0.1f, 0.1f)));
        }
        auto& hull = static_cast<btConvexHullShape&>(s.shape<btConvexHullShape>());
        for (int i = 0; i < 8; ++i) {
            hull.addPoint({i & 1 ? 0.2f : -0.2f, i & 2 ? 0.2f : -0.2f, i & 4 ? 0.2f : -0.2f});
        }
        btTriangleMesh triangles;
        triangles.addTriangle({-2, 0, -2}, {2, 0, -2}, {0, 0, 2});
        btBvhTriangleMeshShape ground(&triangles, true);
        btRigidBody& a = s.add_box(10, {0.3f, 0.2f, 0.1f}, {0, 1, 0});
        btRigidBody& b = s.add(5, hull, {0.8f, 1, 0});
        s.add(4, compound, {0, 2, 0});
        s.add(3, s.shape<btSphereShape>(btScalar(0.2)), {0, 3, 0});
        s.add(3, s.shape<btCapsuleShape>(btScalar(0.1), btScalar(0.3)), {1, 3, 0});
        s.add(3, s.shape<btCylinderShape>(btVector3(0.1f, 0.2f, 0.1f)), {2, 3, 0});
        s.add(3, s.shape<btConeShape>(btScalar(0.1), btScalar(0.3)), {3, 3, 0});
        s.add(0, s.shape<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), {0, -1, 0});
        s.add(0, ground, {0, 0, 0});
        btHingeConstraint hinge(a, b, {0.4f, 0, 0}, {-0.4f, 0, 0}, {0, 1, 0}, {0, 1, 0});
        btPoint2PointConstraint point(a, {0, 0.2f, 0});
        s.world->addConstraint(&hinge, true);
        s.world->addConstraint(&point);
        btMultiBody slider(1, 1, btVector3(1, 1, 1), false, false);
        slider.setupPrismatic(0, 10, btVector3(1, 1, 1), -1, btQuaternion::getIdentity(),
                              btVector3(0, 0, 1), btVector3(btScalar(0.5), 0, 0),
                              btVector3(0, 0, 0), true);
        slider.finalizeMultiDof();
        s.world->addMultiBody(&slider);
        btDefaultSerializer serializer;
        serializer.registerNameForPointer(&a, "box");
        s.world->serialize(&serializer);
        s.world->removeMultiBody(&slider);
        s.world->removeConstraint(&hinge);
        s.world->removeConstraint(&point);
        for (const auto& body : s.bodies) s.world->removeRigidBody(body.get());
        s.bodies.clear();
        const unsigned char* bytes = serializer.getBufferPointer();
        return std::vector<uint8_t>(bytes, bytes + serializer.getCurrentBufferSize());
    }();
    return kFile;
}

void load(const std::string& path, bool moved) {
    BulletScene s;
    btTransform pose = btTransform::getIdentity();
    if (moved) pose.setOrigin({1, 2, 3});
    const int before = s.world->getNumCollisionObjects();
    {
        const auto file = scene::BulletFile::load(path, *s.world, pose);
        if (file) {
            for (int i = 0; i < 2; ++i) s.world->stepSimulation(btScalar(1) / 60, 0);
        }
    }
    require(s.world->getNumCollisionObjects() == before, "a file's objects stay behind");
}

}  // namespace

void fuzz_bullet_file(Bytes bytes) {
    std::vector<uint8_t> file = good_bullet_file();
    Choices choices(bytes);
    const bool moved = choices.flag();
    if (!choices.at_end()) edit(file, choices);
    const std::string path = scratch_file("world.bullet", file);
    load(path, moved);
    // What a scene does with it before it runs.
    if (const auto survey = scene::survey_bullet_file(path)) {
        for (const scene::BulletFileBody& body : survey->bodies) {
            for (const auto& triangle : body.surface.triangles) {
                for (const int corner : triangle) {
                    require(
                        corner >= 0 && static_cast<size_t>(corner) < body.surface.vertices.size(),
                        "a surface has a triangle without vertices");
                }
            }
        }
    }
}

}  // namespace bsoil::fuzz
