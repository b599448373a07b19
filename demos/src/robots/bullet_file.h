/// Worlds from .bullet files, as btDynamicsWorld::serialize writes them.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>
#include <vector>

#include "bsoil/geometry.h"
#include "bsoil/result.h"
#include "bsoil/soil_def.h"
#include "bullet_file_check.h"

class btBulletWorldImporter;
class btMultiBody;
class btMultiBodyDynamicsWorld;
class btMultiBodyLinkCollider;

namespace bsoil::scene {

/// Checks a file and says what is in it; see check_bullet_bytes(). Error: names the file and what
/// is wrong with it.
Result<BulletFileContent> check_bullet_file(const std::string& path);

/// A rigid body of a file, for who only wants to know of it.
struct BulletFileBody {
    std::string name;      ///< as BulletFile::Body has it
    double mass_kg = 0;    ///< 0: it does not move
    Pose pose;             ///< of its centre of mass, in the file's axes
    TriangleMesh surface;  ///< of its shape, in its own axes; empty: endless or unknown
};
struct BulletFileSurvey {
    std::vector<BulletFileBody> bodies;
    bool has_multibodies = false;
    std::vector<std::string> missing;  ///< as BulletFile::missing
};

/// Loads a file into a world of its own and looks round. Error: as BulletFile::load.
Result<BulletFileSurvey> survey_bullet_file(const std::string& path);

/// The objects of a .bullet file in a world. Gravity and solver settings stay the world's own.
class BulletFile {
  public:
    struct Body {
        std::string name;  ///< the file's, or its number where it has none or an earlier one's
        btRigidBody* body = nullptr;
    };

    /// Loads a file into a world that must outlive it. pose: of the file's axes in the world's.
    /// Multibodies need a btMultiBodyDynamicsWorld. Error: as check_bullet_file, Bullet cannot read
    /// it, or `pose` is given and a constraint holds a body to the world; then the world is as
    /// before.
    static Result<std::unique_ptr<BulletFile>> load(
        const std::string& path, btDiscreteDynamicsWorld& world,
        const btTransform& pose = btTransform::getIdentity());
    ~BulletFile();  ///< takes its objects out of the world and deletes them

    const std::vector<Body>& bodies() const { return bodies_; }
    /// What the file has and the world has not got, one sentence each: Bullet's importer drops
    /// bodies whose shape it does not know (heightfields, custom shapes) and reports success.
    const std::vector<std::string>& missing() const { return missing_; }

  private:
    BulletFile();
    /// Bullet's importer puts multibodies and their colliders into the world and forgets them.
    /// first: number of multibodies in the world before those of the file.
    void own_multibodies(int first);
    /// Bullet's importer creates multibodies by itself, where the file has them.
    void place_multibodies(const btTransform& pose);

    std::unique_ptr<btBulletWorldImporter> importer_;
    btMultiBodyDynamicsWorld* multibody_world_ = nullptr;
    std::vector<std::unique_ptr<btMultiBody>> multibodies_;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> link_colliders_;
    std::vector<Body> bodies_;
    std::vector<std::string> missing_;
};

}  // namespace bsoil::scene
