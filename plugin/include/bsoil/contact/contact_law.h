/// ContactLaw: the one door to what stress soil gives an element of a body's surface.
#pragma once

#include <memory>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/contact/contact_law_def.h"
#include "bsoil/material.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// The soil that a law is of.
struct ContactSoil {
    Vec3 up{0, 0, 1};  ///< unit
    double gravity_m_s2 = 9.81;
    double voxel_m = 0.05;
    std::vector<MaterialDef> materials;  ///< indexed by ContactVoxel::material
    ContactLawDef law;
};

/// Size and state of the face that an element belongs to. Zero width: too small to have one.
struct FaceExtent {
    double width_m = 0;   ///< the shorter side of a sole; the level side of a wall
    double length_m = 0;  ///< the longer side of a sole
    double depth_m = 0;   ///< of its deepest element below the surface
    /// Of the soil at it: 0 loose, 1 compacted. Soil whose density does not change is loose.
    double relative_density = 0;
    double foot_m = 0;  ///< depth of a wall's lower edge: half an element further down

    bool operator==(const FaceExtent&) const = default;  ///< to the bit
};

/// An element of a body's surface beside soil.
struct ContactElement {
    const ContactVoxel& voxel;
    FaceExtent face;
};

/// How it moves against what carries the soil.
struct ElementMotion {
    /// As a share of its body's motion, length 0..1. At rest it is zero, and the speed of the
    /// motion is in approach_m_s alone.
    Vec3 share;
    double approach_m_s = 0;  ///< along the normal, into the soil
    /// Whether ElementYield::mobilized_pa is wanted; else it stays zero, and costs nothing.
    bool asks_mobilized = true;
};

/// What a voxel of soil has been through beside a body.
struct ContactHistory {
    double sheared_m = 0;  ///< length of the path that the body's surface has slid along it
    double retreat_m = 0;  ///< how far the surface has drawn back since it pressed most
};

/// Stresses [Pa] at one element.
struct ElementYield {
    double normal_limit_pa =
        0;  ///< largest normal stress the soil can give the element if it is pushed in
    double pushed_pa = 0;    ///< what that would be if the element had not drawn back
    double friction = 0;     ///< shear over normal stress while sliding as it does
    double adhesion_pa = 0;  ///< shear stress besides
    /// Shear that comes with the normal stress and no friction against the sliding can give: it
    /// acts along the sliding, or across it. On the body, at the limit.
    Vec3 drag_pa;
    double area_share = 1;  ///< of the element that is there: see ContactLawDef::trapped_soil
    /// Direction of the sliding past the soil, shorter than 1 where the element hardly slides, or
    /// the soil goes along. Friction and adhesion are less there.
    Vec3 slide;
    Vec3 mobilized_pa;  ///< stress on the body from the motion as it is; zero unless it moves into
                        ///< the soil
};

/// How far soil that has been pressed down by depth_m follows what lets go of it.
double rebound_m(double depth_m, const ContactLawDef& law = {});

/// Share 0..1 of an element that touches its soil. Soil pressed down rebounds by a part of its
/// depth; a gap beyond that opens within ContactLawDef::open_gap_voxels. The soil asks once, when
/// the element is made: ContactVoxel::touching.
double touching_share(const ContactVoxel& contact, double voxel_m, const ContactLawDef& law = {});

/// Share 0..1 of the yield stress that is left once an element has drawn back from the soil by
/// retreat_m.
double unloaded_share(double depth_m, double retreat_m, const ContactLawDef& law = {});

/// A soil's law against bodies of one surface.
class ContactLaw {
  public:
    virtual ~ContactLaw() = default;
    /// As ContactSoil::law says, which must be valid. soil: not null.
    static std::unique_ptr<const ContactLaw> make(std::shared_ptr<const ContactSoil> soil,
                                                  const SurfaceFriction& surface = {});

    /// What an element meets: the only way to a stress. memory: of the voxel of soil beside it.
    virtual ElementYield yield(const ContactElement& element, const ElementMotion& motion,
                               const ContactHistory& memory) const = 0;

    /// How a contact's face slides past the soil beside it; the memory of shear adds it up.
    /// velocity_m_s: of the face against what carries the soil.
    virtual Vec3 slide_m_s(const ContactVoxel& contact, Vec3 velocity_m_s) const {
        return velocity_m_s - dot(velocity_m_s, contact.normal) * contact.normal;
    }

    const ContactLawDef& def() const { return soil_->law; }  ///< its constants
    const ContactSoil& soil() const { return *soil_; }       ///< what it is a law of
    Vec3 up() const { return soil_->up; }                    ///< unit, world axes
    double voxel_m() const { return soil_->voxel_m; }        ///< edge of a voxel

  protected:
    /// soil: not null.
    explicit ContactLaw(std::shared_ptr<const ContactSoil> soil) : soil_(std::move(soil)) {}

  private:
    std::shared_ptr<const ContactSoil> soil_;
};

}  // namespace bsoil
#pragma GCC visibility pop
