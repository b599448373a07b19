/// GroundBodies: bodies that never move, which are to the soil what its terrain is.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "soil/body_table.h"
#include "soil/tile_table.h"
#include "soil/work_lists.h"

namespace bsoil {

/// What they cover is part of the terrain of each tile, awake or asleep, so that kernels, surface
/// heights and fills know it without a tile having to wake. Soil that lies where such a body
/// appears is buried: it leaves the voxels, is kept with its tile, and comes back when the body
/// goes.
class GroundBodies {
  public:
    GroundBodies(SoilCore& core, TileTable& tiles, BodyTable& bodies, WorkLists& lists)
        : core_(core), tiles_(tiles), bodies_(bodies), lists_(lists) {}

    /// Decides which of the bodies are ground, takes them out of the list, and brings the tiles up
    /// to date. A body that has been ground and now moves gives its place free, and is a body like
    /// others from this step on.
    void update(std::vector<StepBody>& step_bodies);
    /// Before the first step: bodies that will be ground in it, so that what was filled rests on
    /// them.
    void meet(std::span<const SoilBody> input);
    /// A ground body goes.
    void drop(const BodyTrack& track) { mark(track); }
    /// Of a tile that has just been made: what has been ground before it was.
    void stamp_new_tile(int index);
    bool is_over(int tile);
    /// The ground part of a tile's terrain becomes `cover` (may exceed a voxel). Soil buried by
    /// what was there comes back, soil that has no room now is buried. rock_changed: look for
    /// buried soil even where the ground is as before.
    void put(int index, const std::vector<int32_t>& cover, bool rock_changed = false);
    /// The bodies are others: list their shapes anew.
    void restart();

  private:
    /// A shape of a ground body.
    struct Shape {
        const ConvexShape* shape = nullptr;
        Pose pose;  ///< body -> grid, metres
        Aabb box;   ///< voxels
        bool is_over(int tx, int ty) const;
    };
    using Cover = std::vector<int32_t>;
    /// What a tile becomes under a cover.
    struct Outcome {
        bool is_changed = false, is_less = false;
        TileVoxels voxels;                         ///< of a tile awake
        std::shared_ptr<const PackedTile> packed;  ///< the same of a tile asleep
        TileBytes ground, buried;
    };
    /// What tiles asleep that held the same became under the same cover.
    struct Memo {
        using Content = std::tuple<std::shared_ptr<const PackedTile>, TileBytes, TileBytes>;
        struct Entry {
            const Cover* cover = nullptr;  ///< of `covers`
            bool is_known = false;         ///< what follows is
            Content after;
            bool unchecked = false;
        };
        std::map<Content, std::vector<Entry>> entries;
        /// Each once, by its hash: there are as many words as voxels in a tile.
        std::unordered_multimap<uint64_t, std::unique_ptr<const Cover>> covers;
        const Cover* last = nullptr;

        /// The one that is the same; null where it is none of them and there are too many.
        const Cover* find(const Cover& cover);
        /// What tiles with that content became; null: none was under this cover.
        Entry* find(const Content& before, const Cover* cover);
    };
    /// Tiles asleep that one after the other would take long, to be changed on all threads.
    struct Batch {
        struct Job {
            int index;
            const Cover* cover;          ///< of Memo::covers, or own
            std::unique_ptr<Cover> own;  ///< where it is none of those
            Outcome outcome;
        };
        std::vector<Job> jobs;
        /// Tiles that become what one of those becomes.
        std::vector<std::pair<int, const Cover*>> same;
    };
    void put_later(int index, const Cover& cover, Memo& memo, Batch& batch);
    void put_all(Memo& memo, Batch& batch);
    void take(int index, const Memo::Entry& entry);
    Outcome outcome_of(int index, const Cover& cover, bool rock_changed) const;
    void change(int index, Outcome&& outcome);
    void keep_shapes(const StepBody& body);
    void mark(const BodyTrack& track);
    const std::vector<Shape>& shapes();
    void stamp();
    void add(const Shape& shape, int index, std::vector<int32_t>& cover) const;

    SoilCore& core_;
    TileTable& tiles_;
    BodyTable& bodies_;
    WorkLists& lists_;
    std::vector<Shape> shapes_;
    bool is_listed_ = true;  ///< shapes_ are those of bodies_
    bool any_due_ = false;   ///< Tile::ground_due
};

}  // namespace bsoil
