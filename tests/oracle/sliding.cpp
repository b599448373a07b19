#include "oracle/sliding.h"

#include <array>
#include <numbers>
#include <optional>

#include "oracle/slippage.h"

namespace oracle {
double tan_phi(const Model& model, const Voxel& voxel) {
    std::vector<double> of_materials;
    for (double angle : model.friction_angle_rad) of_materials.push_back(std::tan(angle));
    return voxel.mean(of_materials);
}

namespace {

constexpr double kTableSlopeMost = 4;  // beyond it friction is next to nothing

bool slides(const Voxel& voxel) { return voxel.momentum.x != 0 || voxel.momentum.y != 0; }

void halt(Voxel& voxel) { voxel.momentum.x = voxel.momentum.y = 0; }

/// A column's slide: voxels low..high.
struct Slide {
    int low = 0, high = -1;
    double top = 0, thickness = 0, mass = 0, vx = 0, vy = 0;
};

class Pass {
  public:
    Pass(const Model& model, const Field& before, const Stands& stands)
        : model_(model),
          stands_(stands),
          surfaces_(free_surfaces(model, before)),
          before_(before),
          now_(before) {}

    Field run() {
        std::vector<Slide> found;
        for (int y = 0; y < now_.ny; ++y) {
            for (int x = 0; x < now_.nx; ++x) found.push_back(slow_down(x, y));
        }
        std::vector<double> sinkages;
        for (size_t i = 0; i < found.size(); ++i) {
            const int y = static_cast<int>(i) / now_.nx;
            sinkages.push_back(sinkage(static_cast<int>(i) - y * now_.nx, y, found[i]));
        }
        Field after = now_;
        for (int y = 0; y < now_.ny; ++y) {
            for (int x = 0; x < now_.nx; ++x) {
                const Slide& slide = found[static_cast<size_t>(y) * now_.nx + x];
                if (slide.vx != 0 || slide.vy != 0) move_on(x, y, slide, sinkages, after);
            }
        }
        return after;
    }

  private:
    const FreeSurface& surface(int x, int y) const {
        return surfaces_[static_cast<size_t>(y) * now_.nx + x];
    }

    /// Height of what the soil on top of a column rests on.
    double foot(int x, int y) const {
        for (const Span& span : height_spans(model_, before_, x, y)) {
            if (span.kind == Span::Kind::piled && span.top == surface(x, y).height) {
                return span.bottom;
            }
        }
        return 0;
    }

    /// How much lower the ground at (x, y) is; nothing where that bars the way.
    std::optional<double> drop(int x, int y, const Slide& slide) const {
        if (!now_.inside(x, y, 0)) return {};
        const FreeSurface& there = surface(x, y);
        const double drop = slide.top - there.height;
        if (there.kind == FreeSurface::Kind::covered) return {};
        if (now_.closed(model_, x, y, static_cast<int>(std::floor(there.height)))) return {};
        return drop < -std::max(1.0, slide.thickness) ? std::optional<double>() : drop;
    }

    /// Lets what lies on gaps that slips have left down into them; the surface's height then.
    double close_gaps(int x, int y, double top) {
        int to = static_cast<int>(std::floor(top)), z = to + 1;
        for (; z < now_.nz; ++z) {
            Voxel &from = now_.at(x, y, z), &under = now_.at(x, y, z - 1);
            const double room = 1 - under.psi() - under.soil, held = from.soil;
            if (held == 0 || now_.closed(model_, x, y, z)) break;
            if (room <= 0 || room > model_.slide_creep) break;
            const double share = std::min(1.0, room / held);
            const Voxel was = from;
            move_share(was, from, under, share);
            under.bond += share * was.bond;
            if (share == 1) from.soil = from.bond = 0;
            to = room >= held ? z - 1 : z;
        }
        if (z == static_cast<int>(std::floor(top)) + 1) return top;
        return to + std::min(1.0, now_.at(x, y, to).soil);
    }

    /// The column's slide, slowed down by friction, with what that leaves of its momentum.
    Slide slow_down(int x, int y) {
        Slide slide;
        const FreeSurface& here = surface(x, y);
        if (here.kind != FreeSurface::Kind::free || here.height <= 0) {
            for (int z = 0; z < now_.nz; ++z) {
                Voxel& voxel = now_.at(x, y, z);
                if (voxel.support.kind == Support::Kind::ground) halt(voxel);
            }
            return slide;
        }
        slide.top = close_gaps(x, y, here.height);
        slide.high = static_cast<int>(std::ceil(slide.top)) - 1;
        slide.low = slide.high + 1;
        Vec3 momentum;
        for (int z = slide.high, gap = 0;
             z >= 0 && z > slide.high - model_.slide_depth && gap < model_.slide_gap; --z) {
            if (now_.closed(model_, x, y, z)) break;
            const Voxel& voxel = now_.at(x, y, z);
            ++gap;
            if (!slides(voxel)) continue;
            gap = 0;
            slide.low = z;
            momentum += voxel.momentum;
        }
        for (int z = slide.low; z <= slide.high; ++z) {
            slide.mass += now_.at(x, y, z).total_mass();
            slide.thickness += now_.at(x, y, z).soil;
        }
        if (slide.mass > 0 && slide.thickness > model_.crumb) {
            slide.vx = std::clamp(momentum.x / slide.mass, -model_.slide_speed, model_.slide_speed);
            slide.vy = std::clamp(momentum.y / slide.mass, -model_.slide_speed, model_.slide_speed);
        }
        const int ahead_x = x + (slide.vx < 0 ? -1 : 1), ahead_y = y + (slide.vy < 0 ? -1 : 1);
        const auto drop_x = drop(ahead_x, y, slide), drop_y = drop(x, ahead_y, slide);
        if (!drop_x) slide.vx = 0;
        if (!drop_y) slide.vy = 0;
        if (const double pace = std::hypot(slide.vx, slide.vy); pace > 0) {
            // Down the plane through the columns here, beside along the larger speed, and diagonal.
            // Off a ledge no further than the soil on it is high.
            const double most = slide.top - foot(x, y);
            double dx = slide.vx == 0 ? 0 : std::min(most, *drop_x);
            double dy = slide.vy == 0 ? 0 : std::min(most, *drop_y);
            if (const auto both = drop(ahead_x, ahead_y, slide);
                both && slide.vx != 0 && slide.vy != 0) {
                (std::abs(slide.vx) >= std::abs(slide.vy) ? dy : dx) =
                    std::min(most, *both) - (std::abs(slide.vx) >= std::abs(slide.vy) ? dx : dy);
            }
            const double slope =
                std::clamp((dx * std::abs(slide.vx) + dy * std::abs(slide.vy)) / pace,
                           -kTableSlopeMost, kTableSlopeMost);
            const Voxel& top = now_.at(x, y, slide.high);
            const double standing = standing_wedge(model_, top, x, y, slide.high);
            double held = tan_phi(model_, top) + std::min(standing, kTableSlopeMost) - slope;
            if (stands_(top, slope, standing)) held = std::max(held, model_.slip_tolerance);
            const double lost =
                model_.gravity / model_.slide_count * std::max(0.0, held) / (1 + slope * slope);
            const double kept = std::max(0.0, 1 - lost / pace) * kept_of_viscous(top);
            slide.vx *= kept;
            slide.vy *= kept;
        }
        for (int z = slide.low; z <= slide.high; ++z) {
            Voxel& voxel = now_.at(x, y, z);
            voxel.momentum.x = voxel.total_mass() * slide.vx;
            voxel.momentum.y = voxel.total_mass() * slide.vy;
        }
        return slide;
    }

    double kept_of_viscous(const Voxel& soil) const {
        if (model_.viscosity.empty()) return 1;
        if (soil.mean(model_.viscosity) >= 1) return 0;
        std::vector<double> drag;
        for (double viscosity : model_.viscosity) {
            drag.push_back(viscosity < 1
                               ? std::min(16.0, -std::log(1 - viscosity) * 60 * model_.step_s)
                               : 16.0);
        }
        return 1 / (1 + soil.mean(drag) / model_.slide_count);
    }

    struct Way {
        int x, y;
        double share;
        double height;  ///< of the ground there
    };
    struct Ways {
        std::array<Way, 3> to;
        double wanted = 0;  ///< sum of the shares
        double amount = 0;  ///< of soil that leaves
    };

    Ways ways_of(int x, int y, const Slide& slide) const {
        const int dx = slide.vx < 0 ? -1 : 1, dy = slide.vy < 0 ? -1 : 1;
        const double along_x = std::min(1.0, std::abs(slide.vx) / model_.slide_count);
        const double along_y = std::min(1.0, std::abs(slide.vy) / model_.slide_count);
        Ways ways{{{{x + dx, y, along_x * (1 - along_y), 0},
                    {x, y + dy, along_y * (1 - along_x), 0},
                    {x + dx, y + dy, along_x * along_y, 0}}}};
        for (Way& way : ways.to) {
            const auto down = way.share > 0 ? drop(way.x, way.y, slide) : std::nullopt;
            if (!down) way.share = 0;
            way.height = slide.top - down.value_or(0);
            ways.wanted += way.share;
        }
        ways.amount = slide.thickness * std::min(1.0, ways.wanted);
        return ways;
    }

    /// By how much the surface sinks as gaps are closed and what slides leaves.
    double sinkage(int x, int y, const Slide& slide) const {
        if (slide.high < slide.low && slide.top == 0) return 0;
        const double closed = surface(x, y).height - slide.top;
        double left = ways_of(x, y, slide).amount;
        if (left == 0) return closed;
        int z = slide.high;
        for (; z >= slide.low && now_.at(x, y, z).soil <= left; --z) left -= now_.at(x, y, z).soil;
        if (z < 0) return closed + slide.top;
        return closed +
               std::max(0.0, slide.top - z - std::clamp(now_.at(x, y, z).soil - left, 0.0, 1.0));
    }

    void move_on(int x, int y, const Slide& slide, const std::vector<double>& sinkages,
                 Field& after) const {
        Ways ways = ways_of(x, y, slide);
        for (Way& way : ways.to) {
            if (way.share > 0) way.height -= sinkages[static_cast<size_t>(way.y) * now_.nx + way.x];
        }
        double amount = ways.amount;
        for (int z = slide.high; z >= slide.low && amount > 0; --z) {
            const Voxel& source = now_.at(x, y, z);
            const double taken = std::min(amount, source.soil);
            amount -= taken;
            for (Way& way : ways.to) {
                double left = taken * way.share / ways.wanted;
                for (int n = 0; n < 3 && left > 0; ++n) {
                    const int target = static_cast<int>(std::floor(way.height));
                    if (now_.closed(model_, way.x, way.y, target)) break;
                    const double room = target + 1 - way.height;
                    const double part = n == 2 ? left : std::min(left, room);
                    Voxel& to = after.at(way.x, way.y, target);
                    move_share(source, after.at(x, y, z), to, part / source.soil);
                    to.soil += dilation(model_, source) * part / source.soil;
                    way.height += part;
                    left -= part;
                }
            }
        }
    }

    const Model& model_;
    const Stands& stands_;
    const std::vector<FreeSurface> surfaces_;
    const Field& before_;
    Field now_;
};

/// Part of gravity that drives soil along the ground: (s - tan phi) / (1 + s^2). On slopes beyond
/// Coulomb's wedge it is that wedge's, tan(45 deg - phi / 2) / 2.
double push_of(double slope, double tan_phi, double passive) {
    if (slope * passive >= 1) return passive / 2;
    return std::max(0.0, slope - tan_phi) / (1 + slope * slope);
}

}  // namespace

std::vector<FreeSurface> free_surfaces(const Model& model, const Field& field) {
    std::vector<FreeSurface> surfaces;
    for (int y = 0; y < field.ny; ++y) {
        for (int x = 0; x < field.nx; ++x) {
            surfaces.push_back(free_surface(model, field, height_spans(model, field, x, y), x, y));
        }
    }
    return surfaces;
}

Field slide_soil(const Model& model, const Field& before, const Stands& stands) {
    return Pass(model, before, stands).run();
}

void set_sliding(const Model& model, const Field& before, const std::vector<FreeSurface>& surfaces,
                 const FailingSlope& at, Field& after) {
    const int high = static_cast<int>(std::ceil(at.top)) - 1;
    const double friction = tan_phi(model, before.at(at.x, at.y, high));
    std::vector<double> passive;  // of a mixture it is the mean, as all else is
    for (double angle : model.friction_angle_rad) {
        passive.push_back(std::tan(std::numbers::pi / 4 - angle / 2));
    }
    const double push =
        model.slide_kick * push_of(at.slope, friction, before.at(at.x, at.y, high).mean(passive));
    // The nearest of the eight directions: tan(22.5 deg) is 0.41.
    const auto step = [](double along, double across) {
        return std::abs(along) > 0.4 * std::abs(across) ? (along > 0) - (along < 0) : 0;
    };
    const int dx = step(at.fall_x, at.fall_y), dy = step(at.fall_y, at.fall_x);
    const double climb = friction * std::hypot(dx, dy);
    double base = at.top;
    for (int n = 1; n <= model.slide_reach && climb * n < base; n += std::max(1, n / 4)) {
        const int x = at.x + n * dx, y = at.y + n * dy;
        if (!before.inside(x, y, 0)) break;
        base = std::min(base, surfaces[static_cast<size_t>(y) * before.nx + x].height + climb * n);
    }
    std::vector<int> driven;
    double thickness = 0;
    for (int z = high; z >= 0; --z) {
        const Voxel& voxel = before.at(at.x, at.y, z);
        if (z < std::floor(base) && !slides(voxel)) break;  // what slides is driven as a whole
        if (before.closed(model, at.x, at.y, z)) break;
        if (voxel.total_mass() == 0) continue;
        if (at.stands(voxel, z)) break;
        driven.push_back(z);
        thickness += voxel.soil;
    }
    if (thickness <= model.crumb) return;
    for (const int z : driven) {
        const double mass = before.at(at.x, at.y, z).total_mass();
        after.at(at.x, at.y, z).momentum +=
            Vec3{mass * push * at.fall_x, mass * push * at.fall_y, 0};
    }
}

}  // namespace oracle
