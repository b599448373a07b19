#include "mesh/vertex_writer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace bsoil::mesh {
namespace {

GridVector unit(GridVector v) {
    const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return length > 0 ? GridVector{v.x / length, v.y / length, v.z / length} : GridVector{0, 0, 1};
}

void push(std::vector<float>& list, GridVector v) {
    const float values[3] = {v.x, v.y, v.z};
    list.insert(list.end(), values, values + 3);
}

}  // namespace

VertexWriter::VertexWriter(const TileSource& source, const SurfaceMeshDef& def) {
    const GridFrame& frame = source.frame();
    const Quat& q = frame.grid_to_world.rotation;
    const Vec3 position = frame.grid_to_world.position - def.origin_m;
    rotation_ = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
    origin_ = {position.x, position.y, position.z};
    voxel_m_ = frame.voxel_m;
    if (def.layer == SurfaceMeshDef::Layer::terrain) {
        is_terrain_ = true;
        looks_.push_back({def.terrain_color, {}, 0});
        return;
    }
    has_water_ = source.has_water();
    for (const MaterialDef& material : source.materials()) {
        Look look{material.color, {}, 0};
        look.weights[std::min(looks_.size(), look.weights.size() - 1)] = 255;
        looks_.push_back(look);
        palette_.push_back(material.color);
    }
    if (palette_.size() < 2) palette_.clear();
}

bool VertexWriter::take_colors(const std::vector<MaterialDef>& materials) {
    bool has_changed = false;
    for (size_t m = 0; !is_terrain_ && m < std::min(looks_.size(), materials.size()); ++m) {
        if (looks_[m].color == materials[m].color) continue;
        has_changed = true;
        looks_[m].color = materials[m].color;
        if (!palette_.empty()) palette_[m] = materials[m].color;
    }
    return has_changed;
}

void VertexWriter::begin(Mesh& mesh) const {
    mesh.clear();
    mesh.palette = palette_;
}

GridVector VertexWriter::rotated(GridVector v) const {
    const Eigen::Vector3f to = (rotation_ * Eigen::Vector3d(v.x, v.y, v.z)).cast<float>();
    return {to.x(), to.y(), to.z()};
}

void VertexWriter::add(Mesh& mesh, GridVector position, GridVector outward,
                       const Look& look) const {
    const Eigen::Vector3d in_grid(position.x, position.y, position.z);
    const Eigen::Vector3f at = (origin_ + voxel_m_ * (rotation_ * in_grid)).cast<float>();
    push(mesh.positions, {at.x(), at.y(), at.z()});
    push(mesh.normals, rotated(unit(outward)));
    mesh.colors.insert(mesh.colors.end(), look.color.begin(), look.color.end());
    if (!palette_.empty()) mesh.weights.push_back(look.weights);
    if (has_water_) mesh.wetness.push_back(look.wetness);
}

void VertexWriter::add_copy(Mesh& mesh, uint32_t vertex, GridVector outward) const {
    for (size_t k = 0; k < 3; ++k) {
        mesh.positions.push_back(mesh.positions[3 * vertex + k]);
        mesh.colors.push_back(mesh.colors[3 * vertex + k]);
    }
    if (!palette_.empty()) mesh.weights.push_back(MaterialWeights(mesh.weights[vertex]));
    if (has_water_) mesh.wetness.push_back(uint8_t{mesh.wetness[vertex]});
    push(mesh.normals, rotated(outward));
}

const Look& VertexWriter::look_of(uint8_t material) const {
    return looks_[std::min<size_t>(material, looks_.size() - 1)];
}

/// The mean of the materials weighed; black where none is.
Color VertexWriter::mean_color(const MaterialWeights& weights) const {
    int sum = 0;
    for (const uint8_t weight : weights) sum += weight;
    Color mean{};
    for (size_t m = 0; sum > 0 && m < palette_.size(); ++m) {
        const float share = static_cast<float>(weights[m]) / static_cast<float>(sum);
        for (size_t c = 0; c < 3; ++c) mean[c] += share * palette_[m][c];
    }
    return mean;
}

Look VertexWriter::look_inside(const DisplayField& field, int i, int j, float z) const {
    return look_mixed(field.material(i, j, z), field.mixture(i, j, z));
}

Look VertexWriter::look_mixed(uint8_t material, const MixedLayer* mixture) const {
    Look look = look_of(material);
    if (!mixture) return look;
    if (!palette_.empty() && mixture->weights != MaterialWeights{}) {
        look = {mean_color(mixture->weights), mixture->weights, 0};
    }
    look.wetness = mixture->wetness;
    const float bright = wet_brightness(static_cast<float>(look.wetness) / 255);
    for (float& channel : look.color) channel *= bright;
    return look;
}

Look VertexWriter::look_at(const DisplayField& field, int i, int j, float z) const {
    const Look* bare = field.bare_look(i, j, z);
    return bare ? *bare : look_inside(field, i, j, z);
}

}  // namespace bsoil::mesh
