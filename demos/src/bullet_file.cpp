#include "bullet_file.h"

#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletWorldImporter/btBulletWorldImporter.h>
#include <BulletWorldImporter/btMultiBodyWorldImporter.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <set>
#include <string_view>

#include "scene_shapes.h"

namespace bsoil::scene {
namespace {

// The file: 12 bytes "BULLETf-v324" (f or d: precision; - or _: pointers of 8 or 4 bytes; v: little
// endian), then blocks of code, size, old address, structure, count and content; the block DNA1
// describes the structures.
constexpr size_t kHeadBytes = 12;
constexpr std::string_view kMagic = "BULLET";

/// Reads on in a part of a file, never beyond it.
class Cursor {
  public:
    explicit Cursor(std::string_view bytes) : bytes_(bytes) {}
    bool good() const { return good_; }
    bool at_end() const { return at_ == bytes_.size(); }
    template <typename T>
    T get() {
        T value{};
        const std::string_view raw = get(sizeof(T));
        if (good_) std::memcpy(&value, raw.data(), sizeof(T));
        return value;
    }
    std::string_view get(size_t size) {
        if (size > bytes_.size() - at_) {
            good_ = false;
            return {};
        }
        at_ += size;
        return bytes_.substr(at_ - size, size);
    }
    void expect(std::string_view tag) { good_ = get(tag.size()) == tag && good_; }
    void skip_string() {
        const size_t end = bytes_.find('\0', at_);
        good_ = good_ && end != std::string_view::npos;
        if (good_) at_ = end + 1;
    }
    void align() { get((4 - at_ % 4) % 4); }

  private:
    std::string_view bytes_;
    size_t at_ = 0;
    bool good_ = true;
};

/// Sizes of the structures that a DNA block describes, by number; empty when it is damaged.
std::vector<size_t> structure_sizes(std::string_view dna) {
    Cursor in(dna);
    in.expect("SDNA");
    in.expect("NAME");
    const auto name_count = in.get<uint32_t>();
    for (uint32_t i = 0; i < name_count && in.good(); ++i) in.skip_string();
    in.align();
    in.expect("TYPE");
    const auto type_count = in.get<uint32_t>();
    for (uint32_t i = 0; i < type_count && in.good(); ++i) in.skip_string();
    in.align();
    in.expect("TLEN");
    std::vector<size_t> lengths;
    for (uint32_t i = 0; i < type_count && in.good(); ++i) lengths.push_back(in.get<uint16_t>());
    in.align();
    in.expect("STRC");
    const auto structure_count = in.get<uint32_t>();
    std::vector<size_t> sizes;
    for (uint32_t i = 0; i < structure_count && in.good(); ++i) {
        const auto type = in.get<uint16_t>(), fields = in.get<uint16_t>();
        if (!in.good() || type >= lengths.size()) return {};
        sizes.push_back(lengths[type]);
        for (uint16_t f = 0; f < fields && in.good(); ++f) {
            const auto field_type = in.get<uint16_t>(), field_name = in.get<uint16_t>();
            if (field_type >= type_count || field_name >= name_count) return {};
        }
    }
    return in.good() ? sizes : std::vector<size_t>{};
}

struct Block {
    std::string_view code, content;
    int32_t structure = 0, count = 0;
};

Result<std::string> read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(file), {}};
    if (!file) return Error{path + ": cannot be read"};
    return bytes;
}

Result<BulletFileContent> check_bytes(const std::string& bytes, const std::string& path) {
    const Error damaged{path + ": is damaged or cut short"};
    if (bytes.size() < kHeadBytes || !std::string_view(bytes).starts_with(kMagic))
        return Error{path + ": is not a .bullet file"};
    if (bytes[8] != 'v') return Error{path + ": is big endian, which is not supported"};
    if ((bytes[6] != 'f' && bytes[6] != 'd') || (bytes[7] != '-' && bytes[7] != '_'))
        return damaged;
    std::vector<Block> blocks;
    std::string_view dna;
    Cursor in(std::string_view(bytes).substr(kHeadBytes));
    while (!in.at_end() && in.good() && dna.empty()) {
        Block block;
        block.code = in.get(4);
        const auto size = in.get<int32_t>();
        in.get(bytes[7] == '-' ? 8 : 4);
        block.structure = in.get<int32_t>();
        block.count = in.get<int32_t>();
        if (!in.good() || size < 0) return damaged;
        block.content = in.get(static_cast<size_t>(size));
        (block.code == "DNA1" ? dna = block.content : (blocks.push_back(block), dna));
    }
    const std::vector<size_t> sizes = structure_sizes(dna);
    if (!in.good() || sizes.empty()) return damaged;
    BulletFileContent content;
    for (const Block& block : blocks) {
        // Names are of no structure; Bullet leaves them alone.
        if (block.structure < (block.code == "ARAY" ? -1 : 0) || block.count < 0 ||
            block.structure >= static_cast<int32_t>(sizes.size()))
            return damaged;
        const size_t item = block.structure < 0 ? 0 : sizes[static_cast<size_t>(block.structure)];
        if (static_cast<size_t>(block.count) * item > block.content.size()) return damaged;
        if (block.code == "RBDY") ++content.rigid_body_count;
        if (block.code == "COBJ") ++content.collision_object_count;
        if (block.code == "CONS") ++content.constraint_count;
        if (block.code == "MBDY") ++content.multibody_count;
        if (block.code == "MBLC") ++content.link_collider_count;
        if (block.code == "SBDY") ++content.soft_body_count;
    }
    return content;
}

/// Bullet's importer, placing bodies where they are wanted.
template <typename Base>
class PlacingImporter final : public Base {
  public:
    template <typename World>
    PlacingImporter(World& world, const btTransform& pose) : Base(&world), pose_(pose) {}
    void setDynamicsWorldInfo(const btVector3&, const btContactSolverInfo&) override {}
    btRigidBody* createRigidBody(bool is_dynamic, btScalar mass_kg, const btTransform& start,
                                 btCollisionShape* shape, const char* name) override {
        return Base::createRigidBody(is_dynamic, mass_kg, pose_ * start, shape, name);
    }
    btCollisionObject* createCollisionObject(const btTransform& start, btCollisionShape* shape,
                                             const char* name) override {
        return Base::createCollisionObject(pose_ * start, shape, name);
    }

  private:
    btTransform pose_;
};

}  // namespace

Result<BulletFileContent> check_bullet_file(const std::string& path) {
    const auto bytes = read_file(path);
    if (!bytes) return Error{bytes.error()};
    return check_bytes(*bytes, path);
}

Result<std::unique_ptr<BulletFile>> BulletFile::load(const std::string& path,
                                                     btDiscreteDynamicsWorld& world,
                                                     const btTransform& pose) {
    auto bytes = read_file(path);
    if (!bytes) return Error{bytes.error()};
    const auto content = check_bytes(*bytes, path);
    if (!content) return Error{content.error()};
    std::unique_ptr<BulletFile> file(new BulletFile);
    auto* multibody_world = dynamic_cast<btMultiBodyDynamicsWorld*>(&world);
    const int multibodies_before = multibody_world ? multibody_world->getNumMultibodies() : 0;
    file->multibody_world_ = multibody_world;
    if (multibody_world)
        file->importer_ =
            std::make_unique<PlacingImporter<btMultiBodyWorldImporter>>(*multibody_world, pose);
    else
        file->importer_ = std::make_unique<PlacingImporter<btBulletWorldImporter>>(world, pose);
    const bool is_loaded =
        file->importer_->loadFileFromMemory(bytes->data(), static_cast<int>(bytes->size()));
    if (multibody_world) {
        file->own_multibodies(multibodies_before);
        file->place_multibodies(pose);
    }
    if (!is_loaded) return Error{path + ": Bullet cannot read it"};

    btBulletWorldImporter& importer = *file->importer_;
    const bool is_moved = !(pose == btTransform::getIdentity());
    for (int i = 0; i < importer.getNumConstraints(); ++i) {
        const btTypedConstraint& c = *importer.getConstraintByIndex(i);
        if (is_moved && (&c.getRigidBodyA() == &btTypedConstraint::getFixedBody() ||
                         &c.getRigidBodyB() == &btTypedConstraint::getFixedBody()))
            return Error{path +
                         ": a constraint holds a body to the world; such a file cannot be "
                         "placed elsewhere"};
    }
    std::set<std::string> taken;
    for (int i = 0; i < importer.getNumRigidBodies(); ++i) {
        btRigidBody* body = btRigidBody::upcast(importer.getRigidBodyByIndex(i));
        if (!body) continue;
        const char* own = importer.getNameForPointer(body);
        std::string name = own ? own : "";
        if (name.empty() || taken.contains(name)) name = std::to_string(file->bodies_.size());
        taken.insert(name);
        file->bodies_.push_back({name, body});
    }
    const auto compare = [&](const char* what, int in_file, int made) {
        if (made < in_file)
            file->missing_.push_back(fmt::format("{}: {} of its {} {} are not in the world", path,
                                                 in_file - made, in_file, what));
    };
    compare(
        "rigid bodies and collision objects (Bullet's importer drops heightfields and shapes "
        "of its host's own)",
        content->rigid_body_count + content->collision_object_count, importer.getNumRigidBodies());
    compare("constraints", content->constraint_count, importer.getNumConstraints());
    compare("multibodies", content->multibody_count, static_cast<int>(file->multibodies_.size()));
    compare("colliders of multibodies", content->link_collider_count,
            static_cast<int>(file->link_colliders_.size()));
    compare("soft bodies", content->soft_body_count, 0);
    return file;
}

namespace {

/// Appends a shape's surface. What is endless or has no triangles is left out.
void append_surface(const btCollisionShape& shape, const btTransform& pose, TriangleMesh& mesh) {
    const auto add = [&](const btVector3& point) {
        mesh.vertices.push_back(from_bullet(pose * point));
        return static_cast<int>(mesh.vertices.size()) - 1;
    };
    if (shape.isCompound()) {
        const auto& parts = static_cast<const btCompoundShape&>(shape);
        for (int i = 0; i < parts.getNumChildShapes(); ++i)
            append_surface(*parts.getChildShape(i), pose * parts.getChildTransform(i), mesh);
    } else if (shape.isConvex()) {
        btShapeHull hull(static_cast<const btConvexShape*>(&shape));
        if (!hull.buildHull(0)) return;
        const int first = static_cast<int>(mesh.vertices.size());
        for (int i = 0; i < hull.numVertices(); ++i) add(hull.getVertexPointer()[i]);
        const unsigned* corner = hull.getIndexPointer();
        for (int t = 0; t < hull.numTriangles(); ++t, corner += 3)
            mesh.triangles.push_back({first + static_cast<int>(corner[0]),
                                      first + static_cast<int>(corner[1]),
                                      first + static_cast<int>(corner[2])});
    } else if (shape.isConcave() && !shape.isInfinite()) {
        struct Collector final : btTriangleCallback {
            std::vector<btVector3> corners;
            void processTriangle(btVector3* triangle, int, int) override {
                corners.insert(corners.end(), triangle, triangle + 3);
            }
        } found;
        btVector3 low, high;
        shape.getAabb(btTransform::getIdentity(), low, high);
        static_cast<const btConcaveShape&>(shape).processAllTriangles(&found, low, high);
        for (size_t i = 0; i + 2 < found.corners.size(); i += 3) {
            const int a = add(found.corners[i]);
            const int b = add(found.corners[i + 1]);
            mesh.triangles.push_back({a, b, add(found.corners[i + 2])});
        }
    }
}

}  // namespace

Result<BulletFileSurvey> survey_bullet_file(const std::string& path) {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    const auto file = BulletFile::load(path, world);
    if (!file) return Error{file.error()};
    BulletFileSurvey survey;
    survey.has_multibodies = world.getNumMultibodies() > 0;
    survey.missing = (*file)->missing();
    for (const BulletFile::Body& body : (*file)->bodies()) {
        BulletFileBody& found = survey.bodies.emplace_back();
        found.name = body.name;
        const btScalar inverse_mass = body.body->getInvMass();
        if (inverse_mass > 0) found.mass_kg = 1 / static_cast<double>(inverse_mass);
        found.pose = from_bullet(body.body->getWorldTransform());
        append_surface(*body.body->getCollisionShape(), btTransform::getIdentity(), found.surface);
    }
    return survey;
}

BulletFile::BulletFile() = default;

BulletFile::~BulletFile() {
    for (const auto& collider : link_colliders_)
        multibody_world_->removeCollisionObject(collider.get());
    for (const auto& multibody : multibodies_) multibody_world_->removeMultiBody(multibody.get());
    if (importer_) importer_->deleteAllData();  // shapes too, which the colliders have
}

void BulletFile::own_multibodies(int first) {
    std::set<const btMultiBody*> own;
    for (int i = first; i < multibody_world_->getNumMultibodies(); ++i) {
        multibodies_.emplace_back(multibody_world_->getMultiBody(i));
        own.insert(multibodies_.back().get());
    }
    for (int i = 0; i < multibody_world_->getNumCollisionObjects(); ++i) {
        auto* collider =
            btMultiBodyLinkCollider::upcast(multibody_world_->getCollisionObjectArray()[i]);
        if (collider && own.contains(collider->m_multiBody)) link_colliders_.emplace_back(collider);
    }
}

void BulletFile::place_multibodies(const btTransform& pose) {
    const btQuaternion turn = pose.getRotation();
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> positions;
    for (const auto& multibody : multibodies_) {
        multibody->setBasePos(pose * multibody->getBasePos());
        multibody->setWorldToBaseRot(multibody->getWorldToBaseRot() * turn.inverse());
        multibody->setBaseVel(quatRotate(turn, multibody->getBaseVel()));
        multibody->setBaseOmega(quatRotate(turn, multibody->getBaseOmega()));
        multibody->forwardKinematics(rotations, positions);
        multibody->updateCollisionObjectWorldTransforms(rotations, positions);
    }
    // For rays and contacts before the world's next step.
    for (const auto& collider : link_colliders_) multibody_world_->updateSingleAabb(collider.get());
}

}  // namespace bsoil::scene
