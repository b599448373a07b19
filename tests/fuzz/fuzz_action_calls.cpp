#include <cmath>

#include "../bridge/bullet_scene.h"
#include "bsoil/bullet/soil_action.h"
#include "targets.h"

namespace bsoil::fuzz {
namespace {

btVector3 bullet_vector(Choices& c, double reach) {
    const double x = c.number(-reach, reach), y = c.number(-reach, reach),
                 z = c.number(-reach, reach);
    return {btScalar(x), btScalar(y), btScalar(z)};
}

/// Bullet's own arithmetic overflows beyond, and asserts nothing.
bool is_tame(const btVector3& v) {
    return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z()) && v.length() < 1e6;
}
double size(Choices& c) { return 0.02 + std::min(5.0, std::abs(c.number(0, 0.5))); }

/// A world with a soil and whatever calls put into it.
class ActionCaller {
  public:
    explicit ActionCaller(Choices& choices) : c_(choices) {
        SoilDef def;
        def.backend = Backend::cpu;
        def.thread_count = 1;
        def.voxel_m = 0.1;
        def.size_m = {0.1 * (1 + c_.below(24)), 0.1 * (1 + c_.below(16)), 0.1 * (1 + c_.below(24))};
        def.yaw_rad = c_.flag() ? 0.3 : 0;
        // A piece a call where the soil is flat; no byte of its own, so that seeds stay as they
        // are.
        if (def.size_m.y < 0.25) def.step_budget_ms = 1e-6;
        bullet::SoilActionDef options;
        options.ground = c_.flag();
        auto made = bullet::SoilAction::create(*s_.world, def, options);
        require(made.ok(), "no soil");
        soil_ = std::move(*made);
        const double top = 0.1 * c_.below(16);
        static_cast<void>(soil_->fill(BoxFill{{{-3, 0, -3}, {3, top, 3}}, ""}));
        units_ = soil_->soil().totals().units;
    }
    void run() {
        for (int i = 0; i < 30 && !c_.at_end(); ++i) call();
        step();
        if (c_.flag()) soil_.reset();  // before or after the bodies
    }

  private:
    btCollisionShape& shape(int depth) {
        switch (c_.below(depth > 0 ? 9 : 7)) {
            case 0:
                return s_.shape<btBoxShape>(
                    btVector3(btScalar(size(c_)), btScalar(size(c_)), btScalar(size(c_))));
            case 1:
                return s_.shape<btSphereShape>(btScalar(size(c_)));
            case 2:
                return s_.shape<btCapsuleShapeZ>(btScalar(size(c_)), btScalar(size(c_)));
            case 3:
                return s_.shape<btCylinderShapeX>(
                    btVector3(btScalar(size(c_)), btScalar(size(c_)), btScalar(size(c_))));
            case 4:
                return s_.shape<btConeShape>(btScalar(size(c_)), btScalar(size(c_)));
            case 5: {
                auto& hull = static_cast<btConvexHullShape&>(s_.shape<btConvexHullShape>());
                for (int i = 0; i < 4 + c_.below(8); ++i) {
                    if (const btVector3 p = bullet_vector(c_, 0.5); is_tame(p)) hull.addPoint(p);
                }
                if (hull.getNumPoints() == 0) hull.addPoint({0, 0, 0});
                return hull;
            }
            case 6: {
                meshes_.push_back(std::make_unique<btTriangleMesh>());
                for (int i = 0; i < 1 + c_.below(8); ++i) {
                    const btVector3 a = bullet_vector(c_, 1), b = bullet_vector(c_, 1),
                                    d = bullet_vector(c_, 1);
                    if (is_tame(a) && is_tame(b) && is_tame(d)) {
                        meshes_.back()->addTriangle(a, b, d);
                    }
                }
                if (meshes_.back()->getNumTriangles() == 0) {
                    meshes_.back()->addTriangle({0, 0, 0}, {1, 0, 0}, {0, 0, 1});
                }
                return s_.shape<btBvhTriangleMeshShape>(meshes_.back().get(), true);
            }
            default: {
                auto& compound = static_cast<btCompoundShape&>(s_.shape<btCompoundShape>());
                for (int i = 0; i < c_.below(4); ++i) {
                    btTransform at = btTransform::getIdentity();
                    if (const btVector3 p = bullet_vector(c_, 0.5); is_tame(p)) at.setOrigin(p);
                    compound.addChildShape(at, &shape(depth - 1));
                }
                return compound;
            }
        }
    }

    void call() {
        switch (c_.below(10)) {
            case 0:
                if (s_.bodies.size() < 6) add_body();
                return;
            case 1:
                if (!s_.bodies.empty()) {
                    s_.remove(*s_.bodies[static_cast<size_t>(c_.below(int(s_.bodies.size())))]);
                }
                return;
            case 2:
                return move_body();
            case 3: {
                bullet::BodyOptions options{
                    c_.flag(), c_.flag(), {c_.number(-1, 2), c_.number(-1, 1e5)}};
                if (btRigidBody* body = any()) {
                    static_cast<void>(soil_->set_options(*body, options));
                    soil_->body_report(*body);
                    soil_->body_id(*body);
                }
                return;
            }
            case 4:
                soil_->set_enabled(c_.flag());
                return;
            case 5:
                return look();
            case 6:
                return save_and_load();
            default:
                return step();
        }
    }

    btRigidBody* any() {
        if (s_.bodies.empty()) return nullptr;
        return s_.bodies[static_cast<size_t>(c_.below(static_cast<int>(s_.bodies.size())))].get();
    }

    void add_body() {
        btCollisionShape& form = shape(2);
        const bool moves = form.isConvex() || (form.isCompound() && !has_mesh(form));
        const btVector3 at = bullet_vector(c_, 1.5);
        btRigidBody& body = s_.add(moves && c_.below(4) != 0 ? btScalar(size(c_) * 100) : 0, form,
                                   is_tame(at) ? at : btVector3(0, 1, 0));
        if (c_.below(6) == 0) {
            body.setCollisionFlags(body.getCollisionFlags() |
                                   btCollisionObject::CF_KINEMATIC_OBJECT);
            body.setActivationState(DISABLE_DEACTIVATION);
        }
    }
    static bool has_mesh(const btCollisionShape& form) {
        if (!form.isCompound()) return !form.isConvex();
        const auto& compound = static_cast<const btCompoundShape&>(form);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            if (has_mesh(*compound.getChildShape(i))) return true;
        }
        return false;
    }

    void move_body() {
        btRigidBody* body = any();
        if (!body) return;
        const btVector3 at = bullet_vector(c_, 2), linear = bullet_vector(c_, 20),
                        angular = bullet_vector(c_, 20);
        if (!is_tame(at) || !is_tame(linear) || !is_tame(angular)) return;
        btTransform pose = body->getWorldTransform();
        pose.setOrigin(at);
        body->setWorldTransform(pose);
        body->setLinearVelocity(linear);
        body->setAngularVelocity(angular);
        body->activate();
    }

    void look() {
        const btVector3 at = bullet_vector(c_, 2);
        static_cast<void>(soil_->surface_at({at.x(), at.y(), at.z()}));
        if (is_tame(at)) {
            const btVector3 from = at + btVector3(0.1f, 3, 0.1f), to = at - btVector3(0.2f, 3, 0);
            btCollisionWorld::ClosestRayResultCallback hit(from, to);
            s_.world->rayTest(from, to, hit);
        }
        soil_->refused();
        soil_->last_report();
    }

    void save_and_load() {
        const std::string path = scratch_path("calls.snapshot");
        if (!soil_->save(path)) return;
        const uint64_t checksum = soil_->soil().checksum();
        const Status loaded = soil_->load(path);
        if (!loaded) fail("a snapshot just written is refused: " + loaded.error());
        require(soil_->soil().checksum() == checksum, "a snapshot comes back as another soil");
    }

    void step() {
        s_.world->stepSimulation(btScalar(1) / 60, c_.below(3), btScalar(1) / 60);
        require(soil_->soil().totals().units == units_, "soil is not conserved");
    }

    Choices& c_;
    std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
    bullet::BulletScene s_;
    std::unique_ptr<bullet::SoilAction> soil_;
    std::vector<int64_t> units_;
};

}  // namespace

void fuzz_action_calls(Bytes bytes) { run_calls<ActionCaller>(bytes); }

}  // namespace bsoil::fuzz
