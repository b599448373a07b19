#include "frame.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <iterator>

#include "bsoil/render/primitives.h"

namespace bsoil::render {
namespace {

constexpr double kCoarsePeriods = 8;  ///< fine periods in one of the coarse grain pattern
constexpr double kFadeBegin = 0.9;    ///< where the floor starts to fade, of the scene's radius
constexpr double kFadeEnd = 1.5;      ///< and is gone, at the distance to the target further out
/// Distance of the near plane: this share of the far plane's, but no less and no more than these
/// shares of the distance to the target. Ours: at most a 20th of it. Larger: one body that falls
/// out of the world takes what is near out of the picture; smaller: fewer bits of depth far off.
constexpr double kNearOfFar = 5e-4, kNearLeast = 0.01, kNearMost = 0.05;
constexpr float kFilmBegin =
    0.8f;  ///< saturation from which on water begins to stand out of the pores
constexpr float kDampGloss = 0.35f;  ///< of wet grains without a film
constexpr float kFilmGloss = 1.0f;
constexpr Color kFloorColor{0.50f, 0.52f, 0.55f};

/// Between loose grains sunlight comes through and is scattered: they are not as dark in each
/// other's shadow as a solid is.
const SurfaceMaterial kLooseGrains{glm::vec4(0), glm::vec4(0, 0, 0, 0.5f)};

glm::dvec3 to_glm(Vec3 v) { return {v.x, v.y, v.z}; }

glm::mat4 model_of(const Pose& pose, glm::dvec3 eye) {
    const glm::dvec3 columns[3] = {to_glm(rotate(pose.rotation, {1, 0, 0})),
                                   to_glm(rotate(pose.rotation, {0, 1, 0})),
                                   to_glm(rotate(pose.rotation, {0, 0, 1}))};
    const glm::dvec3 origin = to_glm(pose.position) - eye;
    return glm::mat4(glm::dmat4(glm::dvec4(columns[0], 0), glm::dvec4(columns[1], 0),
                                glm::dvec4(columns[2], 0), glm::dvec4(origin, 1)));
}

/// A square, two units wide, with its normal along `up`.
Mesh floor_mesh(Vec3 up) {
    const Vec3 aside = std::abs(up.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    Vec3 u = cross(aside, up);
    u = (1 / length(u)) * u;
    const Vec3 v = cross(up, u);
    return triangle_mesh({{-u - v, u - v, u + v, v - u}, {{0, 1, 2}, {0, 2, 3}}}, kFloorColor);
}

/// The six planes of a clip space, pointing inward.
std::array<glm::vec4, 6> clip_planes(const glm::mat4& clip) {
    const glm::mat4 rows = glm::transpose(clip);
    return {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
            rows[3] - rows[1], rows[3] + rows[2], rows[3] - rows[2]};
}

/// As an item is with so much water. A film lies on soil that is nearly full.
SurfaceMaterial wet_material(const SurfaceMaterial& dry, int step) {
    const float saturation = static_cast<float>(step) / kWetSteps;
    const float film = glm::smoothstep(kFilmBegin, 1.0f, saturation);
    SurfaceMaterial wet = dry;
    wet.look.y = std::max(dry.look.y, saturation * glm::mix(kDampGloss, kFilmGloss, film));
    wet.look.w = -film;
    return wet;
}

}  // namespace

Frame::Frame(const View& view, const ShadowMaps& maps, std::span<const GpuMesh> meshes,
             std::span<const GpuVolume> volumes, GpuMesh& floor) {
    eye = to_glm(view.camera.eye);
    const glm::dvec3 target = to_glm(view.camera.target) - eye;
    up = glm::normalize(to_glm(view.camera.up));
    to_sun = glm::normalize(to_glm(view.to_sun));
    sight_m = glm::length(target);

    glm::dvec3 low(1e300), high(-1e300);
    for (const Item& item : view.items) {
        if (item.mesh.value == 0 || item.mesh.value > meshes.size()) continue;
        if (!is_finite(item.pose)) continue;
        const GpuMesh& mesh = meshes[item.mesh.value - 1];
        if (!mesh.used || mesh.index_count == 0) continue;
        items.push_back({&mesh, &item, model_of(item.pose, eye), material_of(&item, mesh.is_wet)});
        for (int c = 0; c < 8; ++c) {
            const glm::dvec3 p(items.back().corner(c));
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    for (const GrainGroup& group : view.grains) {
        const glm::dvec3 center = to_glm(group.center) - eye;
        low = glm::min(low, center - 0.5 * group.side_m);
        high = glm::max(high, center + 0.5 * group.side_m);
    }
    for (const Volume& volume : view.volumes) {
        if (volume.volume.value == 0 || volume.volume.value > volumes.size()) continue;
        const GpuVolume& known = volumes[volume.volume.value - 1];
        const glm::dmat4 model(model_of(volume.pose, eye));
        for (int c = 0; known.used && c < 8; ++c) {
            const glm::dvec3 corner(c & 1 ? known.size[0] : 0, c & 2 ? known.size[1] : 0,
                                    c & 4 ? known.size[2] : 0);
            const glm::dvec3 p(model * glm::dvec4(volume.voxel_m * corner, 1));
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    if (!view.grains.empty()) {
        grain_material = static_cast<int>(std::min(materials.size(), kMaterialCapacity - 1));
        if (materials.size() < kMaterialCapacity) materials.push_back(kLooseGrains);
    }
    const bool is_empty = low.x > high.x;
    const glm::dvec3 center = is_empty ? glm::dvec3(0) : 0.5 * (low + high);
    const double radius = is_empty ? 1.0 : std::max(1e-3, 0.5 * glm::length(high - low));
    const std::vector<Placed> solids = items;  // the floor, which is added next, casts no shadow
    fade_begin_m = kFadeBegin * radius;
    fade_end_m = kFadeEnd * radius + sight_m;
    floor_center = center;
    if (view.floor_height_m) {
        floor.fill(floor_mesh({up.x, up.y, up.z}), {}, "floor");
        floor_center += (*view.floor_height_m - glm::dot(eye + center, up)) * up;
        const glm::dmat4 model =
            glm::scale(glm::translate(glm::dmat4(1), floor_center), glm::dvec3(fade_end_m));
        items.push_back({&floor, nullptr, glm::mat4(model), material_of(nullptr, false)});
    }

    if (view.cut) {
        const glm::dvec3 normal = to_glm(view.cut->normal);
        cut = glm::vec4(normal, glm::dot(normal, eye) - view.cut->offset);
    }

    // The near plane is far enough out for 24 bits of depth.
    const double far_m = glm::length(center) + radius + 2 * fade_end_m;
    const double near_m = std::clamp(kNearOfFar * far_m, kNearLeast * sight_m, kNearMost * sight_m);
    const double aspect = static_cast<double>(view.width) / view.height;
    look = glm::lookAt(glm::dvec3(0), target, up);
    projection = glm::perspective(view.camera.fov_rad, aspect, near_m, far_m);
    projection[2][0] = -view.camera.shift;  // clip x = ... + shift * distance
    clip = glm::mat4(projection * look);
    cascades =
        make_cascades({center, target, to_sun, up, radius, sight_m}, maps.size, maps.count_most);

    // Near items first: what they hide is not shaded. What is out of the picture is not drawn.
    for (const ShadowCascade& cascade : cascades) {
        const auto planes = clip_planes(cascade.clip);
        std::copy_if(solids.begin(), solids.end(), std::back_inserter(casters.emplace_back()),
                     [&](const Placed& placed) { return placed.is_seen(planes); });
    }
    const auto eye_planes = clip_planes(clip);
    std::erase_if(items, [&](const Placed& placed) { return !placed.is_seen(eye_planes); });
    std::stable_sort(items.begin(), items.end(), [](const Placed& a, const Placed& b) {
        if (!a.item || !b.item) return a.item != nullptr && !b.item;  // the floor last
        return a.distance() < b.distance();
    });
}

int Frame::material_of(const Item* item, bool is_wet) {
    SurfaceMaterial material;
    if (!item) {
        material.look.w = 1;
    } else {
        // A period has kGrainPeriod grains. Origins are reduced to one period in double precision.
        const double scale = item->grain_m > 0 ? 1.0 / (kGrainPeriod * item->grain_m) : 0;
        const glm::dvec3 periods = eye * scale;
        material.look = {scale, item->gloss, item->emission, 0};
        material.origin =
            glm::vec4(periods - kCoarsePeriods * glm::floor(periods / kCoarsePeriods), 0);
    }
    std::vector<SurfaceMaterial> rows{material};
    for (int step = 1; is_wet && step <= kWetSteps; ++step) {
        rows.push_back(wet_material(material, step));
    }
    const auto known = std::search(materials.begin(), materials.end(), rows.begin(), rows.end());
    const auto index = static_cast<size_t>(known - materials.begin());
    if (known != materials.end()) return static_cast<int>(index);
    if (materials.size() + rows.size() > kMaterialCapacity) return 0;
    materials.insert(materials.end(), rows.begin(), rows.end());
    return static_cast<int>(index);
}

glm::vec2 Frame::depth_to_distance() const { return glm::vec2(projection[2][2], projection[3][2]); }

glm::vec4 Frame::to_view() const {
    return glm::vec4(1 / projection[0][0], 1 / projection[1][1],
                     projection[2][0] / projection[0][0], projection[2][1] / projection[1][1]);
}

}  // namespace bsoil::render
