/// How much of the soil between the teeth of a row goes with them.
#pragma once

#include "bsoil/body.h"
#include "bsoil/contact/contact_law_def.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Share 0..1 of the soil between two teeth that goes with them: the passive wedge before each
/// tooth. 0 where there is no row.
double trapped_share(const ToothRow& teeth, double friction_angle_rad);

/// Share 0..1 of the height of an element's teeth that lies below the soil's surface. depth_m: of
/// the element.
double filled_share(const ToothRow& teeth, double depth_m, Vec3 up);

/// Depth by which an element bears [m]: ContactVoxel::bearing_depth_m; over the tips that of the
/// roots. Teeth cut into the soil between them and do not press it down: it has gone down as far as
/// what stands behind it.
double bearing_depth_of(const ContactVoxel& contact, Vec3 up);

/// Share 0..1 of an element that is there. Over the tips, and of what the teeth stand on, it goes
/// by how much soil is trapped and filled; of the teeth's faces towards each other by how much is
/// not filled: a tooth and its wedge go as one. 1 where there is no row: tips and ends of teeth are
/// as of any shape. Nothing is trapped without ContactLawDef::trapped_soil.
double area_share_of(const ContactVoxel& contact, double friction_angle_rad,
                     const ContactLawDef& law, Vec3 up);

}  // namespace bsoil
#pragma GCC visibility pop
