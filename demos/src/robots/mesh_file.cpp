#include "mesh_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "files/data_files.h"

namespace bsoil::scene {
namespace fs = std::filesystem;

Result<std::string> find_robot_file(const char* what, const std::string& name,
                                    const std::string& named_by) {
    constexpr std::string_view kPackage = "package://", kFile = "file://";
    std::error_code ignored;
    const fs::path folder = fs::absolute(named_by, ignored).parent_path();
    std::vector<fs::path> places;
    if (name.starts_with(kPackage)) {
        const std::string full = name.substr(kPackage.size());
        const size_t slash = full.find('/');
        for (fs::path above = folder; above.has_relative_path(); above = above.parent_path()) {
            places.push_back(above / full);
            if (slash != std::string::npos) places.push_back(above / full.substr(slash + 1));
        }
    } else {
        places.push_back(folder / (name.starts_with(kFile) ? name.substr(kFile.size()) : name));
    }
    for (const fs::path& place : places) {
        if (fs::is_regular_file(place, ignored)) return place.lexically_normal().string();
    }
    std::string looked_for;
    for (const fs::path& place : places) {
        looked_for += (looked_for.empty() ? "" : ", ") + place.lexically_normal().string();
    }
    return Error{fmt::format("the {} \"{}\" is not there; looked for {}; put it there", what, name,
                             looked_for)};
}

Result<TriangleMesh> read_robot_mesh(const std::string& path, Vec3 scale, MeshSkin* skin) {
    if (!is_finite(scale) || scale.x == 0 || scale.y == 0 || scale.z == 0) {
        return Error{fmt::format("{}: the scale {} {} {} must be finite and not 0", path, scale.x,
                                 scale.y, scale.z)};
    }
    auto mesh = read_mesh(path, skin);
    if (!mesh) return mesh;
    for (Vec3& p : mesh->vertices) p = {p.x * scale.x, p.y * scale.y, p.z * scale.z};
    if (scale.x * scale.y * scale.z < 0) {
        for (auto& triangle : mesh->triangles) std::swap(triangle[1], triangle[2]);
    }
    return mesh;
}

}  // namespace bsoil::scene
