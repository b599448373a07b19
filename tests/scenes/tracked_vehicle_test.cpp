/// The crawler of demos/scenes/tracked.toml, measured against its weight, the speed of its tracks,
/// Coulomb's limit and a wheeled machine.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reading/scene_load.h"
#include "run/scene_run.h"

namespace bsoil::scene::tracked_vehicle_test {
namespace {

constexpr double kSurfaceM = 0.4;  ///< of the scene's sand
constexpr double kSprocketRadS = 2;
/// Sprocket radius and half a link's thickness: the pins' way round it.
constexpr double kPitchLineM = 0.24;
constexpr double kStartS = 1;  ///< the tracks start to move

bool is_link(const SceneBody& body) { return body.name.find("/link_") != std::string::npos; }

double weight_n(const Scene& scene) {
    double mass_kg = 0;
    for (const BodyItem& body : scene.bodies) mass_kg += body.mass_kg;
    return mass_kg * scene.world.gravity_m_s2;
}

/// The scene with its own motions replaced: both tracks start at kStartS and reach their speed in
/// half a second.
Scene crawler(double duration_s) {
    auto scene = load_scene(std::string(BSOIL_SCENES_DIR) + "/tracked.toml");
    EXPECT_TRUE(scene) << scene.error();
    if (!scene) return {};
    scene->motions.clear();
    scene->checks.clear();
    for (const char* track : {"left", "right"}) {
        MotionItem motion;
        motion.joint = fmt::format("{}/sprocket", track);
        motion.interpolation = "linear";
        for (const auto& [t_s, rad_s] : {std::pair{kStartS, 0.0}, {kStartS + 0.5, kSprocketRadS}}) {
            MotionKey key;
            key.t_s = t_s;
            key.velocity_rad_s = rad_s;
            motion.motion_keys.push_back(key);
        }
        scene->motions.push_back(motion);
    }
    scene->world.duration_s = duration_s;
    return *scene;
}

/// A run of a scene, and the mean of the soil's forces since the last reset.
class Measured {
  public:
    explicit Measured(const Scene& scene) : scene_(scene) {
        auto run = SceneRun::create(scene_, {.backend = Backend::cpu});
        EXPECT_TRUE(run) << run.error();
        if (run) run_ = std::move(*run);
    }
    void run_to(double time_s) {
        while (run_->time_s() < time_s - run_->step_s() / 2) {
            run_->step();
            ++step_count_;
            const auto& bodies = run_->bullet().bodies();
            for (size_t i = 0; i < bodies.size(); ++i) {
                const Vec3 force_n = run_->readings()[i].force_n;
                sum_n_ += force_n;
                if (is_link(bodies[i])) (bodies[i].name[0] == 'l' ? left_n_ : right_n_) += force_n;
            }
        }
    }
    void reset() {
        sum_n_ = left_n_ = right_n_ = {};
        step_count_ = 0;
    }
    Vec3 force_n() const { return sum_n_ * (1.0 / step_count_); }
    Vec3 left_n() const { return left_n_ * (1.0 / step_count_); }
    Vec3 right_n() const { return right_n_ * (1.0 / step_count_); }
    SceneRun& run() { return *run_; }
    const SceneBody& body(const std::string& name) const { return *run_->bullet().find_body(name); }

  private:
    Scene scene_;
    std::unique_ptr<SceneRun> run_;
    Vec3 sum_n_, left_n_, right_n_;
    int step_count_ = 0;
};

/// Sinkage of the links' plates, without grousers: mean of those on the ground.
double plate_sinkage_m(const BulletScene& world) {
    double sum_m = 0;
    int count = 0;
    for (const SceneBody& body : world.bodies()) {
        const Pose pose = body.pose();
        // Level, and on the lower side.
        if (!is_link(body) || rotate(pose.rotation, {0, 0, 1}).z < 0.98) continue;
        sum_m += kSurfaceM - (pose.position.z - body.item->parts[0].size_m.z / 2);
        ++count;
    }
    EXPECT_GE(count, 16);
    return sum_m / count;
}

TEST(TrackedVehicle, stands_on_all_its_links) {
    Scene scene = crawler(kStartS);
    Measured crawler(scene);
    crawler.run_to(0.5);
    crawler.reset();
    crawler.run_to(kStartS);
    // The soil carries the weight, half of it on each track.
    const double w_n = weight_n(scene);
    EXPECT_NEAR(crawler.force_n().z, w_n, 0.02 * w_n);
    EXPECT_NEAR(crawler.left_n().z, crawler.right_n().z, 0.08 * w_n);
    int carrying = 0;
    for (size_t i = 0; i < crawler.run().readings().size(); ++i) {
        carrying += is_link(crawler.run().bullet().bodies()[i]) &&
                    crawler.run().readings()[i].force_n.z > 0.002 * w_n;
    }
    EXPECT_GE(carrying, 12);  // of 16 to 20 that lie flat
}

/// How a vehicle that nothing tows drives, from 2 to 4 s.
struct Drive {
    double slip = 0, aside_m = 0, yaw = 0;
};

Drive driven(Measured& crawler) {
    crawler.run_to(2);
    const Vec3 from = crawler.body("hull").pose().position;
    const double turned_from = crawler.run().bullet().joints()[0].position;
    crawler.run_to(4);
    const Pose to = crawler.body("hull").pose();
    const double track_m =
        kPitchLineM * (crawler.run().bullet().joints()[0].position - turned_from);
    EXPECT_NEAR(track_m, kPitchLineM * kSprocketRadS * 2, 0.05);  // the motor keeps its speed
    return {1 - (to.position.x - from.x) / track_m, std::abs(to.position.y),
            std::abs(rotate(to.rotation, {1, 0, 0}).y)};
}

// A link now and then catches under the idler, and its track slips by a tenth for a while; a change
// of any kind decides in which runs: in 2 to 4 of the 15 numbers of iterations 25, 28 .. 67, whose
// middle is 0.016. So what counts is the middle of every third of them. Then slip has to give the
// motion resistance only, 1 to 2 %.
TEST(SlowTrackedVehicle, drives_straight_without_slip) {
    std::vector<double> slips, asides_m, yaws;
    for (const int iterations : {25, 43, 52}) {
        SCOPED_TRACE(iterations);
        Scene scene = crawler(4);
        scene.world.solver_iterations = iterations;
        Measured crawler(scene);
        const Drive drive = driven(crawler);
        slips.push_back(drive.slip);
        asides_m.push_back(drive.aside_m);
        yaws.push_back(drive.yaw);
        if (iterations != 52) continue;
        // Ruts behind both tracks, none between.
        const Soil& soil = crawler.run().soil();
        for (const double y : {-0.55, 0.55}) {
            EXPECT_LT(surface_height_m(soil, {-2.2, y, 0}), kSurfaceM - 0.01);
            EXPECT_GT(surface_height_m(soil, {-2.2, y, 0}), kSurfaceM - 0.08);
        }
        EXPECT_NEAR(surface_height_m(soil, {-2.2, 0, 0}), kSurfaceM, 0.008);
        EXPECT_EQ(soil.totals().units, crawler.run().totals_at_start().units);
    }
    const auto middle = [](std::vector<double>& values) {
        std::nth_element(values.begin(), values.begin() + 1, values.end());
        return values[1];
    };
    EXPECT_NEAR(middle(slips), 0, 0.03);
    EXPECT_LT(middle(asides_m), 0.02);
    // Bullet's solver goes through the bodies in an order that is not symmetric.
    EXPECT_LT(middle(yaws), 0.01);
}

TEST(SlowTrackedVehicle, held_fast_it_pulls_what_the_soil_gives) {
    Scene scene = crawler(2.5);
    // Sole and soil are as rough as the soil itself: the limit is Coulomb's, W tan phi without
    // cohesion.
    for (BodyItem& body : scene.bodies) {
        if (body.name.find("/link_") != std::string::npos) body.tool_friction = 2;
    }
    Measured crawler(scene);
    crawler.run_to(kStartS - 0.1);
    crawler.body("hull").body->setLinearFactor(btVector3(0, 1, 1));
    crawler.run_to(1.8);  // 0.2 m slipped, some ten times Janosi's K
    crawler.reset();
    crawler.run_to(2.5);
    const double limit_n =
        weight_n(scene) * std::tan(scene.soil->def.materials[0].friction_angle_rad);
    // A little more, since soil is pushed by grousers and by the links' ends as well.
    EXPECT_LT(crawler.force_n().x, 1.15 * limit_n);
    // A sixth less, since it sinks while it slips (12 mm a second), and what goes into soil has the
    // friction of flow.
    EXPECT_GT(crawler.force_n().x, 0.8 * limit_n);
    EXPECT_LT(std::abs(crawler.force_n().y), 0.03 * limit_n);
}

TEST(TrackedVehicle, links_in_a_row_sink_as_one_plate_of_their_length) {
    constexpr int kLinkCount = 12;
    constexpr double kLengthM = 1.4, kMassKg = 1400;
    double sinkage_m[2] = {};
    for (const int count : {1, kLinkCount}) {
        Scene scene = crawler(1.5);
        scene.motions.clear();
        scene.joints.clear();
        scene.bodies.clear();
        scene.record.bodies.clear();
        for (int i = 0; i < count; ++i) {
            BodyItem plate;
            plate.name = fmt::format("plate_{}", i);
            plate.shape.shape = "box";
            plate.shape.size_m = {kLengthM / count, 0.3, 0.1};
            plate.mass_kg = kMassKg / count;
            plate.group = "plates";
            plate.pose.position = {kLengthM * ((i + 0.5) / count - 0.5), 0, kSurfaceM + 0.05};
            scene.bodies.push_back(plate);
        }
        Measured plates(scene);
        plates.run_to(1.5);
        for (const SceneBody& plate : plates.run().bullet().bodies()) {
            sinkage_m[count > 1] += (kSurfaceM + 0.05 - plate.pose().position.z) / count;
        }
    }
    EXPECT_GT(sinkage_m[0], 0.01);
    // Measured: 5 % less. Each as a sole of its own, 12 cm wide, sinks 67 % less.
    EXPECT_NEAR(sinkage_m[1], sinkage_m[0], 0.1 * sinkage_m[0]);
}

TEST(TrackedVehicle, sinks_less_than_wheels_under_the_same_load) {
    const Scene scene = crawler(1);
    Measured crawler(scene);
    crawler.run_to(1);
    const double of_track_m = plate_sinkage_m(crawler.run().bullet());

    Scene wheeled = scene;
    wheeled.motions.clear();
    wheeled.joints.clear();
    wheeled.tracks.clear();
    BodyItem hull = wheeled.bodies[0];
    const double mass_kg = weight_n(scene) / scene.world.gravity_m_s2;
    hull.mass_kg = mass_kg - 4 * 40;
    wheeled.bodies = {hull};
    for (const double x : {-0.7, 0.7}) {
        for (const double y : {-0.55, 0.55}) {
            BodyItem wheel;
            wheel.name = fmt::format("wheel_{}_{}", x, y);
            wheel.shape.shape = "cylinder";
            wheel.shape.radius_m = 0.3;
            wheel.shape.height_m = 0.3;
            wheel.mass_kg = 40;
            wheel.group = hull.group;
            wheel.pose = {hull.pose.position + Vec3{x, y, -0.05},
                          {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}};
            JointItem joint;
            joint.name = wheel.name;
            joint.kind = "hinge";
            joint.parent = "hull";
            joint.child = wheel.name;
            joint.point_m = wheel.pose.position;
            joint.axis = {0, 1, 0};
            wheeled.bodies.push_back(wheel);
            wheeled.joints.push_back(joint);
        }
    }
    Measured wheels(wheeled);
    wheels.run_to(1);
    double of_wheels_m = 0;
    for (size_t i = 1; i < wheeled.bodies.size(); ++i) {
        of_wheels_m +=
            (kSurfaceM - (wheels.body(wheeled.bodies[i].name).pose().position.z - 0.3)) / 4;
    }
    // 1.2 m of each track bear, some 0.3 m of a wheel's rim. The grousers, 3 cm, are in the sand.
    // The plates are one sole: of 0.3 x 1.4 m it sinks 2.6 cm under 16 kPa, the crawler has 19.
    EXPECT_GT(of_track_m, -0.02);
    EXPECT_LT(of_track_m, of_wheels_m / 2) << of_track_m << " m, " << of_wheels_m << " m";
}

}  // namespace
}  // namespace bsoil::scene::tracked_vehicle_test
