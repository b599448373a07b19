#include "shadow_cascades.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace bsoil::render {
namespace {

constexpr double kNearSights = 2;  ///< radius of the first map about the target, in sights
/// A map that has so many times the radius of the one before would be too coarse beside it.
constexpr double kStepMost = 8;

/// An upright of the sun's pictures: any that is not along its light.
glm::dvec3 upright_of(const ShadowScene& scene) {
    const glm::dvec3& up = scene.up;
    for (const glm::dvec3& upright : {up, glm::dvec3(up.y, up.z, up.x)}) {
        if (std::abs(glm::dot(scene.to_sun, upright)) < 0.99) return upright;
    }
    return {1, 0, 0};  // both are along a diagonal of the axes
}

}  // namespace

std::vector<double> cascade_radii(const ShadowScene& scene, size_t count_most) {
    const double near = kNearSights * scene.sight_m;
    if (scene.radius < near) return {scene.radius};
    std::vector<double> radii{near};
    if (count_most > 2 && scene.radius > kStepMost * near) {
        radii.push_back(std::sqrt(near * scene.radius));
    }
    if (count_most > 1) radii.push_back(scene.radius);
    return radii;
}

std::vector<ShadowCascade> make_cascades(const ShadowScene& scene, int map_size,
                                         size_t count_most) {
    std::vector<ShadowCascade> cascades;
    const glm::dvec3 sun_up = upright_of(scene);
    for (const double radius : cascade_radii(scene, count_most)) {
        const glm::dvec3 center = radius >= scene.radius ? scene.center : scene.target;
        const double depth_radius = scene.radius + glm::length(scene.center - center);
        const glm::dmat4 look = glm::lookAt(center + depth_radius * scene.to_sun, center, sun_up);
        const glm::dmat4 box = glm::ortho(-radius, radius, -radius, radius, 0.0, 2 * depth_radius);
        cascades.push_back({glm::mat4(box * look), 2 * radius / map_size});
    }
    return cascades;
}

}  // namespace bsoil::render
