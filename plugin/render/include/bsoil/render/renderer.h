/// Off-screen pictures of meshes: sun with shadows, sky, ambient occlusion. Through EGL, no window.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/geometry.h"
#include "bsoil/render/image.h"
#include "bsoil/surface_mesh.h"

#pragma GCC visibility push(default)
namespace bsoil::render {

/// A perspective camera. World axes, metres.
struct Camera {
    Vec3 eye{4, 3, 4};
    Vec3 target;
    Vec3 up{0, 1, 0};      ///< also what is up for sky and light
    double fov_rad = 0.7;  ///< vertical field of view, 0.05..2.5
};

/// A mesh of the renderer.
struct MeshId {
    uint32_t value = 0;  ///< 0: none
};

/// A mesh in the picture.
struct Item {
    MeshId mesh;
    Pose pose;          ///< mesh -> world
    float grain_m = 0;  ///< size of the grains the surface is patterned with [m]; 0: smooth
    float gloss = 0;    ///< 0: matt .. 1: painted metal
};

/// One picture.
struct View {
    int width = 1280, height = 720;  ///< 1..8192 pixels
    Camera camera;
    Vec3 to_sun{0.55, 0.75, 0.35};  ///< need not be a unit vector
    /// Height along the camera's up axis of a plain floor that fades into the sky [m]; none by
    /// default.
    std::optional<double> floor_height_m;
    std::vector<Item> items;
};

/// How pictures are made.
struct RendererDef {
    int sample_count = 4;        ///< per pixel, 1..8; fewer where the device has no more
    int shadow_map_size = 2048;  ///< texels a side, 256..8192
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// Draws pictures. Has a GL context of its own, which it makes current inside each call only: the
/// caller's is current again afterwards. One thread at a time.
class Renderer {
  public:
    /// The error says what is missing: no EGL, no OpenGL 3.3, the text of a shader's compiler.
    static Result<std::unique_ptr<Renderer>> create(const RendererDef& def = {});
    ~Renderer();

    /// Copies the triangles to the device.
    MeshId add_mesh(const Mesh& mesh);
    /// Replaces the triangles of a mesh.
    void set_mesh(MeshId id, const Mesh& mesh);
    /// The id may be given out again.
    void remove_mesh(MeshId id);

    /// Draws a picture and waits for it. Items without a mesh are left out.
    Result<Image> render(const View& view);

    /// As the GL driver calls it.
    const std::string& device_name() const;

  private:
    struct Impl;
    explicit Renderer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// The meshes of a SurfaceMesher in a Renderer, kept up to date tile by tile.
class SurfaceItems {
  public:
    /// Both must outlive it.
    SurfaceItems(Renderer& renderer, const SurfaceMesher& mesher, float grain_m);
    ~SurfaceItems();
    SurfaceItems(const SurfaceItems&) = delete;
    SurfaceItems& operator=(const SurfaceItems&) = delete;

    /// Uploads the tiles meshed since the last call.
    void update();
    /// Adds the tiles that have triangles.
    void append_to(std::vector<Item>& items) const;

  private:
    struct Tile {
        MeshId mesh;
        uint64_t revision = 0;
        bool empty = true;
    };
    Renderer& renderer_;
    const SurfaceMesher& mesher_;
    float grain_m_;
    std::vector<Tile> tiles_;
};

}  // namespace bsoil::render
#pragma GCC visibility pop
