#include "bullet_file_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "bullet_dna.h"
#include "bullet_file_kinds.h"
#include "files/byte_cursor.h"

namespace bsoil::scene {
namespace {

// The file: "BULLETf-v324" (f or d: precision; - or _: pointers of 8 or 4 bytes; v: little endian;
// version), blocks of code, size, old address, structure, count and content; DNA1 describes them.
constexpr size_t kHeadBytes = 12;
constexpr std::string_view kMagic = "BULLET";

/// Compounds inside each other, and shapes, where each compound has its own as Bullet makes them.
constexpr int kCompoundDepth = 32;
constexpr int64_t kShapeCapacity = 100'000;
/// Of the solver, that a constraint may ask for. Ours: a thousand times Bullet's own 10. Larger,
/// and a damaged file's step takes minutes; smaller, and a host's own choice might be refused.
constexpr int64_t kIterationsMost = 10'000;

struct Block {
    std::string_view code;
    uint64_t address = 0;
    int structure = -1;
    size_t count = 0;
    size_t code_at = 0, at = 0, size = 0;  ///< in the file
};

/// Thrown where a check fails; the text says what is wrong.
struct Fault {
    std::string text;
};
[[noreturn]] void refuse(const std::string& text) { throw Fault{text}; }
void require(bool holds) {
    if (!holds) refuse("is damaged or cut short; take another copy of it");
}

class Checker {
  public:
    explicit Checker(std::string& bytes) : bytes_(bytes) {}

    BulletFileContent run() {
        read_blocks();
        BulletFileContent content;
        for (Block& block : blocks_) {
            check_code(block);
            if (block.code == "RBDY") ++content.rigid_body_count;
            if (block.code == "COBJ") ++content.collision_object_count;
            if (block.code == "CONS") ++content.constraint_count;
            if (block.code == "MBDY") ++content.multibody_count;
            if (block.code == "MBLC") ++content.link_collider_count;
            if (block.code == "SBDY") ++content.soft_body_count;
        }
        // Pointers first: what follows goes along them.
        for (const Block& block : blocks_) for_each_element(block, &Checker::check_pointers);
        for (const Block& block : blocks_) for_each_element(block, &Checker::check_structure);
        for (const Block& block : blocks_) {
            if (block.code == "SHAP") check_shape(block, 0);
            if (block.code == "CONS") check_constraint(block);
            if (block.code == "MBDY") check_multibody(block);
            if (block.code == "MBLC") check_link_collider(block);
        }
        return content;
    }

  private:
    using Structure = BulletDna::Structure;
    using Field = BulletDna::Field;

    void read_blocks() {
        if (bytes_.size() < kHeadBytes || !std::string_view(bytes_).starts_with(kMagic)) {
            refuse("is not a .bullet file; save one with btSerializer");
        }
        if (bytes_[8] != 'v') refuse("is big endian; save it on another machine");
        require((bytes_[6] == 'f' || bytes_[6] == 'd') && (bytes_[7] == '-' || bytes_[7] == '_'));
        is_double_ = bytes_[6] == 'd';
        pointer_size_ = bytes_[7] == '-' ? 8 : 4;
        version_ = std::atoi(bytes_.substr(9, 3).c_str());
        const std::string_view all(bytes_);
        ByteCursor in(all.substr(kHeadBytes));
        std::optional<size_t> dna_at;
        size_t dna_size = 0;
        while (!in.at_end() && !dna_at) {
            Block block;
            block.code_at = kHeadBytes + in.at();
            block.code = in.get(4);
            const auto size = in.get<int32_t>();
            block.address = pointer_size_ == 8 ? in.get<uint64_t>() : in.get<uint32_t>();
            block.structure = in.get<int32_t>();
            const auto count = in.get<int32_t>();
            require(in.good() && size >= 0 && count >= 0);
            block.count = static_cast<size_t>(count);
            block.size = static_cast<size_t>(size);
            block.at = kHeadBytes + in.at();
            in.get(block.size);
            require(in.good());
            if (block.code == "DNA1") {
                dna_at = block.at;
                dna_size = block.size;
            } else {
                blocks_.push_back(block);
            }
        }
        // Bullet takes the last place that looks like a description for it, and reads it by fours.
        require(dna_at && *dna_at % 4 == 0);
        for (const char* tag : {"DNA1", "SDNA"}) {
            if (all.find(tag) != all.rfind(tag)) refuse(fmt::format("must have {} once", tag));
        }
        auto dna = BulletDna::parse(all.substr(*dna_at, dna_size), pointer_size_);
        if (!dna) refuse(dna.error());
        dna_ = std::move(*dna);
        if (!dna_.fits(BulletDna::own())) {
            refuse("describes structures in another form; save it with this Bullet");
        }
        for (size_t i = 0; i < blocks_.size(); ++i) {
            const Block& block = blocks_[i];
            require(block.structure >= (block.code == "ARAY" ? -1 : 0) &&
                    block.structure < static_cast<int>(dna_.structures.size()));
            const size_t item = block.structure < 0 ? 1 : structure_of(block).size;
            require(block.count <= block.size / item);
            if (block.address != 0) require(by_address_.emplace(block.address, i).second);
        }
    }

    const Structure& structure_of(const Block& block) const {
        return dna_.structures[static_cast<size_t>(block.structure)];
    }
    std::string precise(const char* name) const {
        return name + std::string(is_double_ ? "DoubleData" : "FloatData");
    }

    /// What Bullet takes a block for by its code, it has to be.
    void check_code(Block& block) {
        const auto need = [&](const std::string& name) {
            require(block.count > 0 && dna_.is_a(block.structure, name));
        };
        if (block.code == "RBDY") need(precise("btRigidBody"));
        if (block.code == "COBJ") need(precise("btCollisionObject"));
        if (block.code == "DWLD") need(precise("btDynamicsWorld"));
        if (block.code == "MBDY") need(precise("btMultiBody"));
        if (block.code == "MBLC") need(precise("btMultiBodyLinkCollider"));
        if (block.code == "SHAP") need("btCollisionShapeData");
        if (block.code == "CONS") require(block.count > 0 && block.structure >= 0);
        // Trees over triangles are made anew.
        if (block.code == "QBVH" || block.code == "TMAP") {
            bytes_.replace(block.code_at, 4, "ARAY");
            block.code = std::string_view(bytes_).substr(block.code_at, 4);
        }
    }

    using Check = void (Checker::*)(const Structure&, size_t at);
    /// Every structure of a block, and those inside of it.
    void for_each_element(const Block& block, Check check) {
        if (block.structure < 0) return;
        for (size_t i = 0; i < block.count; ++i) {
            for_each_inside(structure_of(block), block.at + i * structure_of(block).size, check);
        }
    }
    void for_each_inside(const Structure& structure, size_t at, Check check) {
        (this->*check)(structure, at);
        for (const Field& field : structure.fields) {
            if (field.pointer_depth > 0 || field.structure < 0) continue;
            const Structure& inner = dna_.structures[static_cast<size_t>(field.structure)];
            for (size_t i = 0; i < field.count; ++i) {
                for_each_inside(inner, at + field.offset + i * inner.size, check);
            }
        }
    }

    template <typename T>
    T value(size_t at) const {
        T out;
        std::memcpy(&out, bytes_.data() + at, sizeof out);
        return out;
    }
    int64_t integer(const Structure& structure, size_t at, std::string_view name) const {
        const Field* field = structure.find(name);
        require(field && field->pointer_depth == 0 && field->type == "int" && field->count == 1);
        return value<int32_t>(at + field->offset);
    }
    uint64_t address(size_t at) const {
        return pointer_size_ == 8 ? value<uint64_t>(at) : value<uint32_t>(at);
    }
    /// Null where the pointer is, or the file has no such field.
    const Block* target(const Structure& structure, size_t at, std::string_view name) const {
        const Field* field = structure.find(name);
        if (!field || field->pointer_depth != 1) return nullptr;
        const auto found = by_address_.find(address(at + field->offset));
        return found == by_address_.end() ? nullptr : &blocks_[found->second];
    }

    bool points_well(const Field& field, const Block& to) const {
        if (field.type == "char") {
            return to.structure < 0 && std::string_view(bytes_).substr(to.at, to.size).find('\0') !=
                                           std::string_view::npos;
        }
        if (dna_.numbers.contains(field.type)) {
            return to.count > 0 && dna_.is_a(to.structure, field.type);
        }
        return to.code == "RBDY";  // a name for whichever precision
    }

    void check_pointers(const Structure& structure, size_t at) {
        for (const Field& field : structure.fields) {
            if (field.pointer_depth == 0) {
                check_numbers(field, at + field.offset);
                continue;
            }
            if (field.type == "void" && field.pointer_depth == 1) continue;  // not followed
            for (size_t i = 0; i < field.count; ++i) {
                const size_t pointer_at = at + field.offset + i * pointer_size_;
                const auto found = by_address_.find(address(pointer_at));
                const bool keep = found != by_address_.end() && field.pointer_depth == 1 &&
                                  field.type != "int" && field.type != "float" &&
                                  !field.type.starts_with("btQuantizedBvh") &&
                                  field.type != "btTriangleInfoMapData";
                if (keep) {
                    require(points_well(field, blocks_[found->second]));
                } else {
                    std::memset(&bytes_[pointer_at], 0, pointer_size_);
                }
            }
        }
    }

    void check_numbers(const Field& field, size_t at) const {
        for (size_t i = 0; i < field.count; ++i) {
            if ((field.type == "float" && !std::isfinite(value<float>(at + 4 * i))) ||
                (field.type == "double" && !std::isfinite(value<double>(at + 8 * i)))) {
                refuse(fmt::format("has a number that must be finite ({})", field.name));
            }
        }
    }

    void check_structure(const Structure& structure, size_t at) {
        for (const CountedPointer& c : kCounted) {
            if (structure.name != c.structure) continue;
            const int64_t count = integer(structure, at, c.count);
            const Block* to = target(structure, at, c.pointer);
            require(count >= 0 && (count == 0 || to) &&
                    (!to || static_cast<uint64_t>(count) <= to->count));
        }
        for (const EitherPointer& e : either()) {
            if (structure.name != e.structure) continue;
            const int64_t count = integer(structure, at, e.count);
            require(count >= 0);
            bool is_there = count == 0;
            for (const auto& [pointer, factor] : e.pointers) {
                if (const Block* to = target(structure, at, pointer)) {
                    require(static_cast<uint64_t>(count) <= to->count / factor);
                    is_there = true;
                }
            }
            require(is_there);
        }
        if (structure.name == "btCompoundShapeChildData") {
            require(target(structure, at, "m_childShape") != nullptr);
        }
        if (structure.name == "btMeshPartData") check_mesh_part(structure, at);
        if (structure.name == "btStridingMeshInterfaceData") check_mesh(structure, at);
    }

    /// Bullet's tree over no triangles writes to null.
    void check_mesh(const Structure& mesh, size_t at) const {
        const int64_t part_count = integer(mesh, at, "m_numMeshParts");
        const Block* parts = target(mesh, at, "m_meshPartsPtr");
        for (int64_t i = 0; i < part_count; ++i) {
            const Structure& part = structure_of(*parts);
            const size_t part_at = parts->at + static_cast<size_t>(i) * part.size;
            if (integer(part, part_at, "m_numTriangles") > 0) return;
        }
        refuse("has a mesh without triangles; save it without the mesh");
    }

    void check_mesh_part(const Structure& part, size_t at) const {
        const int64_t vertex_count = integer(part, at, "m_numVertices");
        const auto triangle_count = static_cast<size_t>(integer(part, at, "m_numTriangles"));
        const auto check = [&](const char* pointer, size_t per_triangle, size_t stride,
                               const auto& index_at) {
            const Block* to = target(part, at, pointer);
            if (!to) return;
            require(structure_of(*to).size == stride);
            for (size_t i = 0; i < triangle_count * per_triangle; ++i) {
                index_at(to->at + i * stride,
                         [&](int64_t v) { require(v >= 0 && v < vertex_count); });
            }
        };
        check("m_indices32", 3, 4, [&](size_t p, const auto& test) { test(value<int32_t>(p)); });
        check("m_indices16", 3, 4, [&](size_t p, const auto& test) { test(value<uint16_t>(p)); });
        check("m_3indices16", 1, 8, [&](size_t p, const auto& test) {
            for (size_t k = 0; k < 3; ++k) test(value<uint16_t>(p + 2 * k));
        });
        check("m_3indices8", 1, 4, [&](size_t p, const auto& test) {
            for (size_t k = 0; k < 3; ++k) test(value<uint8_t>(p + k));
        });
    }

    /// Of the first element; Bullet makes no more of them. False where it makes none of it.
    bool check_shape(const Block& block, int depth) {
        require(dna_.is_a(block.structure, "btCollisionShapeData"));
        if (++shape_count_ > kShapeCapacity || depth > kCompoundDepth) {
            refuse(fmt::format("must have at most {} shapes, and compounds at most {} deep",
                               kShapeCapacity, kCompoundDepth));
        }
        const Structure& base =
            dna_.structures[static_cast<size_t>(dna_.numbers.find("btCollisionShapeData")->second)];
        const int64_t type = integer(base, block.at, "m_shapeType");
        const auto kind = std::find_if(std::begin(kShapes), std::end(kShapes),
                                       [&](const Kind& k) { return k.number == type; });
        if (kind == std::end(kShapes)) return false;
        require(dna_.is_a(block.structure, kind->structure));
        const Structure& structure =
            dna_.structures[static_cast<size_t>(dna_.numbers.find(kind->structure)->second)];
        for (const char* axis : {"m_upAxis", "m_upIndex"}) {
            if (structure.find(axis)) {
                const int64_t up = integer(structure, block.at, axis);
                require(up >= 0 && up <= 2);
            }
        }
        if (type == MULTI_SPHERE_SHAPE_PROXYTYPE) {
            require(integer(structure, block.at, "m_localPositionArraySize") > 0);
        }
        if (type == CONVEX_HULL_SHAPE_PROXYTYPE) {
            require(integer(structure, block.at, "m_numUnscaledPoints") > 0);
        }
        if (type == COMPOUND_SHAPE_PROXYTYPE) {
            const int64_t count = integer(structure, block.at, "m_numChildShapes");
            const Block* children = target(structure, block.at, "m_childShapePtr");
            for (int64_t i = 0; i < count; ++i) {
                const Structure& child = structure_of(*children);
                check_shape(*target(child, children->at + static_cast<size_t>(i) * child.size,
                                    "m_childShape"),
                            depth + 1);
            }
        }
        return true;
    }

    /// Whether Bullet makes a body of the file: of one whose shape it does not know it makes none.
    bool is_made(const Block* body) {
        if (!body) return false;
        const auto number = dna_.numbers.find(precise("btCollisionObject"));
        require(number != dna_.numbers.end());
        const Block* shape = target(dna_.structures[static_cast<size_t>(number->second)], body->at,
                                    "m_collisionShape");
        return shape && shape->code == "SHAP" && check_shape(*shape, 0);
    }

    void check_constraint(const Block& block) {
        // Where its type stands depends on neither precision nor version.
        const auto base = dna_.numbers.find("btTypedConstraintData");
        require(base != dna_.numbers.end());
        const Structure& typed = dna_.structures[static_cast<size_t>(base->second)];
        require(structure_of(block).size >= typed.size);
        if (integer(typed, block.at, "m_overrideNumSolverIterations") > kIterationsMost) {
            refuse(fmt::format("must have constraints of at most {} iterations", kIterationsMost));
        }
        const int64_t type = integer(typed, block.at, "m_objectType");
        const auto kind = std::find_if(std::begin(kConstraints), std::end(kConstraints),
                                       [&](const ConstraintKind& k) { return k.number == type; });
        if (kind == std::end(kConstraints)) return;
        require(dna_.is_a(block.structure, !is_double_                ? kind->single
                                           : version_ >= kDoubleSince ? kind->double_now
                                                                      : kind->double_first));
        const Block* a = target(typed, block.at, "m_rbA");
        const Block* b = target(typed, block.at, "m_rbB");
        const bool has_a = is_made(a), has_b = is_made(b);
        // Bullet asks the first body of each constraint that has one of the two, and gears for
        // both.
        if ((has_b && !has_a) || (type == GEAR_CONSTRAINT_TYPE && has_a && !has_b)) {
            refuse("has a constraint of which Bullet makes one body; save both with it");
        }
    }

    void check_multibody(const Block& block) const {
        const Structure& body = structure_of(block);
        const int64_t count = integer(body, block.at, "m_numLinks");
        const Block* links = target(body, block.at, "m_links");
        for (int64_t i = 0; i < count; ++i) {
            const Structure& link = structure_of(*links);
            const size_t at = links->at + static_cast<size_t>(i) * link.size;
            const int64_t parent = integer(link, at, "m_parentIndex");
            require(parent >= -1 && parent < i);
            const int64_t type = integer(link, at, "m_jointType");
            const auto joint = std::find_if(std::begin(kJoints), std::end(kJoints),
                                            [&](const JointKind& k) { return k.number == type; });
            require(joint != std::end(kJoints) &&
                    integer(link, at, "m_dofCount") == joint->velocities &&
                    integer(link, at, "m_posVarCount") == joint->positions);
        }
    }

    void check_link_collider(const Block& block) const {
        const Structure& collider = structure_of(block);
        const Block* body = target(collider, block.at, "m_multiBody");
        const int64_t link = integer(collider, block.at, "m_link");
        require(body && body->code == "MBDY" && link >= -1 &&
                link < integer(structure_of(*body), body->at, "m_numLinks"));
    }

    std::string& bytes_;
    bool is_double_ = false;
    size_t pointer_size_ = 8;
    int version_ = 0;
    BulletDna dna_;
    std::vector<Block> blocks_;
    std::map<uint64_t, size_t> by_address_;
    int64_t shape_count_ = 0;
};

}  // namespace

Result<BulletFileContent> check_bullet_bytes(std::string& bytes) {
    try {
        return Checker(bytes).run();
    } catch (const Fault& fault) {
        return Error{fault.text};
    }
}

}  // namespace bsoil::scene
