/// Shadow maps of one sun, each for more of the scene than the one before, side by side in one
/// texture.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#pragma GCC visibility push(default)
namespace bsoil::render {

inline constexpr size_t kCascadesMost = 3;

struct ShadowCascade {
    glm::mat4 clip{1};  ///< world axes about the eye -> its clip space
    double texel_m = 0;
};

/// What the maps have to show, about the eye.
struct ShadowScene {
    glm::dvec3 center{0}, target{0}, to_sun{0}, up{0};
    double radius = 1;
    double sight_m = 1;  ///< from the eye to the target
};

/// How far the maps reach, at most `count_most` of them. One for a scene that is not much larger
/// than what the camera looks at; else the first is about the target, the last has the whole scene.
std::vector<double> cascade_radii(const ShadowScene& scene, size_t count_most);
std::vector<ShadowCascade> make_cascades(const ShadowScene& scene, int map_size, size_t count_most);

}  // namespace bsoil::render
#pragma GCC visibility pop
