/// BodyCollector: finds the collision objects that touch the grid and describes them to the soil.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "body_state.h"
#include "bsoil/bullet/soil_action_types.h"
#include "shape_conversion.h"

class btMultiBody;

namespace bsoil::bullet {

/// What Bullet's broadphase calls an object for as long as it is in the world; else kNotInWorld.
int proxy_id_of(const btCollisionObject& object);
inline constexpr int kNotInWorld = -1;  ///< no object's proxy_id_of

/// A body that is no object of the world.
struct GuestBody {
    BodyState state;
    std::shared_ptr<const std::vector<ConvexShape>> shapes;
    unsigned shape_revision = 0;
};

/// Keeps an id, and the converted shapes, for every object it has met in the world.
class BodyCollector {
  public:
    /// grid: the grid's box, world axes; voxel_m: edge of its voxels.
    explicit BodyCollector(const Aabb& grid, double voxel_m = 0.05);

    /// Until the object leaves the world.
    void set_options(const btCollisionObject& object, const BodyOptions& options);
    BodyOptions options(const btCollisionObject& object) const;
    /// Looks through the world once. elapsed_s: since the last call; a kinematic body that Bullet
    /// knows no velocity of is given that of its change of pose. Soils do not see one another.
    void collect(const btDiscreteDynamicsWorld& world, double elapsed_s);

    /// A dynamic rigid body now, between two collects; null where it takes no part or is outside of
    /// the grid. Valid until the next call.
    const BodyState* meet(const btDiscreteDynamicsWorld& world, btRigidBody& body);
    /// Adds a body to those of the last collect. Its id is one of take_id.
    void add_guest(GuestBody guest);
    /// An id that no object gets; -1 when there are no more.
    int take_id() { return next_id(); }
    void give_back_id(int id) { id_taken_[id] = false; }
    const Aabb& grid() const { return grid_; }

    /// Forgets all bodies, but not their options: the next call meets them as new ones. What it has
    /// refused stays so, and guests keep their ids.
    void let_go();

    /// Bodies that touch the grid, or did at the last call (so that the soil sees them leave); in
    /// the world's order.
    std::span<const BodyState> bodies() const { return bodies_; }
    /// Of a body of the last collect, in its own frame.
    std::span<const ConvexShape> shapes_of(const BodyState& body) const;
    /// The same bodies for Soil::step, moved back along their velocities to `before_s` ago.
    std::span<SoilBody> soil_bodies(double before_s);
    /// Whether the object takes part wherever it touches the grid: neither ignored nor refused.
    bool is_coupled(const btCollisionObject& object) const;
    const std::vector<RefusedBody>& refused() const { return refused_; }
    int body_id(const btCollisionObject& object) const;
    /// The object of an id; null: none has it now.
    const btCollisionObject* object_of(int id) const;

  private:
    friend class CouplingSnapshot;
    using Shapes = std::vector<ConvexShape>;
    struct ShapeKey {
        const btCollisionShape* shape;
        uint64_t fingerprint;
        bool operator==(const ShapeKey&) const = default;
    };
    struct ShapeKeyHash {
        size_t operator()(const ShapeKey& key) const;
    };
    struct Tracked {
        int proxy_id = 0;
        int id = 0;
        ShapeKey key{};
        std::shared_ptr<const Shapes> shapes;  ///< null: refused, or out of a snapshot
        bool has_no_shapes = false;            ///< they are refused
        std::string refusal;                   ///< why; empty out of a snapshot
        unsigned shape_revision = 0;
        bool has_pose = false;
        Pose last_pose;
        bool was_in_grid = false;
        unsigned long long seen_in_scan = 0;

        bool is_refused() const { return id < 0 || has_no_shapes; }
    };

    struct Options {
        BodyOptions value;
        int proxy_id = 0;  ///< kNotInWorld: waits for the object
        unsigned long long seen_in_scan = 0;
    };

    BodyOptions options_in_scan(const btCollisionObject& object);
    bool touches_grid(const btCollisionObject& object) const;
    Tracked& track(const btCollisionObject& object);
    void convert(const btCollisionObject& object, Tracked& tracked);
    void describe(const btDiscreteDynamicsWorld& world, btCollisionObject& object,
                  const BodyOptions& options, Tracked& tracked, double elapsed_s, BodyState& state);
    void read_link_velocity(const btMultiBody& multibody, int link, BodyMotion& motion);
    static void add_velocity_of_pose(const Tracked& tracked, double elapsed_s, BodyMotion& motion);
    void refuse(const btCollisionObject& object, const Tracked& tracked, const std::string& reason);
    int next_id();

    Aabb grid_;
    double voxel_m_;
    std::unordered_map<const btCollisionObject*, Options> options_;
    std::unordered_map<const btCollisionObject*, Tracked> tracked_;
    std::unordered_map<ShapeKey, std::weak_ptr<const Shapes>, ShapeKeyHash> shape_cache_;
    std::vector<bool> id_taken_;
    int last_id_ = -1;
    unsigned long long scan_ = 1;  ///< 0: an object that none has met
    std::vector<BodyState> bodies_;
    BodyState met_;
    std::vector<GuestBody> guests_;  ///< the last of bodies_
    std::vector<SoilBody> soil_bodies_;
    std::vector<RefusedBody> refused_;
    std::vector<const GridFrame*> grids_;  ///< of all soils of the world, as of the last collect
    const btMultiBody* velocity_owner_ =
        nullptr;  ///< whose link velocities are in the two vectors below
    std::vector<btVector3> link_angular_, link_linear_;
};

}  // namespace bsoil::bullet
