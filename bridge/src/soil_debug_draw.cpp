#include "soil_debug_draw.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

constexpr int kTileSide = 8;           ///< columns, as a tile of the soil
constexpr float kBareVolume = 0.02f;   ///< of a voxel: less soil than this is no span
constexpr double kForceLongest = 10;   ///< voxels
constexpr double kArrowHead = 0.25;    ///< of the arrow's length
constexpr double kNormalLength = 0.8;  ///< voxels
constexpr double kForceLeast = 1e-3;   ///< of the largest force: smaller ones are not drawn

btVector3 color(double red, double green, double blue) { return to_bullet({red, green, blue}); }

void draw_grid(btIDebugDraw& drawer, const GridFrame& frame) {
    const btVector3 grey = color(0.75, 0.75, 0.8);
    const auto corner = [&frame](int c) {
        return to_bullet(frame.to_world({(c & 1) != 0 ? static_cast<double>(frame.size[0]) : 0.0,
                                         (c & 2) != 0 ? static_cast<double>(frame.size[1]) : 0.0,
                                         (c & 4) != 0 ? static_cast<double>(frame.size[2]) : 0.0}));
    };
    for (int c = 0; c < 8; ++c) {
        for (const int axis : {1, 2, 4}) {
            if ((c & axis) == 0) drawer.drawLine(corner(c), corner(c | axis), grey);
        }
    }
}

void draw_spans(btIDebugDraw& drawer, const Soil& soil, std::span<const ContactVoxel> contacts) {
    const GridFrame& frame = soil.frame();
    std::set<std::pair<int, int>> tiles;
    for (const ContactVoxel& contact : contacts) {
        const Vec3 at = frame.to_grid(contact.center_m);
        const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
        if (x >= 0 && x < frame.size[0] && y >= 0 && y < frame.size[1]) {
            tiles.insert({x / kTileSide, y / kTileSide});
        }
    }
    const btVector3 brown = color(0.95, 0.7, 0.3);
    std::vector<float> volume, solid;
    std::vector<uint8_t> material;
    for (const auto& [tx, ty] : tiles) {
        soil.read_tile(tx, ty, volume, solid, material);
        for (int c = 0; c < kTileSide * kTileSide; ++c) {
            const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
            if (x >= frame.size[0] || y >= frame.size[1]) continue;
            const auto volume_at = [&](int z) {
                return z < frame.size[2]
                           ? volume[static_cast<size_t>(z) * 64 + static_cast<size_t>(c)]
                           : 0.0f;
            };
            for (int z = 0; z < frame.size[2]; ++z) {
                if (volume_at(z) <= kBareVolume) continue;
                const int bottom = z;
                while (volume_at(z + 1) > kBareVolume) ++z;
                const double top = z + std::min(1.0, static_cast<double>(volume_at(z)));
                drawer.drawLine(to_bullet(frame.to_world({x + 0.5, y + 0.5, 1.0 * bottom})),
                                to_bullet(frame.to_world({x + 0.5, y + 0.5, top})), brown);
            }
        }
    }
}

void draw_arrow(btIDebugDraw& drawer, Vec3 from, Vec3 way, const btVector3& shade) {
    const Vec3 to = from + way;
    drawer.drawLine(to_bullet(from), to_bullet(to), shade);
    Vec3 aside = cross(way, std::abs(way.y) < std::abs(way.x) ? Vec3{0, 1, 0} : Vec3{1, 0, 0});
    const double aside_m = length(aside);
    if (aside_m <= 0) return;
    aside = aside * (0.5 * kArrowHead * length(way) / aside_m);
    for (const Vec3 side : {aside, -aside}) {
        drawer.drawLine(to_bullet(to), to_bullet(to - kArrowHead * way + side), shade);
    }
}

void draw_contacts(btIDebugDraw& drawer, double voxel_m, std::span<const ContactVoxel> contacts,
                   std::span<const DrawnForce> forces) {
    const btVector3 pale = color(0.5, 0.8, 1.0), red = color(1.0, 0.2, 0.1);
    for (const ContactVoxel& contact : contacts) {
        drawer.drawLine(to_bullet(contact.position_m),
                        to_bullet(contact.position_m + contact.normal * (kNormalLength * voxel_m)),
                        pale);
    }
    double largest_n = 0;
    for (const DrawnForce& drawn : forces) largest_n = std::max(largest_n, length(drawn.force_n));
    if (largest_n <= 0) return;
    for (const DrawnForce& drawn : forces) {
        if (length(drawn.force_n) > kForceLeast * largest_n) {
            draw_arrow(drawer, drawn.point_m, drawn.force_n * (kForceLongest * voxel_m / largest_n),
                       red);
        }
    }
}

}  // namespace

void draw_soil(btIDebugDraw& drawer, const Soil& soil, std::span<const ContactVoxel> contacts,
               std::span<const DrawnForce> forces) {
    const int mode = drawer.getDebugMode();
    if ((mode & btIDebugDraw::DBG_DrawAabb) != 0) draw_grid(drawer, soil.frame());
    if ((mode & btIDebugDraw::DBG_DrawWireframe) != 0) draw_spans(drawer, soil, contacts);
    if ((mode & btIDebugDraw::DBG_DrawNormals) != 0) {
        draw_contacts(drawer, soil.frame().voxel_m, contacts, forces);
    }
}

}  // namespace bsoil::bullet
