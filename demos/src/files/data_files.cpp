#include "data_files.h"

#include <assimp/BaseImporter.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string_view>

#include "bsoil/limits.h"
#include "text_file.h"
#include "xml_check.h"

namespace bsoil::scene {
namespace {

/// Bytes of a height map's file, and of one buffer of a picture's reader: the pixels of the largest
/// picture, as bytes, twice over. Compressed data can stand for a thousand times its own size.
constexpr size_t kPictureBytes = size_t{512} << 20;

void* allocate_picture(size_t bytes) {
    return bytes > kPictureBytes ? nullptr : std::malloc(bytes);
}
void* reallocate_picture(void* old, size_t bytes) {
    return bytes > kPictureBytes ? nullptr : std::realloc(old, bytes);
}

}  // namespace
}  // namespace bsoil::scene

#define STBI_MALLOC(bytes) bsoil::scene::allocate_picture(bytes)
#define STBI_REALLOC(old, bytes) bsoil::scene::reallocate_picture(old, bytes)
#define STBI_FREE(old) std::free(old)
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace bsoil::scene {
namespace fs = std::filesystem;

namespace {

/// Bytes of a mesh file.
constexpr size_t kMeshCapacity = size_t{256} << 20;
/// Of all meshes of a file as often as its nodes show them: a part of a small file can be shown
/// over and over.
constexpr size_t kVertexCapacity = 20'000'000;
/// Pixels along a side and altogether, and bytes of a picture once unpacked.
constexpr int kPictureSideMax = limits::kHeightMapSideMax;
constexpr int64_t kPixelCapacity = int64_t{8193} * 8193;

/// Leaves an importer the format of one extension: assimp has dozens, and takes a file for what it
/// looks like, whatever its name.
void leave_only(Assimp::Importer& importer, const std::string& extension) {
    std::vector<Assimp::BaseImporter*> others;
    for (size_t i = 0; i < importer.GetImporterCount(); ++i) {
        if (Assimp::BaseImporter* one = importer.GetImporter(i);
            one != importer.GetImporter(extension.c_str())) {
            others.push_back(one);
        }
    }
    for (Assimp::BaseImporter* one : others) {
        importer.UnregisterLoader(one);
        delete one;  // which the importer has let go of
    }
}

/// Numbers of the materials' textures among the names, -1 where a material has none.
std::vector<int> name_textures(const aiScene& file, MeshSkin& skin) {
    std::map<std::string, int> numbers;
    std::vector<int> of_materials;
    for (unsigned m = 0; m < file.mNumMaterials; ++m) {
        aiString name;
        const bool has_one =
            file.mMaterials[m]->GetTexture(aiTextureType_DIFFUSE, 0, &name) == AI_SUCCESS &&
            name.length > 0;
        if (!has_one) {
            of_materials.push_back(-1);
            continue;
        }
        const auto [found, is_new] =
            numbers.emplace(name.C_Str(), static_cast<int>(skin.names.size()));
        if (is_new) skin.names.push_back(found->first);
        of_materials.push_back(found->second);
    }
    return of_materials;
}

/// Places in textures of a part's vertices; of a part without any all lie in the corner.
void append_places(const aiMesh& part, MeshSkin& skin) {
    const aiVector3D* places = part.HasTextureCoords(0) ? part.mTextureCoords[0] : nullptr;
    skin.has_places |= places != nullptr;
    const auto finite = [](float x) { return std::isfinite(x) ? x : 0.0f; };
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
        skin.places.push_back({places ? finite(places[v].x) : 0, places ? finite(places[v].y) : 0});
    }
}

/// False where there would be too many vertices. textures: of the materials, see name_textures().
bool append_node(const aiScene& file, const aiNode& node, const aiMatrix4x4& parent,
                 TriangleMesh& mesh, MeshSkin* skin, const std::vector<int>& textures) {
    const aiMatrix4x4 to_file = parent * node.mTransformation;
    for (unsigned m = 0; m < node.mNumMeshes; ++m) {
        const aiMesh& part = *file.mMeshes[node.mMeshes[m]];
        if (part.mNumVertices > kVertexCapacity - mesh.vertices.size() ||
            part.mNumFaces > kVertexCapacity - mesh.triangles.size()) {
            return false;
        }
        const int first = static_cast<int>(mesh.vertices.size());
        for (unsigned v = 0; v < part.mNumVertices; ++v) {
            const aiVector3D p = to_file * part.mVertices[v];
            mesh.vertices.push_back({p.x, p.y, p.z});
        }
        if (skin) append_places(part, *skin);
        for (unsigned f = 0; f < part.mNumFaces; ++f) {
            const aiFace& face = part.mFaces[f];
            if (face.mNumIndices != 3) continue;  // points and lines of the file
            mesh.triangles.push_back({first + static_cast<int>(face.mIndices[0]),
                                      first + static_cast<int>(face.mIndices[1]),
                                      first + static_cast<int>(face.mIndices[2])});
            if (!skin) continue;
            const bool is_bare =
                !part.HasTextureCoords(0) || part.mMaterialIndex >= textures.size();
            skin->textures.push_back(is_bare ? -1 : textures[part.mMaterialIndex]);
        }
    }
    for (unsigned c = 0; c < node.mNumChildren; ++c) {
        if (!append_node(file, *node.mChildren[c], to_file, mesh, skin, textures)) return false;
    }
    return true;
}

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);

/// What stb_image does not look at: it copies a chunk of no data to where it has no memory yet, and
/// after one that is longer than the file goes on somewhere within it.
Status check_picture_chunks(const std::string& path, std::string_view bytes) {
    constexpr size_t kHeadBytes = 8;  // length, big endian, and type
    constexpr size_t kCheckBytes = 4;
    bytes.remove_prefix(std::min(kPngSignature.size(), bytes.size()));
    while (bytes.size() >= kHeadBytes) {
        size_t length = 0;
        for (const char byte : bytes.substr(0, 4)) {
            length = length << 8 | static_cast<uint8_t>(byte);
        }
        const std::string_view type = bytes.substr(4, 4);
        bytes.remove_prefix(kHeadBytes);
        if (length == 0 && type == "IDAT") {
            return Error{path + ": has a chunk of pixels without data; save the picture anew"};
        }
        if (type == "IEND") return Done{};
        if (length + kCheckBytes > bytes.size()) break;
        bytes.remove_prefix(length + kCheckBytes);
    }
    return Error{path + ": ends before its last chunk does; save or copy the picture anew"};
}

}  // namespace

std::string find_file(const std::string& name, const std::string& scene_path) {
    std::error_code ignored;
    const fs::path folder = fs::absolute(scene_path, ignored).parent_path();
    constexpr std::string_view kData = "data:";
    if (!name.starts_with(kData)) {
        const fs::path path = folder / name;
        return fs::exists(path, ignored) ? path.string() : std::string();
    }
    const std::string inside = name.substr(kData.size());
    if (const char* data = std::getenv("BULLETSOIL_DATA")) {
        const fs::path path = fs::path(data) / inside;
        return fs::exists(path, ignored) ? path.string() : std::string();
    }
    for (fs::path above = folder; above.has_relative_path(); above = above.parent_path()) {
        const fs::path path = above / "shared/data" / inside;
        if (fs::exists(path, ignored)) return path.string();
    }
    return {};
}

Result<TriangleMesh> read_mesh(const std::string& path, MeshSkin* skin) {
    std::string extension = fs::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension != ".obj" && extension != ".stl" && extension != ".dae") {
        return Error{path + ": must end in .obj, .stl or .dae"};
    }
    const auto bytes = read_file(path, kMeshCapacity);
    if (!bytes) return Error{bytes.error()};
    if (extension == ".dae") {
        for (const Status& status : {check_xml_depth(*bytes), check_node_instances(*bytes)}) {
            if (!status) return Error{path + ": " + status.error()};
        }
    }
    Assimp::Importer importer;
    leave_only(importer, extension);
    // Joined vertices make a closed mesh closed; without the up-axis hint a DAE is turned to y up
    // on its own.
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    const unsigned textured = skin ? 0u : unsigned{aiComponent_TEXCOORDS};
    importer.SetPropertyInteger(
        AI_CONFIG_PP_RVC_FLAGS,
        static_cast<int>(aiComponent_NORMALS | textured | aiComponent_COLORS |
                         aiComponent_TANGENTS_AND_BITANGENTS));
    // Faces without corners end the program in what comes after the reading.
    const aiScene* file =
        importer.ReadFile(path, aiProcess_ValidateDataStructure | aiProcess_Triangulate |
                                    aiProcess_RemoveComponent | aiProcess_JoinIdenticalVertices);
    if (!file || !file->mRootNode) return Error{path + ": " + importer.GetErrorString()};
    TriangleMesh mesh;
    const std::vector<int> textures = skin ? name_textures(*file, *skin) : std::vector<int>();
    if (!append_node(*file, *file->mRootNode, aiMatrix4x4(), mesh, skin, textures)) {
        return Error{fmt::format("{}: more than {} vertices; simplify it", path, kVertexCapacity)};
    }
    if (mesh.triangles.empty()) {
        return Error{path + ": no triangles in it; export it with its faces"};
    }
    for (size_t i = 0; i < mesh.vertices.size(); ++i) {
        if (!is_finite(mesh.vertices[i])) {
            return Error{fmt::format("{}: vertex {} must be finite", path, i)};
        }
    }
    for (const auto& triangle : mesh.triangles) {
        for (const int v : triangle) {
            if (v < 0 || static_cast<size_t>(v) >= mesh.vertices.size()) {
                return Error{fmt::format("{}: a triangle names vertex {}, must be below {}", path,
                                         v, mesh.vertices.size())};
            }
        }
    }
    return mesh;
}

Result<ColorPicture> read_texture(const std::string& path) {
    constexpr size_t kTextureFileBytes = size_t{64} << 20;
    const auto bytes = read_file(path, kTextureFileBytes);
    if (!bytes) return Error{bytes.error()};
    if (!bytes->starts_with(kPngSignature)) {
        return Error{path + ": is no PNG, and textures of other formats are not read; convert it"};
    }
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes->data());
    const int size = static_cast<int>(bytes->size());
    ColorPicture picture;
    int channels = 0;
    if (!stbi_info_from_memory(data, size, &picture.width, &picture.height, &channels)) {
        return Error{fmt::format("{}: {}", path, stbi_failure_reason())};
    }
    if (std::max(picture.width, picture.height) > kTextureSideMax) {
        return Error{fmt::format("{}: {} x {} pixels; a side of a texture must have at most {}",
                                 path, picture.width, picture.height, kTextureSideMax)};
    }
    if (Status status = check_picture_chunks(path, *bytes); !status) return Error{status.error()};
    constexpr int kChannels = 4;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(data, size, &picture.width, &picture.height, &channels, kChannels),
        stbi_image_free);
    if (!pixels) return Error{fmt::format("{}: {}", path, stbi_failure_reason())};
    const size_t count = static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
    picture.rgba.assign(pixels.get(), pixels.get() + kChannels * count);
    return picture;
}

Result<HeightMapFill> read_height_map(const std::string& path, double min_height_m,
                                      double max_height_m) {
    const auto bytes = read_file(path, kPictureBytes);
    if (!bytes) return Error{bytes.error()};
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes->data());
    const int size = static_cast<int>(bytes->size());
    HeightMapFill fill;
    int channels = 0;
    if (!stbi_info_from_memory(data, size, &fill.width, &fill.height, &channels)) {
        return Error{fmt::format("{}: {}", path, stbi_failure_reason())};
    }
    if (fill.width > kPictureSideMax || fill.height > kPictureSideMax ||
        int64_t{fill.width} * fill.height > kPixelCapacity) {
        return Error{
            fmt::format("{}: {} x {} pixels; a side may have {}, both together 8193 x 8193; scale "
                        "the picture down",
                        path, fill.width, fill.height, kPictureSideMax)};
    }
    if (Status status = check_picture_chunks(path, *bytes); !status) return Error{status.error()};
    const std::unique_ptr<stbi_us, void (*)(void*)> pixels(
        stbi_load_16_from_memory(data, size, &fill.width, &fill.height, &channels, 1),
        stbi_image_free);
    if (!pixels) return Error{fmt::format("{}: {}", path, stbi_failure_reason())};
    const int count = fill.width * fill.height;
    fill.heights_m.reserve(static_cast<size_t>(count));
    for (int i = 0; i < count; ++i) {
        fill.heights_m.push_back(static_cast<float>(min_height_m + (max_height_m - min_height_m) *
                                                                       pixels.get()[i] / 65535.0));
    }
    return fill;
}

}  // namespace bsoil::scene
