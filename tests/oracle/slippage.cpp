#include "oracle/slippage.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>

#include "oracle/arches.h"
#include "oracle/sliding.h"

namespace oracle {
namespace {

/// 1 - F of (1), times the driving force: positive on a plane that fails. W of (2), L of (3).
double surplus(const SlopeSoil& s, double h, double dx, double theta) {
    const double w = (h - std::tan(theta) * dx) * dx * s.unit_weight_n_m3 / 2;
    const double l = dx / std::cos(theta);
    return w * std::sin(theta) - s.cohesion_pa * l -
           w * std::cos(theta) * std::tan(s.friction_angle_rad);
}

struct Neighbour {
    double drop = 0;  ///< 0: nothing can slide there
    int x = 0, y = 0, z = 0;
    bool falls = false;  ///< what it would slide onto
};

struct SlopeFacet {
    double slope = 0;
    double diagonal_share = 0;
};

/// Slope and direction of the plane through a column's top and those of an axis and a diagonal
/// neighbour.
SlopeFacet facet_slope(double axis_drop, double diagonal_drop) {
    if (axis_drop <= 0) return {diagonal_drop / std::numbers::sqrt2, diagonal_drop > 0 ? 1.0 : 0.0};
    const double across = diagonal_drop > 0 ? diagonal_drop - axis_drop : -1;
    if (across <= 0) return {axis_drop, 0};
    if (across > axis_drop) return {diagonal_drop / std::numbers::sqrt2, 1};
    return {std::hypot(axis_drop, across), across / axis_drop};
}

}  // namespace

double standing_wedge(const Model& model, const Voxel& soil, int x, int y, int z) {
    if (model.roughness.empty()) return model.slip_tolerance;
    if (soil.mean(model.viscosity) >= 1) return std::numeric_limits<double>::infinity();
    return model.slip_tolerance + soil.mean(model.roughness) * (1 + chance(x, y, z, 0)) / 2;
}

Wedge failure_wedge(const SlopeSoil& soil, double gravity, double h, double dx) {
    const double steepest = std::atan2(h, dx);
    double theta = soil.friction_angle_rad;
    if (steepest <= theta) return {};
    if (soil.cohesion_pa > 0) {
        // surplus / cos(theta) is a parabola in tan(theta), so what fails is an interval: find its
        // peak, then its foot.
        double low = theta, high = steepest;
        const auto scaled = [&](double t) { return surplus(soil, h, dx, t) / std::cos(t); };
        for (int i = 0; i < 200; ++i) {
            const double a = low + (high - low) / 3, b = high - (high - low) / 3;
            (scaled(a) < scaled(b) ? low : high) = scaled(a) < scaled(b) ? a : b;
        }
        const double peak = (low + high) / 2;
        if (surplus(soil, h, dx, peak) <= 0) return {};
        low = theta;
        high = peak;
        for (int i = 0; i < 100; ++i) {
            const double middle = (low + high) / 2;
            (surplus(soil, h, dx, middle) > 0 ? high : low) = middle;
        }
        theta = high;
    }
    const double t = std::tan(theta);
    const double gamma = soil.unit_weight_n_m3;
    const double force =
        gamma * dx * dx / 4 * std::log((h * h + dx * dx) / (t * dx * t * dx + dx * dx)) *
            std::cos(theta) +
        gamma * dx / 2 * (h - t * dx - dx * (std::atan(h / dx) - theta)) * std::sin(theta);  // (8)
    const double weight = (h - t * dx) * dx * gamma / 2;
    return {h - t * dx, std::max(0.0, force / weight * gravity)};  // (9)
}

Slippage slip_soil(const Model& model, const Field& before, const SlipSpeeds& speeds,
                   const WedgeLookup& wedge, const std::vector<double>& failing_above) {
    std::vector<std::vector<Span>> columns;
    for (int y = 0; y < before.ny; ++y) {
        for (int x = 0; x < before.nx; ++x) {
            std::vector<Span> spans = height_spans(model, before, x, y);
            const auto lost = static_cast<std::ptrdiff_t>(spans.size()) - model.span_capacity;
            // Of too many the lowest go.
            if (lost > 0) spans.erase(spans.begin(), spans.begin() + lost);
            columns.push_back(std::move(spans));
        }
    }
    const auto column = [&](int x, int y) { return static_cast<size_t>(y) * before.nx + x; };
    // By what most of a voxel's soil is.
    const auto state_of = [&](const Voxel& voxel, int x, int y, int z) {
        if (!failing_above.empty() &&
            2 * std::max(0.0, failing_above[column(x, y)] - z - voxel.terrain) < voxel.soil) {
            return SoilState::failing;
        }
        return is_bonded(model, voxel) ? SoilState::bonded : SoilState::loose;
    };
    // Soil that falls in an arch is ground as piled soil is.
    const auto is_ground = [&](const Span& span, int x, int y) {
        return span.kind == Span::Kind::piled ||
               (span.kind == Span::Kind::falling && is_arched(model, before, x, y, span));
    };
    const auto in_grid = [&](int x, int y) { return before.inside(x, y, 0); };
    const auto open = [&](int x, int y, double height) {
        return !before.closed(model, x, y, static_cast<int>(std::floor(height)));
    };
    // What a voxel takes at once from a span that reaches up to `top`: all, but where its own top
    // would jump above that.
    const auto most_taken = [&](int x, int y, int z, double top) {
        const Voxel& target = before.at(x, y, z);
        if (target.psi() == 0 || top > z + 1) return std::numeric_limits<double>::infinity();
        const double slack = slack_at(model, before, x, y, z);
        const double most =
            model.cover_intake * std::max(0.0, 1 - slack - target.psi() - target.soil);
        return most < model.speck ? 0 : most;
    };
    // The slice between a piled span and the column at (x, y).
    const auto slice = [&](const Span& span, bool on_rigid, int x, int y) -> Neighbour {
        if (!in_grid(x, y)) return {};
        double ceiling = span.top;
        const std::vector<Span>& spans = columns[column(x, y)];
        for (auto at = spans.rbegin(); at != spans.rend(); ++at) {  // clang 14 has no views
            const Span& other = *at;
            const bool ground = is_ground(other, x, y);
            if (!ground || std::min(span.top, other.top) < std::max(span.bottom, other.bottom)) {
                // (31). Below soil that falls in crumbs there is room.
                const bool full = before.at(x, y, static_cast<int>(other.bottom)).soil >= 1;
                if (ground || other.kind == Span::Kind::rigid || full) {
                    ceiling = std::min(span.top, other.bottom);
                }
                continue;
            }
            const int z = static_cast<int>(other.top);
            if (!open(x, y, other.top)) return {};
            // On what is bare soil comes to lie on top of what covers the voxel.
            const double bare = other.top == other.bottom ? before.at(x, y, z).psi() : 0;
            const double drop = ceiling - (other.top + bare);  // (32)
            if (drop <= 0) return {};
            if (most_taken(x, y, z, span.top) == 0) return {};
            // What falls takes no more than it has room for.
            const Voxel& on = before.at(x, y, z);
            const bool falls = other.kind == Span::Kind::falling;
            const bool is_crowded =
                falls && (on.soil + on.psi() >= 1 || before.at(x, y, z - 1).soil > model.crowded);
            return is_crowded ? Neighbour{} : Neighbour{drop, x, y, z, falls};
        }
        // Nothing beside the span: on a rigid body's edge an edge span of no height takes the soil
        // (Fig. 35).
        if (on_rigid && open(x, y, span.bottom)) {
            const int z = static_cast<int>(span.bottom);
            const Voxel& beside = before.at(x, y, z);
            if (beside.soil + beside.psi() < 1) return {span.top - span.bottom, x, y, z};
        }
        return {};
    };
    // Over slip_stride columns along (dx, dy), each lower than the one before; a drop per voxel.
    const auto way = [&](const Span& span, bool on_rigid, int x, int y, int dx,
                         int dy) -> Neighbour {
        std::vector<Neighbour> path(1);
        for (int k = 1; k <= model.slip_stride; ++k) {
            path.push_back(slice(span, on_rigid && model.slip_stride == 1, x + k * dx, y + k * dy));
        }
        const bool falls = std::adjacent_find(path.begin(), path.end(),
                                              [](const Neighbour& a, const Neighbour& b) {
                                                  return b.drop <= a.drop;
                                              }) == path.end();
        Neighbour end = falls ? path.back() : Neighbour{};
        end.drop /= model.slip_stride;
        return end;
    };
    const std::vector<FreeSurface> surfaces =
        model.slides ? free_surfaces(model, before) : std::vector<FreeSurface>();
    Slippage after{before, SlipSpeeds(speeds.size(), 0.0)};
    for (int y = 0; y < before.ny; ++y) {
        for (int x = 0; x < before.nx; ++x) {
            for (size_t i = 0; i < columns[column(x, y)].size(); ++i) {
                const Span& span = columns[column(x, y)][i];
                if (!is_ground(span, x, y) || span.top <= span.bottom) continue;
                const bool falls = span.kind == Span::Kind::falling;
                const bool on_rigid = span.bottom > 0 && !falls;
                // Neighbours counter-clockwise from east: even ones along the axes, odd ones
                // diagonal.
                constexpr int kRing[8][2] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                             {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
                Neighbour ring[8];
                for (int k = 0; k < 8; ++k) {
                    ring[k] = way(span, on_rigid, x, y, kRing[k][0], kRing[k][1]);
                }
                const int surface = static_cast<int>(std::ceil(span.top)) - 1;
                const Voxel& top = before.at(x, y, surface);
                const SoilState state = state_of(top, x, y, surface);
                const double stands = standing_wedge(model, top, x, y, surface);
                double flow[8] = {}, total = 0;
                GridWedge steepest;
                double worst_slope = 0;
                Vec3 falls_to[8];        // direction of each facet
                double heights[8] = {};  // of its wedge
                for (int facet = 0; facet < 8; ++facet) {
                    const int axis = facet / 2 * 2;
                    const int diagonal = facet % 2 == 0 ? axis + 1 : (axis + 7) % 8;
                    const SlopeFacet plane = facet_slope(ring[axis].drop, ring[diagonal].drop);
                    GridWedge found =
                        plane.slope > 0 ? wedge(top, falls ? SoilState::loose : state, plane.slope)
                                        : GridWedge{};
                    if (falls) found.height = plane.slope;  // it has no friction
                    if (found.height <= stands) continue;
                    if (found.height > steepest.height) {
                        steepest = found;
                        worst_slope = plane.slope;
                    }
                    const double part = plane.diagonal_share;
                    const auto along = [&](int k) {
                        return kRing[axis][k] + part * (kRing[diagonal][k] - kRing[axis][k]);
                    };
                    falls_to[facet] = Vec3{along(0), along(1), 0} * (1 / std::hypot(1, part));
                    heights[facet] = found.height;
                    flow[diagonal] += found.height * plane.diagonal_share;
                    flow[axis] += found.height * (1 - plane.diagonal_share);
                    total += found.height;
                }
                if (total == 0) continue;
                if (!model.viscosity.empty() &&
                    chance(x, y, surface, model.pass) < top.mean(model.viscosity)) {
                    continue;
                }
                const double overshoot =
                    falls || model.slip_stride > 1 || model.slides
                        ? 0
                        : std::min(model.slip_overshoot, tan_phi(model, top) / 4);
                double wedge_height = steepest.height + overshoot;
                if (model.slides && i + 1 == columns[column(x, y)].size() &&
                    surfaces[column(x, y)].kind == FreeSurface::Kind::free &&
                    surfaces[column(x, y)].height == span.top) {
                    const auto stands_there = [&](const Voxel& voxel, int z) {
                        return wedge(voxel, state_of(voxel, x, y, z), worst_slope).height <=
                               standing_wedge(model, voxel, x, y, z);
                    };
                    // Facets within an eighth of the steepest count, the more the steeper.
                    Vec3 fall;
                    double weights = 0;
                    for (int facet = 0; facet < 8; ++facet) {
                        const double weight =
                            std::max(0.0, 1 - (1 - heights[facet] / steepest.height) * 8);
                        fall += falls_to[facet] * weight;
                        weights += weight;
                    }
                    const double size = std::hypot(fall.x, fall.y) / weights;
                    const double longer =
                        size > 0 ? std::min(std::numbers::sqrt2, 1 / size) / weights : 0;
                    set_sliding(model, before, surfaces,
                                {x, y, span.top, worst_slope, fall.x * longer, fall.y * longer,
                                 stands_there},
                                after.field);
                    // What has no way to slide in slips.
                    const double aside = 1 - std::min(1.0, std::hypot(fall.x, fall.y) * longer);
                    wedge_height = std::min(wedge_height, model.slide_creep + aside * wedge_height);
                }
                double speed = 0;
                for (int ny = std::max(0, y - 1); ny <= std::min(before.ny - 1, y + 1); ++ny) {
                    for (int nx = std::max(0, x - 1); nx <= std::min(before.nx - 1, x + 1); ++nx) {
                        const auto first =
                            speeds.begin() +
                            static_cast<std::ptrdiff_t>(column(nx, ny)) * model.span_capacity;
                        const auto count =
                            static_cast<std::ptrdiff_t>(columns[column(nx, ny)].size());
                        speed = std::accumulate(first, first + count, speed,
                                                [](double a, double b) { return std::max(a, b); });
                    }
                }
                const double dt = 1.0 / model.substeps;
                speed = std::min(1.0, speed + steepest.acceleration * dt);  // (9)
                after.speeds[column(x, y) * model.span_capacity + i] = speed;
                const double slide = wedge_height * model.slip_stride;
                double amount = std::min(
                    slide * std::clamp(speed * dt, model.slip_rate_least, model.slip_rate_most),
                    static_cast<double>(model.slip_depth));  // (10)
                const double most_flow = *std::max_element(std::begin(flow), std::end(flow));
                amount = std::min(amount, model.slip_intake * total / most_flow);
                // From the top voxel downwards (Fig. 36).
                for (int z = surface;
                     z >= std::max(static_cast<int>(span.bottom), surface - model.slip_depth) &&
                     amount > 0;
                     --z) {
                    const Voxel& voxel = before.at(x, y, z);
                    const double taken = std::min(amount, voxel.soil);
                    const bool is_other = voxel.is_mixed() || top.is_mixed() || voxel.water > 0 ||
                                          top.water > 0 ||
                                          voxel.main_material() != top.main_material();
                    const SoilState below = state_of(voxel, x, y, z);
                    const bool by_density = (model.regains && below == SoilState::loose) ||
                                            (model.dilates && below == SoilState::bonded);
                    if (taken > 0 && !falls && (is_other || by_density || below != state) &&
                        wedge(voxel, below, worst_slope).height <=
                            standing_wedge(model, voxel, x, y, z)) {
                        break;
                    }
                    amount -= taken;
                    for (int k = 0; k < 8 && taken > 0; ++k) {
                        if (flow[k] <= 0) continue;
                        const Neighbour& to = ring[k];
                        const double share = std::min(taken * flow[k] / total,
                                                      most_taken(to.x, to.y, to.z, span.top)) /
                                             voxel.soil;
                        Voxel& target = after.field.at(to.x, to.y, to.z);
                        move_share(voxel, after.field.at(x, y, z), target, share);
                        target.soil += dilation(model, voxel) * share;
                        if (!to.falls) continue;
                        // It takes part in the fall.
                        const Voxel& at_top = before.at(to.x, to.y, to.z);
                        const Voxel& falling = at_top.soil >= model.arch_least
                                                   ? at_top
                                                   : before.at(to.x, to.y, to.z - 1);
                        const double faster = falling.momentum.z / falling.total_mass() -
                                              voxel.momentum.z / voxel.total_mass();
                        target.momentum.z += std::min(0.0, faster) * voxel.total_mass() * share;
                    }
                }
            }
        }
    }
    return after;
}

}  // namespace oracle
