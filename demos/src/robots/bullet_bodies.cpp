#include "robots/bullet_bodies.h"

#include <memory>
#include <utility>

namespace bsoil::scene {

void add_bullet_bodies(Scene& scene, BulletFileItem& item, BulletFileSurvey survey) {
    item.has_multibodies = survey.has_multibodies;
    for (const std::string& missing : survey.missing) {
        scene.warnings.push_back(scene.message(item.at, missing));
    }
    for (BulletFileBody& found : survey.bodies) {
        BodyItem& body = scene.bodies.emplace_back();
        body.at = item.at;
        body.name = item.name + '/' + found.name;
        body.bullet_file = item.name;
        body.mass_kg = found.mass_kg;
        body.pose = item.pose * found.pose;
        body.ignore_soil = item.ignore_soil;
        body.shape.shape = "mesh";
        body.shape.mesh = std::make_shared<const TriangleMesh>(std::move(found.surface));
    }
}

}  // namespace bsoil::scene
