// What is seen is looked for in the voxels, pixel by pixel.
#include "run_drawn.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bsoil/render/renderer.h"
#include "bsoil/surface_mesh.h"
#include "random.h"

namespace bsoil::random_worlds {
namespace {

constexpr int kFrames = 45, kPictureEvery = 15;
constexpr int kWidth = 160, kHeight = 120;
/// Every so many pixels each way are looked at.
constexpr int kPixelStep = 3;
constexpr uint32_t kSoilLabel = 1, kTerrainLabel = 2;
/// A voxel so full, as all around it are, lies inside.
constexpr float kFull = 0.9f;

render::Renderer* renderer() {
    static const std::unique_ptr<render::Renderer> kRenderer = [] {
        auto made = render::Renderer::create(
            {.sample_count = 1, .shadow_map_size = 256, .occlusion = false});
        return made ? std::move(*made) : nullptr;
    }();
    return kRenderer.get();
}

/// What a soil's voxels hold, and whether a ray could see it.
class Voxels {
  public:
    explicit Voxels(const SoilTiles& tiles) : frame_(tiles.frame()) {
        soil_.resize(at(0, 0, frame_.size[2]));
        terrain_.resize(soil_.size());
        ground_.resize(soil_.size());
        std::vector<float> volume, solid, terrain;
        std::vector<uint8_t> material;
        for (int ty = 0; ty < (frame_.size[1] + 7) / 8; ++ty) {
            for (int tx = 0; tx < (frame_.size[0] + 7) / 8; ++tx) {
                tiles.read_tile(tx, ty, volume, solid, material);
                tiles.read_terrain(tx, ty, terrain);
                for (size_t i = 0; i < volume.size(); ++i) {
                    const int n = static_cast<int>(i), x = 8 * tx + n % 8, y = 8 * ty + n / 8 % 8;
                    if (x >= frame_.size[0] || y >= frame_.size[1]) continue;
                    soil_[at(x, y, n / 64)] = volume[i];
                    terrain_[at(x, y, n / 64)] = terrain[i];
                    ground_[at(x, y, n / 64)] = solid[i] - terrain[i];
                }
            }
        }
    }

    /// Whether what is seen is around a place. Soil's mesh goes on into bodies that it lies on,
    /// which are the host's own to draw.
    bool has_near(Vec3 world_m, uint32_t label) const {
        bool has_soil = false, has_terrain = false, has_ground = false;
        around(world_m, [&](size_t voxel) {
            has_soil = has_soil || soil_[voxel] > 0;
            has_terrain = has_terrain || terrain_[voxel] > 0;
            has_ground = has_ground || ground_[voxel] > 0;
        });
        return label == kTerrainLabel ? has_terrain : has_soil || has_ground;
    }
    /// Whether a place lies a voxel deep at least in soil or terrain.
    bool is_inside(Vec3 world_m) const {
        int full = 0;
        around(world_m, [&](size_t voxel) { full += soil_[voxel] + terrain_[voxel] >= kFull; });
        return full == 27;
    }
    bool has_soil() const {
        for (int z = 1; z + 1 < frame_.size[2]; ++z) {
            for (int y = 1; y + 1 < frame_.size[1]; ++y) {
                for (int x = 1; x + 1 < frame_.size[0]; ++x) {
                    if (is_inside(frame_.to_world({x + 0.5, y + 0.5, z + 0.5}))) return true;
                }
            }
        }
        return false;
    }

  private:
    size_t at(int x, int y, int z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(frame_.size[1]) +
                static_cast<size_t>(y)) *
                   static_cast<size_t>(frame_.size[0]) +
               static_cast<size_t>(x);
    }
    template <typename F>
    void around(Vec3 world_m, const F& f) const {
        const Vec3 g = frame_.to_grid(world_m);
        const int x = static_cast<int>(std::floor(g.x)), y = static_cast<int>(std::floor(g.y)),
                  z = static_cast<int>(std::floor(g.z));
        for (int n = 0; n < 27; ++n) {
            const std::array<int, 3> v = {x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1};
            if (v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && v[0] < frame_.size[0] &&
                v[1] < frame_.size[1] && v[2] < frame_.size[2]) {
                f(at(v[0], v[1], v[2]));
            }
        }
    }
    const GridFrame& frame_;
    std::vector<float> soil_, terrain_, ground_;
};

/// The surfaces of a soil and its terrain, in the renderer.
class Surfaces {
  public:
    explicit Surfaces(const SoilTiles& tiles)
        : soil_(tiles),
          terrain_(tiles, {.layer = SurfaceMeshDef::Layer::terrain}),
          soil_items_(*renderer(), soil_, 0),
          terrain_items_(*renderer(), terrain_, 0) {}

    template <typename... Detail>
    void update(const Detail&... detail) {
        soil_.update(detail...);
        terrain_.update(detail...);
        soil_items_.update();
        terrain_items_.update();
    }
    render::View shown(render::View view) const {
        const auto add = [&view](const render::SurfaceItems& of, uint32_t label) {
            const size_t first = view.items.size();
            of.append_to(view.items);
            for (size_t i = first; i < view.items.size(); ++i) view.items[i].label = label;
        };
        add(soil_items_, kSoilLabel);
        add(terrain_items_, kTerrainLabel);
        return view;
    }

  private:
    SurfaceMesher soil_, terrain_;
    render::SurfaceItems soil_items_, terrain_items_;
};

/// From anywhere about the grid and above its floor, below which soil shows that is in terrain.
render::View any_view(const GridFrame& frame, Vec3 up, Random& random) {
    const Vec3 size{static_cast<double>(frame.size[0]), static_cast<double>(frame.size[1]),
                    static_cast<double>(frame.size[2])};
    render::View view;
    view.width = kWidth;
    view.height = kHeight;
    view.camera.up = up;
    view.camera.target = frame.to_world(size * 0.5);
    Vec3 away = random.direction();
    while (dot(away, up) < 0.02 || dot(away, up) > 0.95) away = random.direction();
    view.camera.eye =
        view.camera.target + frame.voxel_m * length(size) * random.uniform(0.8, 2) * away;
    return view;
}

/// Of a pixel, as far along as the camera looks by one.
Vec3 ray_of(const render::Camera& camera, int x, int y) {
    const Vec3 along = camera.target - camera.eye;
    const Vec3 ahead = along * (1 / length(along));
    const Vec3 aside = cross(ahead, camera.up);
    const Vec3 right = aside * (1 / length(aside)), above = cross(right, ahead);
    const double half = std::tan(camera.fov_rad / 2);
    return ahead + (2 * (x + 0.5) / kWidth - 1) * half * kWidth / kHeight * right +
           (1 - 2 * (y + 0.5) / kHeight) * half * above;
}

/// One soil of a world that is drawn.
class DrawnSoil {
  public:
    DrawnSoil(const Soil& soil, std::string name, Vec3 up, uint64_t seed)
        : tiles_(soil),
          name_(std::move(name)),
          up_(up),
          random_(seed),
          kept_(tiles_),
          coarse_(tiles_) {}

    void draw(double time_s, Failures& failures) {
        const render::View view = any_view(tiles_.frame(), up_, random_);
        Surfaces anew(tiles_);
        anew.update();
        kept_.update();
        coarse_.update(render::surface_detail(view));
        const auto fail = [&](const char* what, const std::string& expected,
                              const std::string& found) {
            failures.add(what, name_, time_s, expected, found);
        };
        const auto picture = renderer()->render(kept_.shown(view));
        if (!picture) return fail("draws", "a picture", picture.error());
        const auto is = renderer()->buffers(kept_.shown(view));
        const auto is_anew = renderer()->buffers(anew.shown(view));
        const auto is_coarse = renderer()->buffers(coarse_.shown(view));
        if (!is || !is_anew || !is_coarse) return fail("draws", "buffers", "an error");
        if (is->depths_m != is_anew->depths_m || is->normals != is_anew->normals ||
            is->labels != is_anew->labels) {
            fail("picture kept", "what is drawn anew", "another picture");
        }
        const Voxels voxels(tiles_);
        if (voxels.has_soil() && std::ranges::count(is->labels, kSoilLabel) == 0 &&
            std::ranges::count(is->labels, kTerrainLabel) == 0) {
            fail("soil is seen", "a pixel of it", "none");
        }
        look(voxels, view.camera, *is, true, fail);
        look(voxels, view.camera, *is_coarse, false, fail);
    }

  private:
    template <typename Fail>
    void look(const Voxels& voxels, const render::Camera& camera, const render::Buffers& seen,
              bool is_fine, const Fail& fail) {
        const double voxel_m = tiles_.frame().voxel_m;
        for (int y = 0; y < kHeight; y += kPixelStep) {
            for (int x = 0; x < kWidth; x += kPixelStep) {
                const auto pixel = static_cast<size_t>(y * kWidth + x);
                const Vec3 ray = ray_of(camera, x, y);
                const double depth_m = seen.depths_m[pixel];
                const bool is_sky = seen.labels[pixel] == 0;
                const Vec3 point = camera.eye + depth_m * ray;
                if (is_fine && !is_sky && !voxels.has_near(point, seen.labels[pixel])) {
                    const Vec3 g = tiles_.frame().to_grid(point);
                    return fail("seen is there", "soil or terrain",
                                fmt::format("none at ({:.2f} {:.2f} {:.2f}) voxels, pixel {} {}",
                                            g.x, g.y, g.z, x, y));
                }
                const double end_m =
                    is_sky ? 2 * length(camera.target - camera.eye) : depth_m - 1.5 * voxel_m;
                for (double at_m = 0; at_m < end_m; at_m += 0.5 * voxel_m) {
                    if (!voxels.is_inside(camera.eye + at_m * ray)) continue;
                    const Vec3 g = tiles_.frame().to_grid(camera.eye + at_m * ray);
                    return fail(is_fine ? "hides" : "hides from afar", "soil or terrain in the way",
                                fmt::format("a hole at ({:.2f} {:.2f} {:.2f}) voxels, pixel {} {}",
                                            g.x, g.y, g.z, x, y));
                }
            }
        }
    }

    SoilTiles tiles_;
    std::string name_;
    Vec3 up_;
    Random random_;
    Surfaces kept_, coarse_;
};

}  // namespace

bool can_draw() { return renderer() != nullptr; }

void run_drawn(const WorldPlan& plan, Failures& failures) {
    BuiltWorld plain(plan), drawn(plan);
    if (!drawn.error().empty()) {
        return failures.add("builds", "world", 0, "no error", drawn.error());
    }
    std::vector<std::unique_ptr<DrawnSoil>> soils;
    for (const bullet::SoilAction* soil : drawn.soils()) {
        soils.push_back(std::make_unique<DrawnSoil>(
            soil->soil(), fmt::format("soil {}", soils.size()), drawn.up(), plan.seed));
    }
    for (int i = 0; i <= kFrames; ++i) {
        if (i % kPictureEvery == 0) {
            for (const auto& soil : soils) soil->draw(drawn.time_s(), failures);
        }
        plain.step();
        drawn.step();
        if (plain.checksum() != drawn.checksum()) {
            return failures.add("drawn", "world", drawn.time_s(), "what is not drawn",
                                "another world");
        }
    }
}

}  // namespace bsoil::random_worlds
