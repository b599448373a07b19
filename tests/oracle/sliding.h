/// Slides that keep their momentum, written from docs/decisions/run_out.md.
///
/// The voxels of a column that move along the ground slide as one, with a thickness and a speed.
/// What the page leaves open, and the kernels' layout decides:
/// - a slide reaches from the surface down to the lowest voxel with momentum, past fewer than
/// slide_gap voxels without any, slide_depth voxels at most;
/// - a way is barred at the grid's end, under a body, and where the ground ahead is higher than the
/// column's by more than the slide is thick, and by more than a voxel;
/// - it is barred as well where the voxel that soil would come to lie in is closed;
/// - a slide no thicker than model.crumb has no speed, and is given none;
/// - where the ground fails, friction takes nothing: slip_soil drives the slide on. Where it
/// stands, by cohesion perhaps, friction is that of a slope flatter than phi by the tolerance, at
/// least. Roughness adds to it what it adds to the slope at which soil stands;
/// - shares go to the columns along x, along y and across the corner as in (15) of the thesis, each
/// filled from its surface up, three voxels at most at once;
/// - the surface that soil arrives on is the one that what slides has left there in the same pass;
/// - viscosity takes speed as (1 - viscosity)^(60 t) does, by implicit Euler steps.
#pragma once

#include <functional>

#include "oracle/field.h"
#include "oracle/spans.h"

namespace oracle {

/// free_surface() of every column, [y * nx + x].
std::vector<FreeSurface> free_surfaces(const Model& model, const Field& field);

/// Whether the soil of a voxel stands at a slope, where wedges up to `standing` voxels do.
using Stands = std::function<bool(const Voxel& soil, double slope, double standing)>;

/// One slide pass.
Field slide_soil(const Model& model, const Field& before, const Stands& stands);

/// A slope that was found failing.
struct FailingSlope {
    int x = 0, y = 0;
    double top = 0;                 ///< height of the column
    double slope = 0;               ///< of its steepest facet
    double fall_x = 0, fall_y = 0;  ///< where that leads down to, the mean of unit vectors
    std::function<bool(const Voxel& soil, int z)> stands;  ///< whether soil there stands at `slope`
};
/// Adds the momentum that the slope gives in this pass.
void set_sliding(const Model& model, const Field& before, const std::vector<FreeSurface>& surfaces,
                 const FailingSlope& at, Field& after);

/// Of a voxel's soil, by mass.
double tan_phi(const Model& model, const Voxel& voxel);

}  // namespace oracle
