/// How much of the soil between the teeth of a row goes with them.
#pragma once

#include "bsoil/body.h"
#include "bsoil/contact/contact_law_def.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Share 0..1 of the soil between teeth that goes with them: the passive wedge before each tooth,
/// and the tooth itself, over the pitch. 0 where there is no row.
double trapped_share(const ToothRow& teeth, double friction_angle_rad);

/// Share 0..1 of the height of an element's teeth that lies below the soil's surface. depth_m: of
/// the element.
double filled_share(const ToothRow& teeth, double depth_m, Vec3 up);

/// Share 0..1 of an element's motion that goes along its row, by the squares of its parts: a tooth
/// takes along what it pushes, and cuts into what it is pressed upon. 1 at rest. motion: any unit;
/// creep: of the same, what counts as rest (ContactLawDef::creep).
double pushed_share(const ToothRow& teeth, Vec3 motion, double creep);

/// Share 0..1 of an element that is there: over the tips as much as soil is trapped, filled and
/// pushed along, on rim and teeth the rest. 1 where there is no row. motion: of the element,
/// ElementMotion::share; nothing is trapped without ContactLawDef::trapped_soil.
double area_share_of(const ContactVoxel& contact, Vec3 motion, double friction_angle_rad,
                     const ContactLawDef& law, Vec3 up);

}  // namespace bsoil
#pragma GCC visibility pop
