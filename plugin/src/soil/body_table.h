/// BodyTable: the bodies that the soil knows, and those of the step in progress.
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "bsoil/contact/known_contacts.h"
#include "contact/surface_samples.h"
#include "contact/wall_thickness.h"
#include "soil/soil_core.h"

namespace bsoil {

/// What a body's contacts hang on, as it was given.
struct GivenBody {
    Pose pose;
    Vec3 linear_velocity_m_s, angular_velocity_rad_s, center_of_mass_m;
    double contact_width_m = 0;
    bool operator==(const GivenBody& o) const;
};

/// What is known of a body from one step to the next.
struct BodyTrack {
    Pose pose;
    unsigned shape_revision = 0;
    /// Of its record in the shapes buffer and of its owner marks; -1 until drop_gone() where all
    /// are taken by bodies that this step does not have.
    int index = -1;
    bool is_static = false;
    int64_t last_step = -1;
    GivenBody given;               ///< in the last step
    std::vector<BlockKey> blocks;  ///< in which its coverage stands now, sorted
    WallShapes walls;
    SurfaceSamples surface;  ///< empty where the contact law goes by the coverage field
    bool is_small = false;   ///< no wider than a voxel, with faces to go by: see small_body_place()
    int64_t last_moved_step = INT64_MIN / 2;
    bool is_ground = false;  ///< part of the terrain: see ground_bodies.cpp
    Pose ground_pose;
    std::vector<ConvexShape> ground_shapes;  ///< of ground; empty after load(), until it is seen
    /// The body's own, and of which revision; of steps that outlast their call, see keep_given().
    std::vector<ConvexShape> kept_shapes;
    unsigned kept_revision = 0;
};

/// A body that takes part in a step, in grid axes and metres.
struct StepBody {
    const SoilBody* input = nullptr;
    BodyTrack* track = nullptr;
    Pose from, to;  ///< body frame -> grid, at the step's start and end
    bool moved = false;
    bool placed = false;         ///< not there before, not so, or not within reach
    bool turned_static = false;  ///< or movable: what rests on it rests on something else
    KnownContact contact{};      ///< width and pressure that count in this step
    /// Its shapes as the soil sees them.
    const std::vector<ConvexShape>& shapes() const {
        return track->walls.shapes.empty() ? *input->shapes : track->walls.shapes;
    }
};

/// The voxel with the middle of a small body.
struct SmallBodyPlace {
    int tile = 0;
    int32_t word = 0;  ///< kBodyPlace
};
/// None of a larger or a static body, nor of one whose middle is outside of the grid.
std::optional<SmallBodyPlace> small_body_place(const SoilCore& core, const StepBody& body);

/// Bodies by SoilBody::id, each with an index of its own while it is there.
class BodyTable {
  public:
    explicit BodyTable(SoilCore& core) : core_(core) {}

    /// Reads what a step is given: notes conditions, and fills in_step().
    void meet(std::span<const SoilBody> input);
    std::vector<StepBody>& in_step() { return in_step_; }
    /// Voxels that the fastest point of a body crosses in this step, and whose it is (may be null).
    double reach_voxels() const { return reach_voxels_; }
    const SoilBody* fastest() const { return fastest_; }
    /// All bodies are there that were there in the last step, and as they were.
    bool are_same() const { return are_same_; }
    bool any_moved() const;
    /// Copies what the step was given: its caller goes on, and comes back before the step is
    /// through.
    void keep_given();

    /// Drops the bodies that this step was not given; on_gone(track) is called first. Their indices
    /// go to those that found none.
    template <typename OnGone>
    void drop_gone(OnGone&& on_gone) {
        for (auto it = tracks_.begin(); it != tracks_.end();) {
            if (it->second.last_step != core_.step_index) {
                are_same_ = false;
                on_gone(it->second);
                ids_[static_cast<size_t>(it->second.index)] = -1;
                it = tracks_.erase(it);
            } else {
                ++it;
            }
        }
        for (StepBody& body : in_step_) {
            if (body.track->index < 0) body.track->index = take_index(body.input->id);
        }
    }

    /// False, and a condition, for what cannot take part.
    bool accept(const SoilBody& body);
    /// A body that was not there before. Its shapes are known after it.
    BodyTrack& add(const SoilBody& body);
    const std::unordered_map<int, BodyTrack>& tracks() const { return tracks_; }
    bool knows(int id) const { return tracks_.contains(id); }
    /// SoilBody::id by index; -1 = free.
    std::span<const int> ids() const { return ids_; }
    /// Of contacts with bodies, kept while the bodies are there.
    KnownContacts known_contacts;
    /// All that is known becomes this.
    void restart(std::unordered_map<int, BodyTrack> tracks, std::vector<int> ids);

  private:
    /// -1: all are taken.
    int take_index(int id);
    double reach_of(const StepBody& body) const;
    KnownContact contact_of(const SoilBody& body) const;
    void make_shapes(BodyTrack& track, const SoilBody& body) const;
    bool make_small_surface(const std::vector<ConvexShape>& shapes, SurfaceSamples& surface) const;

    SoilCore& core_;
    std::unordered_map<int, BodyTrack> tracks_;
    std::vector<int> ids_;
    std::vector<StepBody> in_step_;
    std::vector<SoilBody> kept_;
    double reach_voxels_ = 0;
    const SoilBody* fastest_ = nullptr;
    bool are_same_ = false;
};

}  // namespace bsoil
