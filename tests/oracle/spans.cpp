#include "oracle/spans.h"

#include <algorithm>

namespace oracle {

double slack_at(const Model& model, const Field& field, int x, int y, int z) {
    const Voxel& voxel = field.at(x, y, z);
    const bool carries = voxel.soil > 0 && z + 1 < field.nz && field.at(x, y, z + 1).soil > 0;
    return carries && voxel.support.kind == Support::Kind::body ? model.carry_slack
                                                                : model.support_slack;
}

std::vector<Span> height_spans(const Model& model, const Field& field, int x, int y) {
    const auto voxel = [&](int z) -> const Voxel& { return field.at(x, y, z); };
    const auto rigid = [&](int z) { return voxel(z).psi() >= model.solid_coverage; };
    const auto carries = [&](int z) {
        return voxel(z).soil + voxel(z).psi() >= 1 - slack_at(model, field, x, y, z);
    };
    // Soil that was never moved and is held with none under it: see roofs.h.
    const auto is_roof = [&](int at) {
        return !model.cohesion_height.empty() && at > 0 && !rigid(at) && voxel(at).soil > 0 &&
               voxel(at).support.kind == Support::Kind::ground && is_bonded(model, voxel(at));
    };
    std::vector<Span> spans;
    int z = 0;
    while (z < field.nz || spans.empty()) {
        // A piled span starts on the floor and on every rigid span (Table 2).
        const int floor = z;
        while (z < field.nz && !rigid(z) && carries(z)) ++z;
        double top = z;
        if (z < field.nz && !rigid(z)) {
            const Voxel& last = voxel(z);
            const bool lowest = z == floor;
            if (lowest && (last.soil > 0 || floor == 0)) {
                top += std::min(1.0, last.soil + last.psi());
            } else if (!lowest) {
                top += std::min(1.0, last.soil);
            }
            ++z;
        }
        spans.push_back({static_cast<double>(floor), top, Span::Kind::piled});
        // Falling spans up to the next rigid one (Table 3): voxels without anything rigid.
        const auto falling = [&](int at) {
            return voxel(at).soil >= (model.arch_reach > 0 ? model.arch_least : 1) &&
                   voxel(at).psi() == 0;
        };
        while (z < field.nz && !rigid(z) && !is_roof(z)) {
            const int bottom = z;
            while (z < field.nz && !rigid(z) && !is_roof(z) && falling(z)) ++z;
            if (z > bottom) {
                if (z - bottom < model.arch_shortest && voxel(bottom).soil < 1) continue;
                spans.push_back(
                    {static_cast<double>(bottom), static_cast<double>(z), Span::Kind::falling});
            } else {
                ++z;
            }
        }
        if (z < field.nz && rigid(z)) {  // Table 1
            const int bottom = z;
            while (z < field.nz && rigid(z)) ++z;
            spans.push_back(
                {static_cast<double>(bottom), static_cast<double>(z), Span::Kind::rigid});
        }
    }
    return spans;
}

int base_of(const Model& model, const Field& field, std::span<const Body> bodies, const Span& span,
            int x, int y) {
    const int below = static_cast<int>(span.bottom) - 1;
    if (span.kind != Span::Kind::piled || below < 0) return -1;
    const Voxel& voxel = field.at(x, y, below);
    if (voxel.psi() < model.solid_coverage || voxel.bodies <= voxel.terrain || voxel.owner < 0) {
        return -1;
    }
    return bodies[static_cast<size_t>(voxel.owner)].moves ? voxel.owner : -1;
}

bool is_top_free(const Field& field, const Span& span, int x, int y) {
    const int z = std::min(field.nz - 1, static_cast<int>(span.top));
    return !(field.at(x, y, z).bodies > 0) &&
           (z + 1 >= field.nz || !(field.at(x, y, z + 1).bodies > 0));
}

FreeSurface free_surface(const Model& model, const Field& field, const std::vector<Span>& spans,
                         int x, int y) {
    const auto covered = [&](int z) { return z < field.nz && field.at(x, y, z).bodies > 0; };
    const auto rock = [&](int z) {
        return z < field.nz && field.at(x, y, z).terrain >= model.solid_coverage;
    };
    for (auto span = spans.rbegin(); span != spans.rend(); ++span) {
        const int below = static_cast<int>(span->bottom) - 1;
        int rigid = below;  // under a roof further down
        while (rigid >= 0 && field.at(x, y, rigid).psi() < model.solid_coverage) --rigid;
        const bool on_body =
            rigid >= 0 && field.at(x, y, rigid).bodies > field.at(x, y, rigid).terrain;
        const bool empty = below >= 0 && span->top == span->bottom;
        if (span->kind != Span::Kind::piled || on_body || empty) continue;
        const int z = static_cast<int>(span->top);
        // Rock on it, or with no more than a voxel's room between them.
        const bool at_top = z < field.nz && field.at(x, y, z).psi() >= model.solid_coverage;
        int high = at_top ? z : z + 1;
        if (!rock(high)) {
            const bool hidden = covered(std::min(field.nz - 1, z)) || covered(z + 1);
            return {hidden ? FreeSurface::Kind::covered : FreeSurface::Kind::free, span->top};
        }
        while (rock(high)) ++high;
        const double last = field.at(x, y, high - 1).terrain;
        const double part = high < field.nz ? field.at(x, y, high).terrain : 0;
        return {FreeSurface::Kind::bare, part > 0 ? high + part : high - 1 + last};
    }
    return {};
}

}  // namespace oracle
