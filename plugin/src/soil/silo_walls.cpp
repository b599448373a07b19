#include "soil/silo_walls.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bsoil/contact/contact_motion.h"
#include "bsoil/contact/granular_law.h"
#include "bsoil/contact/orientation.h"

namespace bsoil {

using namespace layout;

namespace {

/// A body stands on the load where its sole there is at least this share of its upright faces.
/// Ours: a plate that hangs into the load has its thickness over twice its depth. Larger, and a
/// deeply sunk wheel counts as a wall; smaller, and a thick wall that ends in the load is none.
constexpr double kSoleShare = 1.0 / 8;
/// Soil is around a body where the mean of n . r / |r| over its upright faces is more. Ours:
/// between a plate's 0 and a pillar's 1.
constexpr double kPillar = 0.5;
/// Walls are looked at from so many full voxels of load on, and bear their whole share from twice
/// as many. Ours: layers of five voxels by five, five high; stair faces say too little of walls
/// around fewer. Larger: small silos weigh on their floors alone; smaller: each clod beside two
/// bodies has its tiles read.
constexpr double kLeastVoxels = 125;
/// Cosine from which a face looks along a direction. Ours: for the rounding.
constexpr double kLooksAlong = 1e-6;
constexpr int kBeside[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
/// Planes that are read of each tile, then those of materials where there are several.
enum SolidPlane { kSolidBodies, kSolidOwner, kSolidRock, kSolidPlanes };

Vec3 velocity_at(const SoilBody& body, Vec3 point_m) {
    if (body.is_static) return {};
    return body.linear_velocity_m_s +
           cross(body.angular_velocity_rad_s, point_m - body.center_of_mass_m);
}

}  // namespace

bool SiloWalls::Wall::is_wall() const {
    return sole_m2 < kSoleShare * upright_m2 && outward_m2 <= kPillar * upright_m2;
}

const StepBody* SiloWalls::find_body(int id) const {
    const auto& bodies = bodies_.in_step();
    const auto found = std::find_if(bodies.begin(), bodies.end(),
                                    [id](const StepBody& body) { return body.input->id == id; });
    return found == bodies.end() ? nullptr : &*found;
}

/// What walls bear of it by its size, 0..1, as if all of it were of the first material; see
/// kLeastVoxels.
double SiloWalls::wall_share(const BodyLoad& load) const {
    const double voxel_kg =
        core_.materials.front().density_kg_m3 * std::pow(core_.frame.voxel_m, 3);
    return std::clamp(load.mass_kg / (kLeastVoxels * voxel_kg) - 1, 0.0, 1.0);
}

void SiloWalls::sort_contacts(std::span<const ContactVoxel> contacts) {
    by_carrier_.clear();
    for (const ContactVoxel& contact : contacts) {
        if (contact.carrier >= 0 && contact.carrier != contact.body) {
            by_carrier_.push_back(&contact);
        }
    }
    std::stable_sort(by_carrier_.begin(), by_carrier_.end(),
                     [](const ContactVoxel* a, const ContactVoxel* b) {
                         return std::pair(a->carrier, a->body) < std::pair(b->carrier, b->body);
                     });
}

void SiloWalls::share(std::span<const int32_t> header, std::span<const ContactVoxel> contacts,
                      const TileSpans& spans_of, std::vector<BodyLoad>& loads) {
    const auto is_large = [this](const BodyLoad& load) { return wall_share(load) > 0; };
    if (std::none_of(loads.begin(), loads.end(), is_large)) return;
    sort_contacts(contacts);
    borne_.clear();
    for (BodyLoad& load : loads) {
        if (!is_large(load)) continue;
        const StepBody* floor = find_body(load.body);
        const auto index = static_cast<size_t>(floor->track->index);
        const bool has_terrain = header[kResultHeader + index * kLoadWords + kLoadWalls] != 0;
        const auto first = std::lower_bound(
            by_carrier_.begin(), by_carrier_.end(), load.body,
            [](const ContactVoxel* contact, int body) { return contact->carrier < body; });
        const auto last = std::find_if(
            first, by_carrier_.end(),
            [&load](const ContactVoxel* contact) { return contact->carrier != load.body; });
        if (!has_terrain && first == last) continue;
        share_load(load, has_terrain, std::span(first, last), spans_of);
    }
    for (const BodyLoad& borne : borne_) {
        const auto own = std::find_if(loads.begin(), loads.end(), [&](const BodyLoad& load) {
            return load.body == borne.body;
        });
        const bool is_new = own == loads.end();
        BodyLoad& load = is_new ? loads.emplace_back() : *own;
        if (is_new) {
            load.body = borne.body;
            load.center_m = find_body(borne.body)->input->center_of_mass_m;
        }
        load.held_kg += borne.held_kg;
        load.held_kg_m += borne.held_kg_m;
    }
}

void SiloWalls::share_load(BodyLoad& load, bool has_terrain,
                           std::span<const ContactVoxel*> contacts, const TileSpans& spans_of) {
    const StepBody& floor = *find_body(load.body);
    up_ = rotate(core_.frame.grid_to_world.rotation, Vec3{0, 0, 1});
    list_walls(contacts);
    list_touches(contacts);
    if (touches_.empty() && !has_terrain) return;
    read_solids(floor);
    list_cells(floor, spans_of);
    faces_.clear();
    for (const LoadCell& cell : cells_) add_faces(floor, cell, has_terrain);
    friction_.find(cells_, load.mass_kg, faces_);
    hand_over(load);
}

/// What the bodies in contact with the load are like: walls_ in the order of contacts.
void SiloWalls::list_walls(std::span<const ContactVoxel*> contacts) {
    walls_.clear();
    const Vec3 up = up_;
    const auto upright_m2 = [&](const ContactVoxel& v, Vec3& level) {
        level = v.normal - dot(v.normal, up) * up;
        return v.area_m2 * v.touching * dot(level, level);
    };
    Vec3 level;
    for (const ContactVoxel* v : contacts) {
        if (walls_.empty() || walls_.back().body != v->body) walls_.emplace_back().body = v->body;
        Wall& wall = walls_.back();
        const double area_m2 = upright_m2(*v, level), down = looks_down(v->normal, up);
        wall.upright_m2 += area_m2;
        wall.middle_m += area_m2 * v->position_m;
        if (v->depth_m > 0) wall.sole_m2 += v->area_m2 * v->touching * down * down;
    }
    size_t at = 0;
    for (const ContactVoxel* v : contacts) {
        if (walls_[at].body != v->body) ++at;
        Wall& wall = walls_[at];
        const double area_m2 = upright_m2(*v, level);
        if (!(area_m2 > 0)) continue;
        Vec3 arm = v->position_m - wall.middle_m * (1 / wall.upright_m2);
        arm = arm - dot(arm, up) * up;
        const double size_m = length(arm) * length(level);
        if (size_m > 0) wall.outward_m2 += area_m2 * dot(level, arm) / size_m;
    }
}

/// The contacts of walls, by place.
void SiloWalls::list_touches(std::span<const ContactVoxel*> contacts) {
    touches_.clear();
    size_t at = 0;
    for (const ContactVoxel* v : contacts) {
        if (walls_[at].body != v->body) ++at;
        if (!walls_[at].is_wall()) continue;
        const Vec3 place = core_.to_grid(v->position_m);
        touches_.push_back(
            {{static_cast<int>(std::floor(place.x)), static_cast<int>(std::floor(place.y)),
              static_cast<int>(std::floor(place.z))},
             at,
             v});
    }
    std::stable_sort(touches_.begin(), touches_.end(), [](const Touch& a, const Touch& b) {
        return std::lexicographical_compare(a.voxel, a.voxel + 3, b.voxel, b.voxel + 3);
    });
}

int SiloWalls::plane_count() const {
    const auto material_count = static_cast<int>(core_.materials.size());
    return kSolidPlanes + (material_count > 1 ? material_count : 0);
}

size_t SiloWalls::tile_words() const {
    return static_cast<size_t>(plane_count()) * static_cast<size_t>(core_.params.tile_voxels);
}

void SiloWalls::want(bool has_contacts, std::vector<device::ReadRange>& ranges) {
    for (const int tile : read_) place_[static_cast<size_t>(tile)] = -1;
    read_.clear();
    std::erase_if(asked_, [&](int tile) {
        const Tile* known = tiles_[static_cast<size_t>(tile)].get();
        return !has_contacts || !known || !known->is_awake();
    });
    planes_.resize(asked_.size() * tile_words());
    for (const int tile : asked_) read_tile(tile, ranges);
    asked_.clear();
}

/// Takes a tile's planes into planes_, which has room for them; those of one awake by `ranges`.
void SiloWalls::read_tile(int tile, std::vector<device::ReadRange>& ranges) {
    const auto plane_words = static_cast<size_t>(core_.params.tile_voxels);
    const auto words = std::span(planes_).subspan(read_.size() * tile_words(), tile_words());
    place_.resize(tiles_.size(), -1);
    place_[static_cast<size_t>(tile)] = static_cast<int>(read_.size());
    read_.push_back(tile);
    const Tile* known = tiles_[static_cast<size_t>(tile)].get();
    if (!known || !known->is_awake()) {
        std::ranges::fill(words, 0);
        if (!known) return;
        tiles_.read_voxels(tile, asleep_);
        std::copy_n(asleep_.words.begin(), plane_words, words.begin() + kSolidRock * plane_words);
        return;
    }
    for (int p = 0; p < plane_count(); ++p) {
        const int plane = p == kSolidBodies  ? kPlaneCoverage
                          : p == kSolidOwner ? kPlaneOwner
                          : p == kSolidRock  ? kPlaneTerrain
                                             : kPlaneMaterial + p - kSolidPlanes;
        ranges.push_back(tiles_.plane_range(
            plane, known->slot, words.subspan(static_cast<size_t>(p) * plane_words, plane_words)));
    }
}

/// The load stands over its body, and what stands beside it is no more than a tile further.
void SiloWalls::read_solids(const StepBody& floor) {
    missing_.clear();
    place_.resize(tiles_.size(), -1);
    int last_tile = -1;
    for (const BlockKey block : floor.track->blocks) {  // sorted: a tile's follow each other
        const auto tile = static_cast<int>(block / core_.blocks_per_tile);
        if (tile == std::exchange(last_tile, tile)) continue;
        core_.tiles_around(tile % core_.tiles_x, tile / core_.tiles_x)
            .for_each_tile([&](int tx, int ty) { missing_.push_back(core_.tile_index(tx, ty)); });
    }
    std::ranges::sort(missing_);
    missing_.erase(std::unique(missing_.begin(), missing_.end()), missing_.end());
    asked_.insert(asked_.end(), missing_.begin(), missing_.end());
    std::ranges::sort(asked_);
    asked_.erase(std::unique(asked_.begin(), asked_.end()), asked_.end());
    std::erase_if(missing_, [&](int tile) { return place_[static_cast<size_t>(tile)] >= 0; });
    if (missing_.empty()) return;
    planes_.resize((read_.size() + missing_.size()) * tile_words());
    ranges_.clear();
    for (const int tile : missing_) read_tile(tile, ranges_);
    core_.device->read(ranges_);
}

/// Of a voxel; 0 where nothing was read.
int SiloWalls::word_at(int plane, const VoxelPlace& at) const {
    if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= core_.frame.size[0] ||
        at.y >= core_.frame.size[1] || at.z >= core_.height) {
        return 0;
    }
    const int place =
        place_[static_cast<size_t>(core_.tile_index(at.x / kTileSide, at.y / kTileSide))];
    if (place < 0) return 0;
    const auto voxel =
        static_cast<size_t>(at.z * kTileColumns + at.y % kTileSide * kTileSide + at.x % kTileSide);
    return planes_[static_cast<size_t>(place) * tile_words() +
                   static_cast<size_t>(plane) * static_cast<size_t>(core_.params.tile_voxels) +
                   voxel];
}

int SiloWalls::material_at(const VoxelPlace& at) const {
    int most = 0;
    for (int m = 1; m < plane_count() - kSolidPlanes; ++m) {
        if (word_at(kSolidPlanes + m, at) > word_at(kSolidPlanes + most, at)) most = m;
    }
    return most;
}

void SiloWalls::list_cells(const StepBody& floor, const TileSpans& spans_of) {
    cells_.clear();
    int last_tile = -1;
    for (const BlockKey block : floor.track->blocks) {  // sorted: a tile's follow each other
        const auto tile = static_cast<int>(block / core_.blocks_per_tile);
        if (tile == std::exchange(last_tile, tile)) continue;
        const Tile* known = tiles_[static_cast<size_t>(tile)].get();
        if (!known || !known->is_awake()) continue;
        const int32_t* words = spans_of(known->slot);
        for (int c = 0; c < kTileColumns; ++c) {
            add_cells(words + c * kColumnWords, floor.track->index,
                      tile % core_.tiles_x * kTileSide + c % kTileSide,
                      tile / core_.tiles_x * kTileSide + c / kTileSide);
        }
    }
}

/// Those of a column's height spans that the body with this index carries.
void SiloWalls::add_cells(const int32_t* column, int carrier, int x, int y) {
    for (int i = 0; i < column[kColumnCount]; ++i) {
        const auto pair = static_cast<uint32_t>(column[kColumnBase + i / 2]);
        const int base = static_cast<int>(pair >> (i % 2 * 16) & 0xffff);
        if ((base & kBaseBody) != carrier + 1) continue;
        const int32_t* span = column + kColumnSpans + i * kSpanWords;
        const double bottom = span[kSpanBottom] / static_cast<double>(kOneQ16);
        const double top = span[kSpanTop] / static_cast<double>(kOneQ16);
        for (int z = static_cast<int>(std::floor(bottom)); z < top; ++z) {
            cells_.push_back(
                {x, y, z, std::min(top, z + 1.0) - std::max(bottom, static_cast<double>(z))});
        }
    }
}

void SiloWalls::add_faces(const StepBody& floor, const LoadCell& cell, bool has_terrain) {
    for (const auto& [dx, dy] : kBeside) {
        const VoxelPlace beside{cell.x + dx, cell.y + dy, cell.z};
        const int bodies = word_at(kSolidBodies, beside), rock = word_at(kSolidRock, beside);
        if (bodies + rock < kSolidCoverage) continue;
        WallFace face;
        face.voxel[0] = cell.x, face.voxel[1] = cell.y, face.voxel[2] = cell.z;
        if (bodies > rock) {
            const int index = (word_at(kSolidOwner, beside) & (kOwnerRank - 1)) - 1;
            if (index != floor.track->index) add_body_face(floor, beside, dx, dy, index, face);
        } else if (has_terrain) {
            add_terrain_face(floor, beside, dx, dy, face);
        }
    }
}

/// Of the face of a voxel that looks along `outward`.
Vec3 SiloWalls::middle_of(const VoxelPlace& beside, Vec3 outward) const {
    return core_.frame.to_world({beside.x + 0.5, beside.y + 0.5, beside.z + 0.5}) +
           0.5 * core_.frame.voxel_m * outward;
}

/// The nearest contact with a body's face that looks along `outward`, of those in a voxel and the
/// ones around it; null: there is none.
const SiloWalls::Touch* SiloWalls::find_touch(const VoxelPlace& beside, Vec3 outward,
                                              int body) const {
    const Touch* nearest = nullptr;
    double nearest_m2 = 0;
    const Vec3 middle_m = middle_of(beside, outward);
    for (int x = beside.x - 1; x <= beside.x + 1; ++x) {
        const int low[3] = {x, beside.y - 1, beside.z - 1};
        auto it = std::lower_bound(
            touches_.begin(), touches_.end(), low, [](const Touch& touch, const int* at) {
                return std::lexicographical_compare(touch.voxel, touch.voxel + 3, at, at + 3);
            });
        for (; it != touches_.end() && it->voxel[0] == x && it->voxel[1] <= beside.y + 1; ++it) {
            if (std::abs(it->voxel[2] - beside.z) > 1 || it->contact->body != body) continue;
            if (!(dot(it->contact->normal, outward) > kLooksAlong)) continue;
            const Vec3 way = it->contact->position_m - middle_m;
            if (!nearest || dot(way, way) < nearest_m2) {
                nearest = &*it;
                nearest_m2 = dot(way, way);
            }
        }
    }
    return nearest;
}

/// The steps of a wall that stands askew have more area than the wall: a step's face counts by its
/// part along the wall's normal. So it does for a wall that leans.
void SiloWalls::add_body_face(const StepBody& floor, const VoxelPlace& beside, int dx, int dy,
                              int index, WallFace& face) {
    const std::span<const int> ids = bodies_.ids();
    if (index < 0 || index >= static_cast<int>(ids.size())) return;
    const Vec3 outward = rotate(core_.frame.grid_to_world.rotation,
                                Vec3{static_cast<double>(-dx), static_cast<double>(-dy), 0});
    const Touch* touch = find_touch(beside, outward, ids[static_cast<size_t>(index)]);
    if (!touch) return;
    const ContactVoxel& contact = *touch->contact;
    const SoilBody& wall = *find_body(contact.body)->input;
    const MaterialDef& material = core_.materials[static_cast<size_t>(contact.material)];
    const double cohesion_pa =
        cohesion_share(material, contact) *
        (material.cohesion_pa + material.moisture_cohesion_pa(contact.saturation));
    face.wall = static_cast<int>(touch->wall);
    face.area_voxels = dot(contact.normal, outward) * contact.touching;
    // On the plane of the contact, whose own place may be a voxel beside.
    const Vec3 middle_m = middle_of(beside, outward);
    face.position_m =
        middle_m + dot(contact.position_m - middle_m, contact.normal) * contact.normal;
    add_face(floor, &wall, wall_grip(material, wall.surface.friction, cohesion_pa), face);
}

/// Its normal is the terrain's, over two voxels.
void SiloWalls::add_terrain_face(const StepBody& floor, const VoxelPlace& beside, int dx, int dy,
                                 WallFace& face) {
    const auto change = [this](const VoxelPlace& ahead, const VoxelPlace& behind) {
        return static_cast<double>(word_at(kSolidRock, ahead) - word_at(kSolidRock, behind));
    };
    Vec3 slope;
    for (int n = 0; n <= 1; ++n) {
        const int x = beside.x - n * dx, y = beside.y - n * dy, z = beside.z;
        slope += Vec3{change({x + 1, y, z}, {x - 1, y, z}), change({x, y + 1, z}, {x, y - 1, z}),
                      change({x, y, z + 1}, {x, y, z - 1})};
    }
    const double along = dx * slope.x + dy * slope.y;
    if (!(along > 0)) return;
    const VoxelPlace soil{beside.x - dx, beside.y - dy, beside.z};
    const MaterialDef& material = core_.materials[static_cast<size_t>(material_at(soil))];
    face.wall = kGround;
    face.area_voxels = along / length(slope);
    face.position_m = core_.frame.to_world(
        {beside.x + 0.5 * (1 - dx), beside.y + 0.5 * (1 - dy), beside.z + 0.5});
    add_face(floor, nullptr, wall_grip(material, -1, material.cohesion_pa), face);
}

/// wall: null for ground.
void SiloWalls::add_face(const StepBody& floor, const SoilBody* wall, const WallGrip& grip,
                         WallFace& face) {
    const double voxel_m = core_.frame.voxel_m;
    const bool is_solved =
        !floor.input->is_driven || (wall && !wall->is_driven && !wall->is_static);
    const MotionSource source{is_solved, false, voxel_m};
    const Vec3 wall_m_s = wall ? velocity_at(*wall, face.position_m) : Vec3{};
    face.friction =
        grip.friction * hanging_share(velocity_at(*floor.input, face.position_m) - wall_m_s, up_,
                                      source.rest_m_s());
    face.pressure_share = grip.pressure_share;
    face.relief_kg = grip.relief_pa * voxel_m * voxel_m / core_.def.gravity_m_s2;
    if (face.friction > 0 && face.area_voxels > 0) faces_.push_back(face);
}

/// Each wall's share in whole parts, off the floor and onto the wall.
void SiloWalls::hand_over(BodyLoad& load) {
    const double part_kg = kLoadPart * core_.kg_per_unit;
    for (int wall = kGround; wall < static_cast<int>(walls_.size()); ++wall) {
        double sum_kg = 0;
        Vec3 sum_kg_m;
        for (const WallFace& face : faces_) {
            if (face.wall != wall) continue;
            sum_kg += face.borne_kg;
            sum_kg_m += face.borne_kg * face.position_m;
        }
        const double held_kg = std::round(wall_share(load) * sum_kg / part_kg) * part_kg;
        if (!(held_kg > 0)) continue;
        const Vec3 held_kg_m = sum_kg_m * (held_kg / sum_kg);
        load.held_kg += held_kg;
        load.held_kg_m += held_kg_m;
        if (wall == kGround) continue;
        BodyLoad& of_wall = borne_.emplace_back();
        of_wall.body = walls_[static_cast<size_t>(wall)].body;
        of_wall.held_kg = -held_kg;
        of_wall.held_kg_m = -held_kg_m;
    }
}

}  // namespace bsoil
