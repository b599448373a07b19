#include "oracle/free_surface.h"

#include <algorithm>
#include <cmath>

namespace oracle {

namespace {

/// For every column the height of the nearest with soil on top: of those beside it that are a step
/// nearer to soil the mean of what they have, in whole 1/65536. Bare terrain has its own, where
/// that is lower; NaN where there is no soil.
std::vector<double> soil_beside(const SurfaceMap& map) {
    std::vector<double> out(map.columns.size(), NAN);
    const auto index = [&](int x, int y) { return static_cast<size_t>(y) * map.nx + x; };
    for (size_t i = 0; i < out.size(); ++i) {
        if (map.columns[i].top == SurfaceColumn::Top::soil) out[i] = map.columns[i].height;
    }
    for (bool is_told = true; is_told;) {
        is_told = false;
        std::vector<double> next = out;
        for (int y = 0; y < map.ny; ++y) {
            for (int x = 0; x < map.nx; ++x) {
                if (!std::isnan(out[index(x, y)])) continue;
                double sum = 0;
                int count = 0;
                for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
                    const int i = x + dx, j = y + dy;
                    if (i < 0 || j < 0 || i >= map.nx || j >= map.ny) continue;
                    if (std::isnan(out[index(i, j)])) continue;
                    sum += out[index(i, j)] * 65536;
                    ++count;
                }
                if (count == 0) continue;
                next[index(x, y)] = std::floor(sum / count) / 65536;
                is_told = true;
            }
        }
        out = next;
    }
    for (size_t i = 0; i < out.size(); ++i) {
        const SurfaceColumn& column = map.columns[i];
        if (column.top == SurfaceColumn::Top::terrain) out[i] = std::min(out[i], column.height);
    }
    return out;
}

/// Steeper than 45 deg, where a wall in a column under a body begins to push: the first column
/// without body of the three ahead, along each axis, by the squares of the normal's parts.
double ground_ahead(const SurfaceMap& map, const std::vector<double>& soil,
                    const SurfacePiece& piece, double here) {
    const auto is_body = [&](int x, int y) { return map.at(x, y).top == SurfaceColumn::Top::body; };
    const double x2 = piece.outward.x * piece.outward.x, y2 = piece.outward.y * piece.outward.y;
    if (!is_body(piece.x, piece.y) || x2 + y2 == 0) return here;
    const auto along = [&](int dx, int dy) {
        for (int n = 1; n <= 3; ++n) {
            const int x = piece.x + n * dx, y = piece.y + n * dy;
            if (x < 0 || y < 0 || x >= map.nx || y >= map.ny) break;
            if (!is_body(x, y)) return soil[static_cast<size_t>(y) * map.nx + x];
        }
        return here;
    };
    return (x2 * along(piece.outward.x > 0 ? 1 : -1, 0) +
            y2 * along(0, piece.outward.y > 0 ? 1 : -1)) /
           (x2 + y2);
}

/// How much of column i lies between two places.
double inside(int i, double low, double high) {
    return std::max(0.0, std::min(i + 1.0, high) - std::max(i + 0.0, low));
}

}  // namespace

std::optional<double> free_surface(const SurfaceMap& map, const SurfacePiece& piece) {
    // A face that looks up pushes what lies before it, down to 15 deg from level.
    const double level = 1 - piece.outward.z * piece.outward.z;
    const double wall_share = piece.outward.z > 0 ? std::min(1.0, level / (0.26 * 0.26)) : level;
    const double sole_share = 1 - wall_share;
    const std::vector<double> soil = soil_beside(map);
    const double here = soil[static_cast<size_t>(piece.y) * map.nx + piece.x];
    if (std::isnan(here)) return std::nullopt;
    const double nearest = std::lerp(here, ground_ahead(map, soil, piece, here),
                                     std::clamp(2 * wall_share - 1, 0.0, 1.0));
    const double wedge = piece.wedge_length * std::max(0.0, nearest - piece.at.z);
    const double rim = piece.sole_widths * piece.body_width;
    const double half = std::max(1.0, wall_share * wedge / 2 + sole_share * rim);
    const double reach =
        std::clamp(wall_share * wedge + sole_share * rim, piece.reach_least, piece.reach_most);
    const double middle[2] = {piece.at.x + piece.outward.x * wedge / 2,
                              piece.at.y + piece.outward.y * wedge / 2};
    const int column[2] = {piece.x, piece.y}, size[2] = {map.nx, map.ny};
    double low[2], high[2];
    for (int axis = 0; axis < 2; ++axis) {
        const double first = std::max(0.0, column[axis] - reach),
                     last = std::min<double>(size[axis], column[axis] + reach);
        low[axis] = std::clamp(middle[axis] - half, first, last);
        high[axis] = std::clamp(middle[axis] + half, first, last);
    }
    double free_height = 0, free_area = 0, hollow_height = 0, hollow_area = 0;
    for (int j = 0; j < map.ny; ++j) {
        for (int i = 0; i < map.nx; ++i) {
            const double area = inside(i, low[0], high[0]) * inside(j, low[1], high[1]);
            if (area == 0) continue;
            const SurfaceColumn& c = map.at(i, j);
            if (c.top == SurfaceColumn::Top::body) {
                hollow_height += area * c.height;
                hollow_area += area;
                continue;
            }
            free_height += area * soil[static_cast<size_t>(j) * map.nx + i];
            free_area += area;
        }
    }
    if (free_area < 1e-6) return nearest;
    // A sole whose surroundings are cut off, or lie under bodies, counts its hollow in part.
    const double seen = std::min(1.0, (high[0] - low[0]) * (high[1] - low[1]) / (4 * half * half));
    const double open = std::min(1.0, free_area / std::max(1.0, hollow_area));
    const double share = sole_share * seen * open * open;
    return (free_height + share * hollow_height) / (free_area + share * hollow_area);
}

double wedge_depth(const std::function<double(double)>& ground, double depth, double phi_rad,
                   double wall_rad) {
    const auto least_push = [&](const std::function<double(double)>& height) {
        double least = HUGE_VAL;
        for (double plane = 0; plane + phi_rad + wall_rad < 1.57; plane += 0.001) {
            const double step = 0.002 * depth;
            double area = 0;
            for (double x = step / 2; x < 30 * depth; x += step) {
                const double thick = height(x) - x * std::tan(plane);
                if (thick <= 0) break;
                area += thick * step;
            }
            least = std::min(
                least, area * std::sin(plane + phi_rad) / std::cos(plane + phi_rad + wall_rad));
        }
        return least;
    };
    return depth * least_push(ground) / least_push([depth](double) { return depth; });
}

}  // namespace oracle
