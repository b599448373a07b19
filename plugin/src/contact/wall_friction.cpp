#include "contact/wall_friction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace bsoil {
namespace {

/// What of `soil_kg` more passes a layer whose walls take `rate` times what is above `relief_kg`:
/// dW/ds = soil - rate (W - relief), s from 0 to 1 through the layer.
double passed_kg(double above_kg, double soil_kg, double rate, double relief_kg) {
    const double whole_kg = above_kg + soil_kg;
    if (!(rate > 0) || whole_kg <= relief_kg) return whole_kg;
    // Down to where the walls begin to hold, nothing is lost.
    const double free_kg = std::max(0.0, relief_kg - above_kg);
    const double share = soil_kg > 0 ? 1 - free_kg / soil_kg : 1;
    const double excess_kg = std::max(0.0, above_kg - relief_kg);
    const double x = rate * share;
    return relief_kg + excess_kg * std::exp(-x) - (soil_kg - free_kg) * std::expm1(-x) / x;
}

}  // namespace

double rest_pressure_factor(double friction_angle_rad) { return 1 - std::sin(friction_angle_rad); }

WallGrip wall_grip(const MaterialDef& material, double surface_friction, double cohesion_pa) {
    const double phi = material.friction_angle_rad;
    const double factor = rest_pressure_factor(phi);
    const double friction = surface_friction >= 0 ? surface_friction : material.tool_friction;
    return {std::min(friction, std::tan(phi)), factor, 2 * cohesion_pa * std::sqrt(factor)};
}

double hanging_share(Vec3 soil_velocity_m_s, Vec3 up, double rest_m_s) {
    const double speed_m_s = length(soil_velocity_m_s);
    if (speed_m_s <= rest_m_s) return 1;
    const double slipping = std::min(1.0, (speed_m_s - rest_m_s) / rest_m_s);
    return std::lerp(1.0, std::max(0.0, -dot(soil_velocity_m_s, up) / speed_m_s), slipping);
}

void WallFriction::list_layers(std::span<const LoadCell> cells) {
    low_x_ = low_y_ = low_z_ = std::numeric_limits<int>::max();
    int high_x = std::numeric_limits<int>::min(), high_y = high_x, high_z = high_x;
    for (const LoadCell& cell : cells) {
        low_x_ = std::min(low_x_, cell.x), high_x = std::max(high_x, cell.x);
        low_y_ = std::min(low_y_, cell.y), high_y = std::max(high_y, cell.y);
        low_z_ = std::min(low_z_, cell.z), high_z = std::max(high_z, cell.z);
    }
    width_ = high_x - low_x_ + 1, depth_ = high_y - low_y_ + 1;
    const auto layer_count = static_cast<size_t>(high_z - low_z_ + 1);
    layers_.resize(std::max(layers_.size(), layer_count));
    for (auto& layer : layers_) layer.clear();
    for (const LoadCell& cell : cells) {
        layers_[static_cast<size_t>(cell.z - low_z_)].push_back(&cell);
    }
    const auto column_count = static_cast<size_t>(width_) * static_cast<size_t>(depth_);
    layer_.assign(column_count, std::numeric_limits<int>::max());
    part_layer_.assign(column_count, std::numeric_limits<int>::max());
    cell_.assign(column_count, nullptr);
    weight_kg_.assign(column_count, 0);
    first_face_.assign(column_count, 0);
    last_face_.assign(column_count, 0);
}

void WallFriction::list_faces(std::span<const WallFace> faces) {
    face_order_.clear();
    for (size_t i = 0; i < faces.size(); ++i) {
        const WallFace& face = faces[i];
        const int x = face.voxel[0] - low_x_, y = face.voxel[1] - low_y_;
        if (x >= 0 && x < width_ && y >= 0 && y < depth_) face_order_.push_back(i);
    }
    const auto place = [&](size_t i) {
        const int* at = faces[i].voxel;
        return std::tuple(-at[2], at[1], at[0], i);
    };
    std::sort(face_order_.begin(), face_order_.end(),
              [&](size_t a, size_t b) { return place(a) < place(b); });
}

/// The columns of a layer that hang together with the first one.
void WallFriction::gather_part(int z, size_t first) {
    part_.assign(1, first);
    part_layer_[first] = z;
    const auto width = static_cast<size_t>(width_);
    for (size_t i = 0; i < part_.size(); ++i) {
        const size_t c = part_[i], x = c % width;
        const auto reach = [&](bool is_there, size_t next) {
            if (!is_there || layer_[next] != z || part_layer_[next] == z) return;
            part_layer_[next] = z;
            part_.push_back(next);
        };
        reach(x > 0, c - 1);
        reach(x + 1 < width, c + 1);
        reach(c >= width, c - width);
        reach(c + width < layer_.size(), c + width);
    }
}

/// The columns of a layer, and their faces.
void WallFriction::begin_layer(int z, std::span<const WallFace> faces, size_t& next_face) {
    for (const LoadCell* cell : layers_[static_cast<size_t>(z - low_z_)]) {
        const size_t c = column_of(cell->x, cell->y);
        if (layer_[c] != z + 1) weight_kg_[c] = 0;  // what came down before has come to the floor
        layer_[c] = z;
        cell_[c] = cell;
        first_face_[c] = last_face_[c] = 0;
    }
    const auto place = [&] { return faces[face_order_[next_face]].voxel; };
    const auto is_there = [&] { return next_face < face_order_.size(); };
    while (is_there() && place()[2] > z) ++next_face;
    while (is_there() && place()[2] == z) {
        const int* at = place();
        const size_t c = column_of(at[0], at[1]), first = next_face;
        while (is_there() && std::equal(at, at + 3, place())) ++next_face;
        if (layer_[c] == z) first_face_[c] = first, last_face_[c] = next_face;
    }
}

/// The weight that passes the part in progress, and what its faces bear.
void WallFriction::load_part(std::span<WallFace> faces, double voxel_kg) {
    const auto area = static_cast<double>(part_.size());
    double above_kg = 0, soil_kg = 0, grip = 0, rate = 0, relief_kg = 0;
    for (const size_t c : part_) {
        above_kg += weight_kg_[c];
        soil_kg += cell_[c]->height * voxel_kg;
    }
    const auto for_faces = [&](const auto& act) {
        for (const size_t c : part_) {
            for (size_t i = first_face_[c]; i < last_face_[c]; ++i) {
                WallFace& face = faces[face_order_[i]];
                act(face, face.area_voxels * cell_[c]->height * face.friction);
            }
        }
    };
    for_faces([&](const WallFace& face, double held) {
        grip += held;
        rate += held * face.pressure_share / area;
        relief_kg += held * face.relief_kg;
    });
    const double whole_kg = above_kg + soil_kg;
    const double passed =
        rate > 0 ? passed_kg(above_kg, soil_kg, rate, relief_kg / rate) : whole_kg;
    const double borne_kg = whole_kg - passed;
    if (borne_kg > 0) {
        for_faces([&](WallFace& face, double held) { face.borne_kg = borne_kg * held / grip; });
    }
    for (const size_t c : part_) weight_kg_[c] = passed / area;
}

void WallFriction::find(std::span<const LoadCell> cells, double load_kg,
                        std::span<WallFace> faces) {
    double voxels = 0;
    for (const LoadCell& cell : cells) voxels += cell.height;
    for (WallFace& face : faces) face.borne_kg = 0;
    if (!(voxels > 0) || faces.empty()) return;
    list_layers(cells);
    list_faces(faces);
    size_t next_face = 0;
    for (size_t layer = layers_.size(); layer-- > 0;) {
        const int z = low_z_ + static_cast<int>(layer);
        begin_layer(z, faces, next_face);
        for (const LoadCell* cell : layers_[layer]) {
            const size_t c = column_of(cell->x, cell->y);
            if (part_layer_[c] == z) continue;
            gather_part(z, c);
            load_part(faces, load_kg / voxels);
        }
    }
}

}  // namespace bsoil
