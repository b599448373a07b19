// MotorDemo: a body on six legs of a thigh and a shin, hinged and driven by motors.
#include <numbers>

#include "example.h"

namespace bsoil::bullet::hexapod_test {
namespace {

class Hexapod : public Example {
  public:
    explicit Hexapod(Ground ground) : Example(ground, {.side_m = 4, .depth_m = 0.5}) { build(); }

    static constexpr int kLegs = 6;
    static constexpr double kBodyM = 0.25, kThighM = 0.45, kShinM = 0.75;

    void build() {
        const btScalar height(0.5);
        body_ = &add(1, scene_.shape<btCapsuleShape>(btScalar(kBodyM), btScalar(0.1)),
                     btTransform(btQuaternion::getIdentity(), btVector3(0, height, 0)));
        btCollisionShape& thigh_shape =
            scene_.shape<btCapsuleShape>(btScalar(0.1), btScalar(kThighM));
        btCollisionShape& shin_shape =
            scene_.shape<btCapsuleShape>(btScalar(0.08), btScalar(kShinM));
        constexpr auto kQuarter = btScalar(std::numbers::pi / 4);
        for (int i = 0; i < kLegs; ++i) {
            const double angle = 2 * std::numbers::pi * i / kLegs;
            const btVector3 out(btScalar(std::cos(angle)), 0, btScalar(std::sin(angle)));
            const btVector3 thigh_at =
                btScalar(kBodyM + 0.5 * kThighM) * out + btVector3(0, height, 0);
            const btVector3 knee = btScalar(kBodyM + kThighM) * out + btVector3(0, height, 0);
            const btVector3 axis = out.cross(btVector3(0, 1, 0)).normalized();
            const btTransform thigh_pose(btQuaternion(axis, SIMD_HALF_PI), thigh_at);
            const btTransform shin_pose(btQuaternion::getIdentity(),
                                        knee - btVector3(0, btScalar(0.5 * kShinM), 0));
            btRigidBody& thigh = add(1, thigh_shape, thigh_pose);
            btRigidBody& shin = add(1, shin_shape, shin_pose);
            hinge(*body_, thigh, btScalar(kBodyM) * out + btVector3(0, height, 0), out,
                  -0.75f * kQuarter, kQuarter / 2);
            hinge(thigh, shin, knee, out, -kQuarter / 2, btScalar(0.2));
        }
        for (const auto& part : scene_.bodies) {
            part->setDamping(btScalar(0.05), btScalar(0.85));
            part->setDeactivationTime(btScalar(0.8));
            part->setSleepingThresholds(btScalar(0.5), btScalar(0.5));
        }
    }
    void hinge(btRigidBody& a, btRigidBody& b, const btVector3& at, const btVector3& out,
               btScalar low, btScalar high) {
        // The hinge's axis, z of its frame, is level and across the leg.
        const btVector3 z = out.cross(btVector3(0, 1, 0)).normalized();
        const btVector3 y = z.cross(out);
        const btTransform frame(
            btMatrix3x3(out.x(), y.x(), z.x(), out.y(), y.y(), z.y(), out.z(), y.z(), z.z()), at);
        auto made = std::make_unique<btHingeConstraint>(
            a, b, a.getWorldTransform().inverse() * frame, b.getWorldTransform().inverse() * frame);
        made->setLimit(low, high);
        hinges_.push_back(&join(std::move(made)));
    }
    /// As the demo has it: towards the target angle of a cycle of 2 s, all legs alike.
    void drive(int frame) {
        const double phase = std::fmod(frame / 60.0, 2.0) / 2.0;
        const double share = 0.5 * (1 + std::sin(2 * std::numbers::pi * phase));
        for (btHingeConstraint* h : hinges_) {
            const btScalar range = h->getUpperLimit() - h->getLowerLimit();
            const btScalar target = h->getLowerLimit() + btScalar(share) * range;
            h->enableAngularMotor(true, 60 * (target - h->getHingeAngle()), btScalar(0.5));
        }
    }

    double widest_gap_m() const {
        double widest = 0;
        for (const btHingeConstraint* hinge : hinges_) widest = std::max(widest, gap_m(*hinge));
        return widest;
    }
    void let_go() {
        for (btHingeConstraint* hinge : hinges_) hinge->enableMotor(false);
    }
    const btVector3& place() const { return body_->getWorldTransform().getOrigin(); }

  private:
    btRigidBody* body_ = nullptr;
    std::vector<btHingeConstraint*> hinges_;
};

/// Trodden for 5 s, then left alone.
struct Walk {
    Course driven, left;
    double widest_m = 0;
};
Walk tread(Hexapod& hexapod) {
    Walk out;
    int frame = 0;
    out.driven = hexapod.watch(5, [&] {
        hexapod.drive(frame++);
        out.widest_m = std::max(out.widest_m, hexapod.widest_gap_m());
    });
    hexapod.let_go();
    out.left = hexapod.watch(10);
    return out;
}

TEST(MotorDemo, hexapod_treads_the_sand_and_rests_when_it_is_left) {
    Hexapod rigid(Ground::rigid), sand(Ground::sand);
    const Walk on_rigid = tread(rigid), on_sand = tread(sand);
    EXPECT_LT(on_sand.widest_m, on_rigid.widest_m) << "the joints hold better than on rigid ground";
    EXPECT_LT(on_sand.driven.top_speed_m_s, on_rigid.driven.top_speed_m_s) << "it is not thrown";
    EXPECT_LT(on_sand.driven.risen_j, on_rigid.driven.risen_j) << "it jumps less high";
    EXPECT_LT(on_sand.driven.unbalanced_n, 0.02 * sand.weight_n());
    sand.expect_work(on_sand.driven, 2700, 2);  // measured: 2,180 and 1.57
    EXPECT_LT(std::hypot(sand.place().x(), sand.place().z()), 0.1f) << "legs alike go nowhere";
    EXPECT_LT(on_rigid.left.slept_s, 5);
    EXPECT_LT(on_sand.left.slept_s, 5);
    EXPECT_GT(sand.place().y(), btScalar(0.1)) << "it lies on the sand";
}

}  // namespace
}  // namespace bsoil::bullet::hexapod_test
