/// What a wheel has pressed into the soil is seen on the scene's picture.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "reading/scene_load.h"
#include "run/scene_picture.h"
#include "run/scene_run.h"

namespace bsoil::scene::rut_picture_test {
namespace {

constexpr double kBedM = 0.4, kFromM = -0.6, kToM = 0.4;

/// A wheel rolls along x through poured sand, 3 cm deep in voxels of 5 cm, and is taken away: its
/// shadow would lie on what is looked at.
std::string rolled(bool goes_in) {
    const double height_m = kBedM + 0.4 - (goes_in ? 0.03 : -0.2);
    std::string keys;
    for (int i = 0; i <= 4; ++i) {
        const double x_m = -1 + 0.5 * i, turn_deg = 0.5 * i / 0.4 * 180 / 3.14159265;
        keys += "{ t_s = " + std::to_string(0.5 * i) + ", position_m = [" + std::to_string(x_m) +
                ", 0, " + std::to_string(height_m) + "], rotation_deg = [0, " +
                std::to_string(turn_deg) + ", 0] },\n";
    }
    return "[world]\nduration_s = 3\n[soil]\nsize_m = [3, 2, 1.2]\nvoxel_m = 0.05\n"
           "[[material]]\nname = \"poured\"\nbase = \"dry_sand\"\ndensity_kg_m3 = 1450\n"
           "[[fill]]\nkind = \"box\"\nmin_m = [-1.5, -1, 0]\nmax_m = [1.5, 1, 0.4]\n"
           "[[body]]\nname = \"wheel\"\nshape = \"cylinder\"\nradius_m = 0.4\nheight_m = 0.3\n"
           "axis = \"y\"\nkinematic = true\nposition_m = [-1, 0, " +
           std::to_string(height_m) + "]\n[[motion]]\nbody = \"wheel\"\nkey = [\n" + keys +
           "{ t_s = 2.5, position_m = [4, 0, 6], rotation_deg = [0, 300, 0] },\n]\n"
           "[camera]\neye_m = [0.4, -3.2, 2.4]\ntarget_m = [0, 0, 0.4]\n";
}

/// Brightness of the soil's surface across the rut, each a mean along it.
class Profile {
  public:
    Profile(const render::View& view, const render::Image& image) : view_(view), image_(image) {}
    /// Standard deviation over -to_m..-from_m and from_m..to_m beside the rut's middle.
    double deviation(double from_m, double to_m) const {
        std::vector<double> rows;
        for (double y = from_m; y <= to_m; y += 0.01) {
            for (const double side : {-1.0, 1.0}) rows.push_back(row(side * y));
        }
        double mean = 0, sum = 0;
        for (const double b : rows) mean += b / static_cast<double>(rows.size());
        for (const double b : rows) sum += (b - mean) * (b - mean);
        return std::sqrt(sum / static_cast<double>(rows.size()));
    }

  private:
    double row(double y_m) const {
        double sum = 0;
        int count = 0;
        for (double x = kFromM; x <= kToM; x += 0.02, ++count) sum += brightness({x, y_m, kBedM});
        return sum / count;
    }
    double brightness(Vec3 at) const {
        const render::Camera& camera = view_.camera;
        const Vec3 sight = camera.target - camera.eye, ahead = sight * (1 / length(sight));
        const Vec3 beside = cross(ahead, camera.up), right = beside * (1 / length(beside));
        const Vec3 up = cross(right, ahead), to = at - camera.eye;
        const double pixels = view_.height / 2.0 / std::tan(camera.fov_rad / 2) / dot(to, ahead);
        const int x = static_cast<int>(view_.width / 2.0 + pixels * dot(to, right));
        const int y = static_cast<int>(view_.height / 2.0 - pixels * dot(to, up));
        EXPECT_TRUE(x >= 0 && x < view_.width && y >= 0 && y < view_.height);
        const uint8_t* p = image_.pixel(x, y);
        return (p[0] + p[1] + p[2]) / 3.0;
    }
    const render::View& view_;
    const render::Image& image_;
};

TEST(RutPicture, a_rut_of_three_centimetres_is_seen) {
    auto renderer = render::Renderer::create();
    if (!renderer) GTEST_SKIP() << renderer.error();
    for (const bool goes_in : {true, false}) {
        const auto scene = parse_scene(rolled(goes_in), "rut.toml");
        ASSERT_TRUE(scene) << scene.error();
        auto run = SceneRun::create(*scene, {.backend = Backend::cpu});
        ASSERT_TRUE(run) << run.error();
        while (!(*run)->finished()) (*run)->step();
        ScenePicture picture(**run, **renderer);
        const render::View view = picture.view([](render::View& v) {
            v.width = 640;
            v.height = 360;
        });
        const auto image = (*renderer)->render(view);
        ASSERT_TRUE(image) << image.error();
        const Profile profile(view, *image);
        // The wheel is 0.3 m wide; what it has heaved up lies beside it.
        const double across = profile.deviation(0, 0.25), flat = profile.deviation(0.45, 0.7);
        if (goes_in) {
            EXPECT_GT(across, 4 * flat);
            EXPECT_GT(across, 5) << "of 255";
        } else {
            EXPECT_LT(across, 2 * flat);
        }
    }
}

}  // namespace
}  // namespace bsoil::scene::rut_picture_test
