/// .bullet files looked through before Bullet reads them: its importer follows every pointer and
/// believes every count of a file.
#pragma once

#include <string>

#include "bsoil/result.h"

namespace bsoil::scene {

/// What a file has of each kind.
struct BulletFileContent {
    int rigid_body_count = 0, collision_object_count = 0, constraint_count = 0;
    int multibody_count = 0, link_collider_count = 0, soft_body_count = 0;
};

/// Checks the bytes of a file, and puts right in them what Bullet need not be given: pointers to
/// nothing become null, and trees over triangle meshes, which Bullet makes anew, are taken out.
/// Error: what Bullet would trip over.
Result<BulletFileContent> check_bullet_bytes(std::string& bytes);

}  // namespace bsoil::scene
