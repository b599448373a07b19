#include "grain_layer.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "random_share.h"

namespace bsoil::render {
namespace {

constexpr int kCorners = 3;  ///< a grain is a triangle
/// Grains of the parts in which a group is drawn, each with a shift of its own: a group that is not
/// full costs as many as it has.
constexpr int kPartGrains = 32;
constexpr int kPartsMost = kGroupGrains / kPartGrains;
static_assert(kGroupGrains % kPartGrains == 0);
/// Grains that are seen under less than this [places where a pixel is lit] are drawn larger and
/// fewer. They hide as much. With this size the triangle of a grain has the area that belongs to
/// one such place: a smaller one is seen or not by chance.
constexpr double kGrainPixels = 1.4;
constexpr double kLargerMost = 4;
/// Grains on a slope that turns away from the eye by more than this (the cosine) are behind it.
constexpr double kTurnedAway = -0.15;
constexpr int kGroupFloats = 20;  ///< of a part on the device: see grain.vert
constexpr double kStreakS =
    0.008;  ///< how long a grain is seen: half a picture's time at 60 a second
constexpr double kStreakMost = 5;  ///< and how long it gets by that, in grains
/// Speeds are rounded to powers of this before they are multiplied by the time: a grain that is a
/// little faster than in the last picture has not travelled another way since the beginning.
constexpr double kSpeedStep = 1.25;

/// Where the grains of a group's part are shifted to in their cube, each way 0..1.
glm::dvec3 shift_of(const GrainGroup& group, uint32_t part, double time_s) {
    glm::dvec3 shift;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        shift[axis] = random_share(3 * (kPartsMost * group.seed + part) + axis);
    }
    const double speed = length(group.velocity_m_s);
    if (speed > 1e-3) {
        const double rounded =
            std::pow(kSpeedStep, std::round(std::log(speed) / std::log(kSpeedStep)));
        const Vec3 way = group.velocity_m_s * (rounded / speed * time_s / group.side_m);
        shift += glm::dvec3(way.x, way.y, way.z);
    }
    return shift - glm::floor(shift);
}

/// A group on the ground that nobody sees: behind its slope, behind the eye or beside the picture.
bool is_hidden(const GrainGroup& group, const glm::dvec3& center, const Frame& frame) {
    const glm::dvec3 normal(group.normal.x, group.normal.y, group.normal.z);
    if (glm::dot(normal, -center) < kTurnedAway * glm::length(center)) return true;
    const double radius = std::sqrt(3.0) / 2 * static_cast<double>(group.side_m);
    const glm::dvec4 clip = glm::dmat4(frame.clip) * glm::dvec4(center, 1);
    // In clip space a distance aside grows by the projection's scale.
    const double reach_x = radius * frame.projection[0][0],
                 reach_y = radius * frame.projection[1][1];
    return clip.w < -radius || std::abs(clip.x) > clip.w + radius + reach_x ||
           std::abs(clip.y) > clip.w + radius + reach_y;
}

}  // namespace

void GrainLayer::create() {
    layout_ = GlVertexArray("grains");
    offsets_ = GlBuffer("places of grains in a group");
    groups_ = GlBuffer("groups of grains");
    std::mt19937 random(66);  // any fixed seed
    std::vector<float> offsets;
    for (int g = 0; g < kPartGrains; ++g) {
        float place[3];
        for (float& p : place) p = static_cast<float>(random()) * 0x1p-32f;
        for (int corner = 0; corner < kCorners; ++corner) {
            offsets.insert(offsets.end(), place, place + 3);
        }
    }
    glBindVertexArray(layout_.name());
    glBindBuffer(GL_ARRAY_BUFFER, offsets_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(offsets.size() * sizeof(float)),
                 offsets.data(), GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    glBindBuffer(GL_ARRAY_BUFFER, groups_.name());
    for (GLuint a = 1; a <= kGroupFloats / 4; ++a) {
        glEnableVertexAttribArray(a);
        glVertexAttribPointer(a, 4, GL_FLOAT, GL_FALSE, kGroupFloats * sizeof(float),
                              reinterpret_cast<const void*>(4 * (a - 1) * sizeof(float)));
        glVertexAttribDivisor(a, 1);
    }
    glBindVertexArray(0);
}

void GrainLayer::append(const GrainGroup& group, const View& view, const Frame& frame,
                        double least_pixels) {
    const glm::dvec3 from_eye =
        glm::dvec3(group.center.x, group.center.y, group.center.z) - frame.eye;
    // What is in the air may cast a shadow into the picture.
    if (group.flatness > 0 && is_hidden(group, from_eye, frame)) return;
    const glm::vec3 center(from_eye);
    const double pixel_m =
        glm::length(glm::dvec3(center)) * 2 * std::tan(view.camera.fov_rad / 2) / view.height;
    const double larger =
        std::clamp(least_pixels * pixel_m / std::max(1e-9, static_cast<double>(group.grain_m)), 1.0,
                   kLargerMost);
    const float grain_m = group.grain_m * static_cast<float>(larger);
    const double speed = length(group.velocity_m_s);
    const double streak_s = std::min(
        kStreakS, kStreakMost * static_cast<double>(group.grain_m) / std::max(speed, 1e-9));
    const Vec3 streak = group.velocity_m_s * streak_s;
    const Vec3 flat = std::sqrt(static_cast<double>(group.flatness)) * group.normal;
    const double share = group.share > 0 ? std::min(1.0, static_cast<double>(group.share)) : 0;
    auto left = static_cast<int>(std::ceil(share * kGroupGrains / (larger * larger)));
    for (uint32_t part = 0; left > 0; ++part, left -= kPartGrains) {
        const glm::vec3 shift(shift_of(group, part, view.time_s));
        floats_.insert(floats_.end(), {center.x,
                                       center.y,
                                       center.z,
                                       group.side_m,  //
                                       shift.x,
                                       shift.y,
                                       shift.z,
                                       grain_m,  //
                                       static_cast<float>(streak.x),
                                       static_cast<float>(streak.y),
                                       static_cast<float>(streak.z),
                                       static_cast<float>(std::min(left, kPartGrains)),
                                       group.color[0],
                                       group.color[1],
                                       group.color[2],
                                       0,  //
                                       static_cast<float>(flat.x),
                                       static_cast<float>(flat.y),
                                       static_cast<float>(flat.z),
                                       0});
    }
}

void GrainLayer::fill(const View& view, const Frame& frame, int samples_aside) {
    const double least_pixels = kGrainPixels / samples_aside;
    floats_.clear();
    for (const GrainGroup& group : view.grains) {
        if (group.flatness <= 0) append(group, view, frame, least_pixels);
    }
    in_air_count_ = static_cast<GLsizei>(floats_.size() / kGroupFloats);
    for (const GrainGroup& group : view.grains) {
        if (group.flatness > 0) append(group, view, frame, least_pixels);
    }
    part_count_ = static_cast<GLsizei>(floats_.size() / kGroupFloats);
    if (is_empty()) return;
    glBindBuffer(GL_ARRAY_BUFFER, groups_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(floats_.size() * sizeof(float)),
                 floats_.data(), GL_STREAM_DRAW);
}

void GrainLayer::draw(GLsizei part_count) const {
    glDisable(GL_CULL_FACE);
    glBindVertexArray(layout_.name());
    glDrawArraysInstanced(GL_TRIANGLES, 0, kCorners * kPartGrains, part_count);
}

}  // namespace bsoil::render
