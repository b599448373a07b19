/// What a .bullet file has to hold for Bullet to read it: counts of what pointers lead to, and the
/// structures of shapes, constraints and joints.
#pragma once

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyLink.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace bsoil::scene {

/// A pointer to as many elements as another field says.
struct CountedPointer {
    const char *structure, *pointer, *count;
};
inline constexpr CountedPointer kCounted[] = {
    {"btCompoundShapeData", "m_childShapePtr", "m_numChildShapes"},
    {"btMultiSphereShapeData", "m_localPositionArrayPtr", "m_localPositionArraySize"},
    {"btStridingMeshInterfaceData", "m_meshPartsPtr", "m_numMeshParts"},
    {"btMultiBodyFloatData", "m_links", "m_numLinks"},
    {"btMultiBodyDoubleData", "m_links", "m_numLinks"},
};
/// The same where one of several has to be there.
struct EitherPointer {
    const char *structure, *count;
    std::vector<std::pair<const char*, size_t>> pointers;
};
inline const std::vector<EitherPointer>& either() {
    static const std::vector<EitherPointer> kEither{
        {"btConvexHullShapeData",
         "m_numUnscaledPoints",
         {{"m_unscaledPointsFloatPtr", 1}, {"m_unscaledPointsDoublePtr", 1}}},
        {"btMeshPartData", "m_numVertices", {{"m_vertices3f", 1}, {"m_vertices3d", 1}}},
        {"btMeshPartData",
         "m_numTriangles",
         {{"m_indices32", 3}, {"m_3indices16", 1}, {"m_3indices8", 1}, {"m_indices16", 3}}},
    };
    return kEither;
}

/// The structures of shapes and constraints by the number that they carry.
struct Kind {
    int number;
    const char* structure;
};
inline constexpr Kind kShapes[] = {
    {BOX_SHAPE_PROXYTYPE, "btConvexInternalShapeData"},
    {SPHERE_SHAPE_PROXYTYPE, "btConvexInternalShapeData"},
    {CAPSULE_SHAPE_PROXYTYPE, "btCapsuleShapeData"},
    {CYLINDER_SHAPE_PROXYTYPE, "btCylinderShapeData"},
    {CONE_SHAPE_PROXYTYPE, "btConeShapeData"},
    {MULTI_SPHERE_SHAPE_PROXYTYPE, "btMultiSphereShapeData"},
    {CONVEX_HULL_SHAPE_PROXYTYPE, "btConvexHullShapeData"},
    {STATIC_PLANE_PROXYTYPE, "btStaticPlaneShapeData"},
    {TRIANGLE_MESH_SHAPE_PROXYTYPE, "btTriangleMeshShapeData"},
    {SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE, "btScaledTriangleMeshShapeData"},
    {GIMPACT_SHAPE_PROXYTYPE, "btGImpactMeshShapeData"},
    {COMPOUND_SHAPE_PROXYTYPE, "btCompoundShapeData"},
};
/// In single precision, in double, and in double from version 2.82 on.
struct ConstraintKind {
    int number;
    const char *single, *double_first, *double_now;
};
inline constexpr int kDoubleSince = 282;
inline constexpr ConstraintKind kConstraints[] = {
    {POINT2POINT_CONSTRAINT_TYPE, "btPoint2PointConstraintFloatData",
     "btPoint2PointConstraintDoubleData", "btPoint2PointConstraintDoubleData2"},
    {HINGE_CONSTRAINT_TYPE, "btHingeConstraintFloatData", "btHingeConstraintDoubleData",
     "btHingeConstraintDoubleData2"},
    {CONETWIST_CONSTRAINT_TYPE, "btConeTwistConstraintData", "btConeTwistConstraintData",
     "btConeTwistConstraintDoubleData"},
    {D6_CONSTRAINT_TYPE, "btGeneric6DofConstraintData", "btGeneric6DofConstraintData",
     "btGeneric6DofConstraintDoubleData2"},
    {SLIDER_CONSTRAINT_TYPE, "btSliderConstraintData", "btSliderConstraintData",
     "btSliderConstraintDoubleData"},
    {D6_SPRING_CONSTRAINT_TYPE, "btGeneric6DofSpringConstraintData",
     "btGeneric6DofSpringConstraintData", "btGeneric6DofSpringConstraintDoubleData2"},
    {D6_SPRING_2_CONSTRAINT_TYPE, "btGeneric6DofSpring2ConstraintData",
     "btGeneric6DofSpring2ConstraintDoubleData2", "btGeneric6DofSpring2ConstraintDoubleData2"},
    {FIXED_CONSTRAINT_TYPE, "btGeneric6DofSpring2ConstraintData",
     "btGeneric6DofSpring2ConstraintDoubleData2", "btGeneric6DofSpring2ConstraintDoubleData2"},
    {GEAR_CONSTRAINT_TYPE, "btGearConstraintFloatData", "btGearConstraintDoubleData",
     "btGearConstraintDoubleData"},
};
/// Variables of a multibody's joint: velocities and positions.
struct JointKind {
    int number, velocities, positions;
};
inline constexpr JointKind kJoints[] = {{btMultibodyLink::eRevolute, 1, 1},
                                        {btMultibodyLink::ePrismatic, 1, 1},
                                        {btMultibodyLink::eSpherical, 3, 4},
                                        {btMultibodyLink::ePlanar, 3, 3},
                                        {btMultibodyLink::eFixed, 0, 0}};

}  // namespace bsoil::scene
