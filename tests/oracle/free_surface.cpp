#include "oracle/free_surface.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace oracle {

namespace {

/// Heights of the nearest columns with soil on top; of bare terrain its own, where that is lower.
std::set<double> soil_beside(const SurfaceMap& map, int x, int y) {
    int least = map.nx + map.ny;
    std::set<double> heights;
    for (int j = 0; j < map.ny; ++j) {
        for (int i = 0; i < map.nx; ++i) {
            if (map.at(i, j).top != SurfaceColumn::Top::soil) continue;
            const int steps = std::abs(i - x) + std::abs(j - y);
            if (steps < least) heights.clear();
            least = std::min(least, steps);
            if (steps == least) heights.insert(map.at(i, j).height);
        }
    }
    const SurfaceColumn& here = map.at(x, y);
    if (here.top != SurfaceColumn::Top::terrain) return heights;
    std::set<double> bounded;
    for (const double height : heights) bounded.insert(std::min(here.height, height));
    return bounded;
}

/// How much of column i lies between two places.
double inside(int i, double low, double high) {
    return std::max(0.0, std::min(i + 1.0, high) - std::max(i + 0.0, low));
}

}  // namespace

std::vector<double> free_surface(const SurfaceMap& map, const SurfacePiece& piece) {
    // A face that looks up pushes what lies before it, down to 15 deg from level.
    const double level = 1 - piece.outward.z * piece.outward.z;
    const double wall_share = piece.outward.z > 0 ? std::min(1.0, level / (0.26 * 0.26)) : level;
    const double sole_share = 1 - wall_share;
    std::vector<double> out;
    for (const double nearest : soil_beside(map, piece.x, piece.y)) {
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
                const double height = c.top == SurfaceColumn::Top::terrain
                                          ? *soil_beside(map, i, j).begin()
                                          : c.height;
                free_height += area * height;
                free_area += area;
            }
        }
        if (free_area < 1e-6) {
            out.push_back(nearest);
            continue;
        }
        // A sole whose surroundings are cut off, or lie under bodies, counts its hollow in part.
        const double seen =
            std::min(1.0, (high[0] - low[0]) * (high[1] - low[1]) / (4 * half * half));
        const double open = std::min(1.0, free_area / std::max(1.0, hollow_area));
        const double share = sole_share * seen * open * open;
        out.push_back((free_height + share * hollow_height) / (free_area + share * hollow_area));
    }
    return out;
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
