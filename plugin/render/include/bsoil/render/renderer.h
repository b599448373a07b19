/// Pictures of meshes: sun with shadows, sky, ambient occlusion. Off screen through EGL, or in the
/// window of a host that has an OpenGL context.
#pragma once

#include <array>
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
    /// How far right of the picture's middle the target is seen, -0.9..0.9 half widths: for a
    /// picture that panels lie on.
    double shift = 0;
};

/// A mesh of the renderer.
struct MeshId {
    uint32_t value = 0;  ///< 0: none
};

/// A picture to lay on triangles.
struct TextureData {
    int width = 0, height = 0;  ///< 1..8192 pixels
    std::vector<uint8_t> rgba;  ///< sRGB, four bytes a pixel, rows from top to bottom; opaque
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// A texture of the renderer.
struct TextureId {
    uint32_t value = 0;  ///< 0: none
};

/// What lies on the triangles of a mesh in place of their colours.
struct Skin {
    /// A run of the mesh's indices with one texture.
    struct Part {
        TextureId texture;
        uint32_t index_begin = 0, index_count = 0;
    };
    /// Two of each vertex: 0, 0 is the lower left corner of the texture and 1, 1 the upper right
    /// one. Beyond these it is repeated. Any other number of them: no textures are drawn.
    std::vector<float> places;
    std::vector<Part> parts;  ///< ascending and apart; between them the mesh's colours show
};

/// A mesh in the picture.
struct Item {
    MeshId mesh;
    Pose pose;          ///< mesh -> world
    float grain_m = 0;  ///< size of the grains the surface is patterned with [m]; 0: smooth
    float gloss = 0;    ///< 0: matt .. 1: painted metal
    /// 0: lit by sun and sky .. 1: its own colours whatever the light, as a diagram has them.
    float emission = 0;
    /// Closed, with triangles counter-clockwise from outside: those that look away are left out,
    /// which is faster. The soil's meshes are.
    bool is_closed = false;
    bool is_cut = false;  ///< what lies beyond View::cut is left out
    uint32_t label = 0;   ///< what Buffers::labels has where the item is seen
};

/// A straight line in the picture.
struct Line {
    Vec3 from, to;                        ///< world [m]
    std::array<float, 3> color{1, 1, 1};  ///< linear RGB, 0..1
};

/// A box of voxels to look into.
struct VolumeData {
    int size[3] = {0, 0, 0};  ///< voxels along x, y, z, each 1..2048
    /// Four bytes a voxel, x the fastest, then y. Red, green and blue are square roots of linear
    /// 0..1, as 0..255. The fourth is how much the voxel hides: 0 nothing.
    std::vector<uint8_t> rgba;
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// A volume of the renderer.
struct VolumeId {
    uint32_t value = 0;  ///< 0: none
};

/// A volume in the picture. Rays march through its box until they meet what else is seen, or until
/// nothing more comes through (as in Minho's particle deposition, chapter 4). They choose their
/// steps themselves: half a voxel, and a pixel's width where that is more.
struct Volume {
    VolumeId volume;
    Pose pose;              ///< of its corner with the first voxel; volume -> world
    double voxel_m = 0.05;  ///< side of a voxel, above 0
    double sight_m = 0.3;   ///< in what hides most 1/e of the light is left after this, above 0
    /// What hides less than this hides nothing, 0..0.9; the rest is stretched to 0..1.
    double threshold = 0;
    bool is_shaded = true;  ///< brighter towards the sun where what hides begins
};

/// Grains in a group of them.
inline constexpr int kGroupGrains = 128;

/// Loose soil about a place: grains at places that are fixed for a seed, in a cube. They travel on
/// with View::time_s, in on one side of the cube and out on the other, drawn out along their
/// motion. (Groups of 128 with fixed offsets: the Mevea thesis, 6.6.) All groups of a picture are
/// one draw.
struct GrainGroup {
    Vec3 center;                          ///< world [m]
    Vec3 velocity_m_s;                    ///< world axes
    float side_m = 0.1f;                  ///< of the cube
    float grain_m = 0.005f;               ///< size of a grain
    float share = 1;                      ///< of its kGroupGrains grains that are there, 0..1;
                                          ///< less is none, more is all
    std::array<float, 3> color{1, 1, 1};  ///< linear RGB, 0..1
    uint32_t seed = 0;
    Vec3 normal;         ///< unit: the cube is pressed flat along it; 0, 0, 0: it is not
    float flatness = 0;  ///< 0: a cube .. 1: all grains lie in one plane
};

/// Dust over soil that moves fast: a cloud that rises, grows and thins out, again and again as
/// long as the puff is there. It casts no shadow.
struct DustPuff {
    Vec3 center;                          ///< world [m], where it begins
    Vec3 velocity_m_s;                    ///< of the soil, world axes: dust goes along a little
    float side_m = 0.05f;                 ///< of the soil's voxel: by this the cloud is scaled
    float strength = 1;                   ///< 0..1
    std::array<float, 3> color{1, 1, 1};  ///< of the soil, linear RGB
    uint32_t seed = 0;
};

/// One picture.
struct View {
    /// 1..8192 pixels. A picture takes 90 bytes of the device's memory a pixel, with fewer than
    /// four samples 30.
    int width = 1280, height = 720;
    Camera camera;
    Vec3 to_sun{0.55, 0.75, 0.35};  ///< need not be a unit vector
    /// Height along the camera's up axis of a plain floor that fades into the sky [m]; none by
    /// default.
    std::optional<double> floor_height_m;
    /// Of grain_m, gloss and emission a picture has room for 256 that differ; a wet mesh takes
    /// nine. Items beyond them look as the first one does.
    std::vector<Item> items;
    /// Items that say so are seen only within this half space, as if cut open. Their shadows stay.
    std::optional<Plane> cut;
    std::vector<Volume> volumes;    ///< cast no shadows, and are not in Buffers
    std::vector<Line> lines;        ///< hidden by what is nearer; volumes do not hide them
    std::vector<Line> front_lines;  ///< hidden by nothing
    float line_width = 1.5f;        ///< pixels, 0.5..16
    std::vector<GrainGroup> grains;
    std::vector<DustPuff> dust;  ///< before all else but lines; not in Buffers
    double time_s = 0;           ///< grains travel with it, dust rises
    uint32_t grain_label = 0;    ///< as Item::label, of all grains
};

/// How coarse the surfaces of a picture may be without a person seeing it: cells are a few pixels
/// wide, or the surface is as good as flat.
SurfaceDetail surface_detail(const View& view);

/// How pictures are made.
struct RendererDef {
    /// Per pixel, 1..8. From 4 on each pixel is lit in 2 x 2 places; with 2 and 3 in one, and where
    /// one thing ends and another begins they are mixed; with 1 nothing is smoothed. A picture of
    /// more than half the side that the device's textures may have is made as with 3.
    int sample_count = 4;
    int shadow_map_size = 2048;  ///< texels a side, 256..8192
    bool occlusion = true;       ///< ambient occlusion: what is near a pixel takes its sky away
    /// Draw with the OpenGL 3.3 core context that is current when create() is called, instead of
    /// one of its own. The host keeps it current in every later call and at destruction. Its state
    /// does not matter to pictures. After a call depth, blending, culling, textures, vertex arrays
    /// and program are as GL has them at first; all else is as it was (but see draw()). OpenGL's
    /// errors of before are forgotten.
    bool callers_context = false;
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// How long the parts of a picture took the device [ms].
struct PassTimes {
    double shadow = 0;     ///< depth seen from the sun
    double surface = 0;    ///< what the eye sees: colours, normals, depth
    double occlusion = 0;  ///< ambient occlusion from that depth
    double light = 0;      ///< the light on it, the sky, and volumes
    double finish = 0;     ///< lines, smooth edges, and the way into the target
    double sum() const { return shadow + surface + occlusion + light + finish; }  ///< [ms]
};

/// What a picture shows, pixel by pixel, for programs that learn to see. Rows from top to bottom.
struct Buffers {
    int width = 0, height = 0;
    std::vector<float> depths_m;   ///< along the line of sight of the camera; 0: sky
    std::vector<float> normals;    ///< unit, world axes, three a pixel; 0, 0, 0: sky
    std::vector<uint32_t> labels;  ///< Item::label; 0: sky, floor, or an item without one
};

/// Draws pictures. Has a GL context of its own, which it makes current inside each call only: the
/// caller's is current again afterwards. One thread at a time. While EGL refuses that, as it does
/// beside a context of GLX, nothing is drawn or copied; what returns a Result says so. See
/// RendererDef::callers_context for the other case.
class Renderer {
  public:
    /// The error says what is missing: no EGL, no OpenGL 3.3, the text of a shader's compiler.
    static Result<std::unique_ptr<Renderer>> create(const RendererDef& def = {});
    ~Renderer();

    /// Copies the triangles to the device, and which textures lie on them. What Mesh::validate()
    /// refuses is an empty mesh; so is any while EGL refuses the renderer's context.
    MeshId add_mesh(const Mesh& mesh, const Skin& skin = {});
    /// Replaces the triangles of a mesh likewise; no textures are left on them.
    void set_mesh(MeshId id, const Mesh& mesh);
    /// The id may be given out again.
    void remove_mesh(MeshId id);

    /// Copies the pixels to the device, and smaller copies for what is far. The error says what is
    /// wrong with them.
    Result<TextureId> add_texture(const TextureData& data);
    /// Meshes that have it show their colours from then on. The id may be given out again.
    void remove_texture(TextureId id);

    /// Copies the voxels to the device. The error says what is wrong with them.
    Result<VolumeId> add_volume(const VolumeData& data);
    /// Replaces the voxels of a volume. Where the device has no memory for them there is no volume
    /// any more, and its id may be given out again.
    Status set_volume(VolumeId id, const VolumeData& data);
    /// The id may be given out again.
    void remove_volume(VolumeId id);

    /// Draws a picture and waits for it. Items without a mesh, or with a pose that is not finite,
    /// are left out.
    Result<Image> render(const View& view);
    /// Draws a picture into the lower left corner of a framebuffer of the context (0: the window's)
    /// and does not wait for it. Only with RendererDef::callers_context. Afterwards the framebuffer
    /// is bound, and its viewport is the picture.
    Status draw(const View& view, uint32_t framebuffer);
    /// Depths, normals and labels of what a picture of this view shows. Waits for the device.
    Result<Buffers> buffers(const View& view);
    /// Of the last picture that the device has finished.
    PassTimes pass_times() const;

    /// As the GL driver calls it.
    const std::string& device_name() const;

  private:
    struct Impl;
    explicit Renderer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Adds the loose soil of a mesher, as of its last update(): for each voxel kVoxelGroups groups of
/// grains in a full one, as many in proportion where there is less, the last one in part. And what
/// rolls along the ground: a flat group on each column, as full as its amount.
void append_grains(const SurfaceMesher& mesher, std::vector<GrainGroup>& grains);
/// Groups of grains that stand for a voxel full of soil.
inline constexpr int kVoxelGroups = 4;

/// Adds the dust over soil that falls, flies or rolls fast, as of the last update(); a fixed part
/// of the voxels and columns stands for all.
void append_dust(const SurfaceMesher& mesher, std::vector<DustPuff>& dust);

/// The meshes of a SurfaceMesher in a Renderer, kept up to date tile by tile. Tiles share a mesh of
/// the renderer by the patch: few calls draw them all.
class SurfaceItems {
  public:
    /// Both must outlive it.
    SurfaceItems(Renderer& renderer, const SurfaceMesher& mesher, float grain_m);
    ~SurfaceItems();
    SurfaceItems(const SurfaceItems&) = delete;
    SurfaceItems& operator=(const SurfaceItems&) = delete;

    /// Uploads the patches with tiles meshed since the last call.
    void update();
    /// Adds the patches that have triangles.
    void append_to(std::vector<Item>& items) const;

  private:
    static constexpr int kPatchSide = 4;  ///< tiles of a patch along each axis
    struct Patch {
        MeshId mesh;
        uint64_t revision_sum = 0;
        bool empty = true;
    };
    Renderer& renderer_;
    const SurfaceMesher& mesher_;
    float grain_m_;
    int patch_count_x_;
    std::vector<Patch> patches_;
    Mesh gathered_;
};

}  // namespace bsoil::render
#pragma GCC visibility pop
