/// WorkLaw: yield from the work that propagation does on what a face displaces.
#pragma once

#include <vector>

#include "bsoil/contact/contact_law.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// The path of what a face pushes, and the work on it per volume. Angles in rad, no units else.
///
/// A face that goes in by a millimetre displaces a millimetre of soil times its area, and the grid
/// carries that volume to the free surface. So there is a yield stress without any motion: the
/// virtual work per volume. A push turns from the face's normal to the way on which confined soil
/// yields, which rises at 45 deg - phi / 2 (apply_force, propagate_force). All that moves on the
/// path is at failure, so that shear on it is tan phi times what presses on it.
class WorkPath {
  public:
    /// friction_angle_rad: 0..1.2; friction: of the face, 0..tan phi, no units.
    WorkPath(double friction_angle_rad, double friction);

    /// Work per volume over the overburden, of a path that turns by turn_rad before it rises; at
    /// least 1, which is lifting alone. Rising is Kp = tan^2(45 deg + phi / 2): 1 for lifting and
    /// (Kp - 1) for the shear on the wedge's plane. A bend multiplies by exp(2 turn tan phi), as a
    /// rope's friction round a bollard does: friction is in proportion to the pressure that it adds
    /// to. pi / 2, a level sole: Prandtl's Nq. 0, an upright wall: Rankine's Kp.
    double work_share(double turn_rad) const;
    /// What friction along the face makes of it. Soil leaves along the face at rise() times the
    /// approach, and the face rubs against it by what it slides past that: 1 / (1 + friction
    /// past_flow). past_flow: rise() times the cosine between that slip and the way to the surface,
    /// -rise() to rise(). Below 0 soil is pushed out against the friction, at most 1 + sin phi
    /// times as hard; above 0 the face's friction does part of the work. No units.
    double rubbed_share(double past_flow) const;

    double sine() const { return sine_; }                   ///< of phi
    double tangent() const { return tangent_; }             ///< of phi
    double rise() const { return rise_; }                   ///< tan(45 deg - phi / 2): of the path
    double friction() const { return friction_; }           ///< of the face
    double rankine() const { return 1 / (rise_ * rise_); }  ///< Kp

  private:
    double sine_ = 0, tangent_ = 0, rise_ = 1, friction_ = 0;
};

/// The normal stress at yield is the work on a volume that an element displaces, over that volume:
///
///     gamma (d + (F - 1) (d + z) + F S) D
///
///   lifting    gamma d: from the element to the free surface, d above it
///   shear      (F - 1) gamma (d + z), F = WorkPath::work_share(): in proportion to the mean
///              overburden on the path. z: how far the path runs below the element in the mean
///   sides      S = (1 - sin phi) tan phi / sin(45 deg - phi / 2) (d^2 + d h + h^2 / 3) / (Kp w):
///              of the rising wedge, w wide, at rest pressure
///   along      D = WorkPath::rubbed_share(). Along the face soil moves as its path begins,
///              whatever the face does: the path is the grid's, not the easiest with friction
///
/// Under a sole of width B soil goes out to both sides, from half the width each, in a wedge h =
/// B / 2 tan(45 deg + phi / 2) high: z = h / 2, as wide as the sole is long. The zone opens with
/// the sinkage, over ContactLawDef::mobilization_widths. Before a wall there is no such zone, and
/// the path is as wide as the wall. So the widths are the body's and not a voxel's. Between the two
/// z goes by the square of the normal's part that looks down; F knows the inclination by itself.
///
/// Ours, fixed before it was held against any measurement: soil leaves a sole across the shorter
/// side, the shorter way, in a path that grows no wider, as the grid's pushes do. Larger h: soles
/// bear more, in proportion to their width; all four sides would give a square half of it. The
/// sides are at rest pressure, 1 - sin phi, as soil beside a path that has not moved. Larger:
/// narrow blades and short soles meet more; smaller, down to nothing, as endless ones.
///
/// D was chosen of several forms beside two measured wheels (docs/records/work_law_in_the_grid.md).
///
/// Under soles phi is Bolton's at the density of the soil there, if that is known, as in
/// GranularLaw (peak_friction_angle()). The stress that Bolton asks for is the mean of its
/// logarithm along the bend: gamma (d + z) / (1 - sin phi) exp(turn tan phi). Elsewhere, and at
/// tips and faces, phi is the critical state's.
///
/// A material enters by its density and its angle of friction, a surface by its friction. No
/// constant is fitted. Cohesion, the speed and Janosi's K do not enter. Teeth are as for PlainLaw.
/// What is left out: a rough sole's dead wedge, and the corners of a sole, at which paths part.
class WorkLaw final : public ContactLaw {
  public:
    /// soil: not null.
    WorkLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface);
    /// See ContactLaw::yield().
    ElementYield yield(const ContactElement& element, const ElementMotion& motion,
                       const ContactHistory& memory) const override;

    /// Lifting part of the work per volume that an element displaces [Pa].
    double lifting_pa(const ContactVoxel& contact) const;

  private:
    struct Strength {
        double weight_n_m3 = 0;         ///< gamma
        double friction_angle_rad = 0;  ///< of the critical state
        double sides = 0;               ///< of S: without Kp
        WorkPath face, trapped;         ///< against the body, against soil between its teeth
    };
    /// How high the zone under a sole is [m]. sole: of bearing_parts().
    double zone_m(const WorkPath& path, const FaceExtent& face, double sole, double depth_m) const;
    /// Of soil whose density is known: at Bolton's angle.
    WorkPath dense_path(const Strength& soil, const WorkPath& path, const FaceExtent& face,
                        Vec3 normal, double depth_m) const;
    /// Work per volume of a push along the normal, over gamma [m].
    double overburden_m(const Strength& soil, const WorkPath& path, const FaceExtent& face,
                        Vec3 normal, double depth_m) const;

    std::vector<Strength> strengths_;  ///< indexed by ContactVoxel::material
};

}  // namespace bsoil
#pragma GCC visibility pop
