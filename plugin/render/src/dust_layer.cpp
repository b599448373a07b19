#include "dust_layer.h"

#include <algorithm>
#include <cmath>

#include "random_share.h"

namespace bsoil::render {
namespace {

constexpr double kLifeS = 1.6;
/// Radius at the beginning and at the end [voxels].
constexpr double kRadiusFirst = 1.5, kRadiusLast = 7;
constexpr double kRise = 0.15;      ///< [m/s]
constexpr double kAlong = 0.08;     ///< of the soil's speed that dust keeps
constexpr double kAsideVoxels = 1;  ///< clouds begin this far from their voxel, at most
constexpr double kOpacityMost = 0.3;
/// A picture has no more, so that it costs no more: beyond that some are left out.
constexpr size_t kCloudsMost = 512;

}  // namespace

void DustLayer::create() {
    layout_ = GlVertexArray("dust");
    instances_ = GlBuffer("clouds of dust");
    glBindVertexArray(layout_.name());
    glBindBuffer(GL_ARRAY_BUFFER, instances_.name());
    for (GLuint a = 0; a < sizeof(Cloud) / sizeof(glm::vec4); ++a) {
        glEnableVertexAttribArray(a);
        glVertexAttribPointer(a, 4, GL_FLOAT, GL_FALSE, sizeof(Cloud),
                              reinterpret_cast<const void*>(a * sizeof(glm::vec4)));
        glVertexAttribDivisor(a, 1);
    }
    glBindVertexArray(0);
}

void DustLayer::fill(const View& view, const Frame& frame) {
    clouds_.clear();
    bounds_ = {1, 1, -1, -1};
    const size_t stride = view.dust.size() / kCloudsMost + 1;
    for (size_t i = 0; i < view.dust.size(); i += stride) {
        const DustPuff& puff = view.dust[i];
        glm::dvec3 chance;
        for (uint32_t axis = 0; axis < 3; ++axis) chance[axis] = random_share(3 * puff.seed + axis);
        const double turns = view.time_s / kLifeS + chance.x;
        const double age = turns - std::floor(turns);
        const double side_m = static_cast<double>(puff.side_m);
        const glm::dvec3 velocity(puff.velocity_m_s.x, puff.velocity_m_s.y, puff.velocity_m_s.z);
        const glm::dvec3 begin(puff.center.x, puff.center.y, puff.center.z);
        const glm::dvec3 level = velocity - glm::dot(velocity, frame.up) * frame.up;
        const glm::dvec3 at = begin - frame.eye + kAsideVoxels * side_m * (2.0 * chance - 1.0) +
                              age * kLifeS * (kAlong * level + kRise * frame.up);
        const double radius = side_m * (kRadiusFirst + age * (kRadiusLast - kRadiusFirst));
        // Comes fast and goes slowly; the same dust over a larger disk hides less.
        const double fade = 6.75 * age * (1 - age) * (1 - age);
        const double alpha = kOpacityMost * static_cast<double>(puff.strength) * fade;
        const glm::vec4 clip = frame.clip * glm::vec4(at, 1);
        if (clip.w < radius) continue;
        const auto span_of = [&](int axis) {
            return static_cast<float>(radius * frame.projection[axis][axis] / clip.w);
        };
        const float span_x = span_of(0), span_y = span_of(1);
        const float middle_x = clip.x / clip.w, middle_y = clip.y / clip.w;
        if (std::abs(middle_x) > 1 + span_x || std::abs(middle_y) > 1 + span_y) continue;
        bounds_.x = std::min(bounds_.x, middle_x - span_x);
        bounds_.y = std::min(bounds_.y, middle_y - span_y);
        bounds_.z = std::max(bounds_.z, middle_x + span_x);
        bounds_.w = std::max(bounds_.w, middle_y + span_y);
        clouds_.push_back({glm::vec4(at, radius),
                           glm::vec4(puff.color[0], puff.color[1], puff.color[2], alpha),
                           glm::vec4(chance, 0)});
    }
    count_ = static_cast<GLsizei>(clouds_.size());
    if (is_empty()) return;
    std::stable_sort(clouds_.begin(), clouds_.end(), [](const Cloud& a, const Cloud& b) {
        return glm::length(glm::vec3(a.center_radius)) > glm::length(glm::vec3(b.center_radius));
    });
    glBindBuffer(GL_ARRAY_BUFFER, instances_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(clouds_.size() * sizeof(Cloud)),
                 clouds_.data(), GL_STREAM_DRAW);
}

void DustLayer::draw() const {
    glBindVertexArray(layout_.name());
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count_);
}

}  // namespace bsoil::render
