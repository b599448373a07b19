// Raycast vehicles of scenes: what the file says, how they drive, what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reading/scene_load.h"
#include "run/run_checks.h"
#include "run/scene_run.h"

namespace bsoil::scene::driven_vehicle_test {
namespace {

constexpr double kRadiusM = 0.4;

/// A car of 400 kg whose chassis's middle lies 1 m high. `ground`: a [soil] with its fill, or none.
std::string car(const std::string& more, const std::string& ground) {
    return "[world]\nduration_s = 6\n" + ground +
           "[[body]]\nname = \"chassis\"\nshape = \"box\"\nsize_m = [2.4, 1, 0.3]\nmass_kg = "
           "400\nposition_m = [-2, 0, 1.1]\n[[raycast_vehicle]]\nname = \"car\"\nchassis = "
           "\"chassis\"\nengine_force_n = 800\nsteering_deg = 30\nmax_speed_m_s = 2\nwheel = [\n"
           "{ name = \"fl\", position_m = [0.9, 0.7, -0.4], radius_m = 0.4, steered = true },\n"
           "{ name = \"fr\", position_m = [0.9, -0.7, -0.4], radius_m = 0.4, steered = true },\n"
           "{ name = \"rl\", position_m = [-0.9, 0.7, -0.4], radius_m = 0.4 },\n"
           "{ name = \"rr\", position_m = [-0.9, -0.7, -0.4], radius_m = 0.4 },\n]\n" +
           more;
}
const std::string kSand =
    "[soil]\nsize_m = [9, 7, 1]\nvoxel_m = 0.1\n[[fill]]\nkind = \"box\"\nmin_m = [-4.5, "
    "-3.5, 0]\nmax_m = [4.5, 3.5, 0.3]\n";

struct Driven {
    Scene scene;
    std::unique_ptr<SceneRun> run;

    explicit Driven(const std::string& text, UpAxis up = UpAxis::z) {
        auto parsed = parse_scene(text, "car.toml");
        EXPECT_TRUE(parsed) << parsed.error();
        if (parsed) scene = *parsed;
        set_up_axis(scene, up);
        auto made = SceneRun::create(scene, {.backend = Backend::cpu});
        EXPECT_TRUE(made) << made.error();
        if (made) run = std::move(*made);
    }
    void drive(std::optional<DriveCommand> command, double seconds) {
        for (const auto& vehicle : run->raycast_vehicles()) vehicle->set_drive(command);
        const long long end = run->step_count() + std::llround(seconds / run->step_s());
        while (run->step_count() < end) run->step();
    }
    Pose pose(const std::string& body = "chassis") const {
        return run->bullet().find_body(body)->pose();
    }
    /// Of the soil in the last step.
    const BodyReading& reading(const std::string& body) const {
        const auto found = std::ranges::find(run->bullet().bodies(), body, &SceneBody::name);
        return run->readings()[static_cast<size_t>(found - run->bullet().bodies().begin())];
    }
    Vec3 force_on_wheels_n() const {
        Vec3 sum;
        for (const char* wheel : kWheels) sum += reading(wheel).force_n;
        return sum;
    }
    static constexpr std::array kWheels{"car/fl", "car/fr", "car/rl", "car/rr"};
};

TEST(SceneVehicle, of_a_scene_drives_steers_and_brakes) {
    for (const std::string& ground : {kSand, std::string()}) {
        SCOPED_TRACE(ground.empty() ? "rigid" : "sand");
        Driven car_run(car("", ground));
        car_run.drive({}, 1.5);  // no keys: it stands
        const double stood_m = car_run.pose().position.x;
        EXPECT_NEAR(stood_m, -2, 0.05);
        const double wheel_m = car_run.pose("car/fl").position.z;
        EXPECT_NEAR(wheel_m, (ground.empty() ? 0 : 0.3) + kRadiusM, 0.1);

        car_run.drive(DriveCommand{1, 0, 0}, 1.2);
        const Vec3 ahead = car_run.pose().position;
        EXPECT_GT(ahead.x, stood_m + 0.3);
        EXPECT_NEAR(ahead.y, 0, 0.05);
        car_run.drive(DriveCommand{1, 1, 0}, 1.5);
        const Vec3 left = car_run.pose().position;
        EXPECT_GT(left.y, 0.1) << "positive steering is to the left";
        const Vec3 heading = rotate(car_run.pose().rotation, {1, 0, 0});
        EXPECT_GT(heading.y, 0.1);

        car_run.drive(DriveCommand{0, 0, 1}, 1.5);
        const Vec3 braked = car_run.pose().position;
        car_run.drive(DriveCommand{0, 0, 1}, 0.5);
        EXPECT_LT(length(car_run.pose().position - braked), 0.02);
    }
}

// The principal axes of such a chassis lean by 20 deg. Bullet's vehicle takes its body's axes.
TEST(SceneVehicle, wheels_are_where_the_scene_has_them_under_a_lopsided_chassis) {
    std::string text = car("", "");
    const std::string box = "shape = \"box\"\nsize_m = [2.4, 1, 0.3]\nmass_kg = 400\n";
    text.replace(text.find(box), box.size(),
                 "shape = \"compound\"\nmass_kg = 400\npart = [\n{ shape = \"box\", size_m = [2.4, "
                 "1, 0.3], mass_kg = 300 },\n{ shape = \"box\", size_m = [0.4, 0.4, 0.4], "
                 "position_m = [-0.9, 0, 0.9], mass_kg = 100 },\n]\n");
    const Driven car_run(text);
    const Pose chassis = car_run.pose();
    EXPECT_NEAR(chassis.rotation.w, 1, 1e-12);
    // Before its first ray a strut has no length.
    const Vec3 pressed_m{0, 0, 0.3};
    car_run.run->raycast_vehicles()[0]->place_wheels();
    for (const auto& [name, at] :
         {std::pair{"car/fl", Vec3{0.9, 0.7, -0.4}}, {"car/rr", Vec3{-0.9, -0.7, -0.4}}}) {
        EXPECT_LT(length(transform(inverse(chassis), car_run.pose(name).position) - at - pressed_m),
                  1e-4)
            << name;
        const Vec3 axle = rotate(car_run.pose(name).rotation, {0, 1, 0});
        EXPECT_NEAR(std::abs(axle.y), 1, 1e-6) << name;
    }
}

TEST(SceneVehicle, follows_its_keys_and_a_driver_takes_over) {
    Driven car_run(car("key = [{ t_s = 1 }, { t_s = 1.2, throttle = 1 }]\n", kSand));
    car_run.drive({}, 2.5);
    const double by_keys_m = car_run.pose().position.x;
    EXPECT_GT(by_keys_m, -1.8);
    car_run.drive(DriveCommand{0, 0, 1}, 1);
    const double held_m = car_run.pose().position.x;
    car_run.drive(DriveCommand{0, 0, 1}, 0.5);
    EXPECT_NEAR(car_run.pose().position.x, held_m, 0.02);
    car_run.drive({}, 1);
    EXPECT_GT(car_run.pose().position.x, held_m + 0.2);
}

// The same scene on its side: z becomes y.
TEST(SceneVehicle, drives_the_same_way_where_y_is_up) {
    const std::string text =
        car("key = [{ t_s = 1 }, { t_s = 1.2, throttle = 1, steering = 0.5 }]\n", kSand);
    Driven upright(text), turned(text, UpAxis::y);
    upright.drive({}, 3);
    turned.drive({}, 3);
    const Vec3 a = upright.pose().position, b = turned.pose().position;
    EXPECT_GT(a.x, -1.5);
    EXPECT_NEAR(b.x, a.x, 0.03);
    EXPECT_NEAR(b.y, a.z, 0.03);
    EXPECT_NEAR(-b.z, a.y, 0.03);
}

// The soil bears the car at its wheels, and what it does there is what moves the chassis.
TEST(SceneVehicle, wheels_report_the_forces_of_the_soil) {
    for (const UpAxis axis : {UpAxis::z, UpAxis::y}) {
        SCOPED_TRACE(axis == UpAxis::y ? "y" : "z");
        const Vec3 up = axis == UpAxis::y ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
        constexpr double kMassKg = 400, kWeightN = kMassKg * 9.81;
        Driven car_run(car("", kSand), axis);
        car_run.drive({}, 2);
        for (const char* wheel : Driven::kWheels) {
            const BodyReading& reading = car_run.reading(wheel);
            EXPECT_NEAR(dot(reading.force_n, up), kWeightN / 4, 0.05 * kWeightN) << wheel;
            EXPECT_GE(reading.peak_force_n, length(reading.force_n)) << wheel;
            EXPECT_GT(reading.sinkage_m, 0.001) << wheel;
            EXPECT_LT(reading.sinkage_m, 0.1) << wheel;
        }
        EXPECT_NEAR(dot(car_run.force_on_wheels_n(), up), kWeightN, 0.02 * kWeightN);
        EXPECT_EQ(length(car_run.reading("chassis").force_n), 0) << "it touches no soil itself";

        const SceneBody& chassis = *car_run.run->bullet().find_body("chassis");
        const Vec3 before_m_s = chassis.linear_velocity_m_s();
        Vec3 impulse_n_s;
        double time_s = 0;
        while (time_s < 1.5) {  // it drives off to the left
            car_run.drive(DriveCommand{1, 1, 0}, car_run.run->step_s());
            impulse_n_s += car_run.run->step_s() * car_run.force_on_wheels_n();
            time_s += car_run.run->step_s();
        }
        const Vec3 gain_n_s = kMassKg * (chassis.linear_velocity_m_s() - before_m_s);
        EXPECT_GT(gain_n_s.x, 100);
        EXPECT_GT(std::abs(axis == UpAxis::y ? gain_n_s.z : gain_n_s.y), 20);
        // Across the struts the chassis feels what the wheels do; along them a wheel moves too.
        const Vec3 off_n_s = impulse_n_s - time_s * kWeightN * up - gain_n_s;
        const double off_up_n_s = dot(off_n_s, up);
        EXPECT_LT(length(off_n_s - off_up_n_s * up), 0.01 * length(gain_n_s));
        EXPECT_LT(std::abs(off_up_n_s), 0.02 * time_s * kWeightN);
    }
}

TEST(SceneVehicle, checks_see_the_forces_on_its_wheels) {
    const Driven car_run(
        car("[[check]]\nkind = \"body_force\"\nbody = \"car/fl\"\nmax_n = 1\n"
            "[[check]]\nkind = \"force_steady\"\nbody = \"car/fl\"\nfrom_s = 2\nmax_n = 1\n"
            "[[check]]\nkind = \"force_steady\"\nbody = \"car/fl\"\nfrom_s = 2\ndirection = "
            "[0, 0, 1]\nmin_n = 950\nmax_n = 1010\n",
            kSand));
    RunChecks checks(*car_run.run);
    while (!car_run.run->finished()) {
        car_run.run->step();
        checks.observe();
    }
    const std::vector<CheckResult> results = checks.results();
    ASSERT_EQ(results.size(), 4u);
    using Verdict = CheckResult::Verdict;
    EXPECT_EQ(results[1].verdict, Verdict::fail) << results[1].figure;
    EXPECT_EQ(results[2].verdict, Verdict::fail) << results[2].figure;
    EXPECT_EQ(results[3].verdict, Verdict::pass) << results[3].figure;
    EXPECT_GT(car_run.run->summary()["bodies"]["car/fl"]["soil_force_peak_n"], 950);
}

TEST(SceneVehicle, leaves_ruts) {
    std::string text = car("", kSand);
    text.replace(text.find("mass_kg = 400"), 13, "mass_kg = 3000");
    text.replace(text.find("engine_force_n = 800"), 20, "engine_force_n = 9000");
    Driven car_run(text);
    car_run.drive({}, 1.5);
    car_run.drive(DriveCommand{0.8, 0, 0}, 2.5);
    // The left front wheel has come along here.
    const Vec3 wheel_m = car_run.pose("car/fl").position;
    ASSERT_GT(wheel_m.x, 0);
    const Soil& soil = car_run.run->soil();
    EXPECT_LT(surface_height_m(soil, {-0.6, wheel_m.y, 0}),
              surface_height_m(soil, {-0.6, 0, 0}) - 0.005);
    EXPECT_EQ(soil.status_bits(), 0u);
}

TEST(SceneVehicle, mistakes_are_named_with_their_place) {
    const auto error_of = [](const std::string& text) {
        const auto scene = parse_scene(text, "car.toml");
        EXPECT_FALSE(scene);
        return scene ? std::string() : scene.error();
    };
    const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
        const size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return text.replace(at, from.size(), to);
    };
    const std::string good = car("", kSand);
    for (const auto& [from, to, says] :
         {std::array<std::string, 3>{"chassis = \"chassis\"", "chassis = \"hull\"",
                                     "no [[body]] is named \"hull\""},
          {"mass_kg = 400", "mass_kg = 0", "\"chassis\" must be a rigid body"},
          {"name = \"fr\"", "name = \"fl\"", "a wheel named \"fl\" is there already"},
          {"radius_m = 0.4,", "radius_m = 0,", "radius_m"},
          {"engine_force_n = 800", "engine_force_n = -1", "engine_force_n"},
          {"wheel = [", "tyres = [", "wheel"}}) {
        const std::string error = error_of(replaced(good, from, to));
        EXPECT_NE(error.find(says), std::string::npos) << error;
        EXPECT_EQ(error.rfind("car.toml:", 0), 0u) << error;
    }
    EXPECT_NE(error_of(car("key = [{ t_s = 2 }, { t_s = 1 }]\n", kSand)).find("rise in time"),
              std::string::npos);
}

}  // namespace
}  // namespace bsoil::scene::driven_vehicle_test
