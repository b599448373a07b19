/// The multi-level heightfield of the thesis, section 3.2.3, Tables 1 to 3, with the vertical index
/// upwards.
///
/// Deviations from the thesis:
/// - a voxel at least half covered is rigid from its bottom to its top (the thesis asks for full
/// inner voxels and reads the
///   partly covered ones beside them as part of the span): the same rule that closes voxels to
///   inflow;
/// - a voxel counts as full when it lacks no more than the slack that lets it carry what is above
/// it;
/// - partial coverage under soil adds to the height of a span only in the span's lowest voxel
/// (Table 2, row 1), where it
///   carries the soil; on the floor also without soil;
/// - where soil falls in arches (arches.h) it thins out: a falling span has voxels half full, some
/// of them at least;
/// - edge spans depend on two columns and are made by slip_soil (slippage.h).
#pragma once

#include <span>
#include <vector>

#include "oracle/field.h"

namespace oracle {

struct Span {
    enum class Kind { rigid, piled, falling };
    double bottom = 0, top = 0;  ///< above the floor
    Kind kind = Kind::piled;
};

/// What a voxel may lack and count as full for its column's pile; of a load on a body, its topmost
/// voxel carries nothing.
double slack_at(const Model& model, const Field& field, int x, int y, int z);

/// Of one column, bottom-up. More than model.span_capacity may come back.
std::vector<Span> height_spans(const Model& model, const Field& field, int x, int y);

struct FreeSurface {
    /// covered: a body covers the voxel at it or the next. bare: terrain does, and the height is
    /// the terrain's.
    enum class Kind { free, covered, bare };
    Kind kind = Kind::free;
    double height = 0;
};

/// Top of the topmost piled span that does not stand on a body and is not bare terrain.
FreeSurface free_surface(const Model& model, const Field& field, const std::vector<Span>& spans,
                         int x, int y);

/// What a piled span stands on: a body that may move, by its index; -1: anything else.
int base_of(const Model& model, const Field& field, std::span<const Body> bodies, const Span& span,
            int x, int y);

/// Whether no body covers the voxel of a span's top or the next.
bool is_top_free(const Field& field, const Span& span, int x, int y);

}  // namespace oracle
