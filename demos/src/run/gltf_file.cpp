#include "gltf_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "files/data_files.h"
#include "files/json_text.h"
#include "files/text_file.h"

namespace bsoil::scene {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

constexpr int kFloat = 5126, kUnsigned = 5125, kVertices = 34962, kIndices = 34963;
constexpr size_t kTextureFileBytesMost = kTextureBytesMost;

/// A header, a chunk of JSON and one of numbers.
class GltfFile {
  public:
    explicit GltfFile(std::vector<std::string>& notes) : notes_(notes) {
        json_["asset"] = {{"version", "2.0"}, {"generator", "BulletSoil"}};
        json_["scene"] = 0;
    }

    void add(const NamedMesh& named) {
        const Mesh& mesh = named.look.mesh;
        Json plain, textured;
        plain["POSITION"] = add_vectors(mesh.positions, true);
        plain["NORMAL"] = add_vectors(mesh.normals, false);
        textured = plain;
        plain["COLOR_0"] = add_vectors(mesh.colors, false);
        if (!named.look.parts.empty()) textured["TEXCOORD_0"] = add_places(named.look.places);
        const size_t indices = add_view(mesh.indices.data(), 4 * mesh.indices.size(), kIndices);
        std::optional<size_t> own_material;
        Json primitives = Json::array();
        const auto add_run = [&](uint32_t begin, uint32_t end, const std::string& texture) {
            if (begin == end) return;
            std::optional<size_t> material = texture.empty() ? std::nullopt : textured_by(texture);
            const bool has_texture = material.has_value();
            if (!has_texture && !own_material) {
                own_material = add_material(named.name, named.roughness, {});
            }
            primitives.push_back({{"attributes", has_texture ? textured : plain},
                                  {"indices", add_index_run(indices, begin, end)},
                                  {"material", has_texture ? *material : *own_material}});
        };
        uint32_t begin = 0;
        for (const BodyLook::Part& part : named.look.parts) {
            add_run(begin, part.index_begin, {});
            begin = part.index_begin + part.index_count;
            add_run(part.index_begin, begin, part.texture_file);
        }
        add_run(begin, static_cast<uint32_t>(mesh.indices.size()), {});
        const size_t number = json_["meshes"].size();
        json_["meshes"].push_back({{"name", named.name}, {"primitives", primitives}});
        const Vec3 p = named.pose.position;
        const Quat q = named.pose.rotation;
        json_["nodes"].push_back({{"name", named.name},
                                  {"mesh", number},
                                  {"translation", {p.x, p.y, p.z}},
                                  {"rotation", {q.x, q.y, q.z, q.w}}});
        children_.push_back(number);
    }

    std::string bytes(bool z_up) {
        Json root{{"name", "world"}};
        // Lists without members are not glTF: of nothing there is the world's node.
        const bool is_empty = children_.empty();
        if (!is_empty) root["children"] = children_;
        const double half = std::sqrt(0.5);
        if (z_up) root["rotation"] = {-half, 0, 0, half};  // z up becomes y up
        json_["nodes"].push_back(root);
        json_["scenes"].push_back({{"nodes", {children_.size()}}});
        if (!is_empty) json_["buffers"].push_back({{"byteLength", numbers_.size()}});
        std::string text = json_text(json_);
        text.resize((text.size() + 3) / 4 * 4, ' ');
        numbers_.resize((numbers_.size() + 3) / 4 * 4, '\0');
        std::string file;
        const auto word = [&file](uint32_t value) {
            file.append(reinterpret_cast<const char*>(&value), 4);
        };
        word(0x46546C67);  // "glTF"
        word(2);
        const size_t binary = is_empty ? 0 : 8 + numbers_.size();
        word(static_cast<uint32_t>(12 + 8 + text.size() + binary));
        word(static_cast<uint32_t>(text.size()));
        word(0x4E4F534A);  // "JSON"
        file += text;
        if (is_empty) return file;
        word(static_cast<uint32_t>(numbers_.size()));
        word(0x004E4942);  // "BIN"
        file += numbers_;
        return file;
    }

  private:
    /// target 0: none, as for pictures.
    size_t add_view(const void* data, size_t size, int target) {
        numbers_.resize((numbers_.size() + 3) / 4 * 4, '\0');
        Json view{{"buffer", 0}, {"byteOffset", numbers_.size()}, {"byteLength", size}};
        if (target != 0) view["target"] = target;
        json_["bufferViews"].push_back(view);
        numbers_.append(static_cast<const char*>(data), size);
        return json_["bufferViews"].size() - 1;
    }

    size_t add_accessor(const Json& accessor) {
        json_["accessors"].push_back(accessor);
        return json_["accessors"].size() - 1;
    }

    size_t add_vectors(const std::vector<float>& values, bool bounds) {
        Json accessor{{"bufferView", add_view(values.data(), 4 * values.size(), kVertices)},
                      {"componentType", kFloat},
                      {"count", values.size() / 3},
                      {"type", "VEC3"}};
        if (bounds) {
            std::array<float, 3> low, high;
            low.fill(std::numeric_limits<float>::max());
            high.fill(-std::numeric_limits<float>::max());
            for (size_t i = 0; i < values.size(); ++i) {
                low[i % 3] = std::min(low[i % 3], values[i]);
                high[i % 3] = std::max(high[i % 3], values[i]);
            }
            accessor["min"] = low;
            accessor["max"] = high;
        }
        return add_accessor(accessor);
    }

    /// glTF counts from a texture's upper edge.
    size_t add_places(std::vector<float> places) {
        for (size_t i = 1; i < places.size(); i += 2) places[i] = 1 - places[i];
        return add_accessor({{"bufferView", add_view(places.data(), 4 * places.size(), kVertices)},
                             {"componentType", kFloat},
                             {"count", places.size() / 2},
                             {"type", "VEC2"}});
    }

    size_t add_index_run(size_t view, uint32_t begin, uint32_t end) {
        return add_accessor({{"bufferView", view},
                             {"byteOffset", 4 * begin},
                             {"componentType", kUnsigned},
                             {"count", end - begin},
                             {"type", "SCALAR"}});
    }

    size_t add_material(const std::string& name, double roughness, std::optional<size_t> texture) {
        Json look{{"metallicFactor", 0}, {"roughnessFactor", roughness}};
        if (texture) look["baseColorTexture"] = {{"index", *texture}};
        json_["materials"].push_back(
            {{"name", name}, {"doubleSided", true}, {"pbrMetallicRoughness", look}});
        return json_["materials"].size() - 1;
    }

    /// A material with this file on it; none where it cannot be read, which is noted once.
    std::optional<size_t> textured_by(const std::string& file) {
        const auto [found, is_new] = textured_.try_emplace(file);
        if (!is_new) return found->second;
        const auto picture = read_texture(file);
        const auto bytes = picture ? read_file(file, kTextureFileBytesMost)
                                   : Result<std::string>(Error{picture.error()});
        if (!bytes) {
            notes_.push_back(bytes.error());
            return {};
        }
        json_["images"].push_back(
            {{"bufferView", add_view(bytes->data(), bytes->size(), 0)}, {"mimeType", "image/png"}});
        json_["textures"].push_back({{"source", json_["images"].size() - 1}});
        const size_t slash = file.find_last_of('/');
        const std::string name = slash == std::string::npos ? file : file.substr(slash + 1);
        return found->second = add_material(name, 0.5, json_["textures"].size() - 1);
    }

    Json json_;
    Json children_ = Json::array();
    std::string numbers_;
    std::map<std::string, std::optional<size_t>> textured_;
    std::vector<std::string>& notes_;
};

}  // namespace

std::string glb(const std::vector<NamedMesh>& meshes, bool z_up, std::vector<std::string>& notes) {
    GltfFile file(notes);
    for (const NamedMesh& named : meshes) {
        file.add(named);
        notes.insert(notes.end(), named.look.notes.begin(), named.look.notes.end());
    }
    return file.bytes(z_up);
}

}  // namespace bsoil::scene
