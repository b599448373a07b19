/// WorkLists: which blocks a step looks at, and the lists that kernels run over.
#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "soil/shape_upload.h"
#include "soil/tile_table.h"

namespace bsoil {

/// A work list whose entries lie in Buffer::block_list.
struct ListedWork : device::WorkList {
    int list_offset = 0;  ///< of group 0's entry, SoilParams::list_offset
};

/// Blocks become active where soil moves, and are listed with their neighbours in the next steps.
class WorkLists {
  public:
    WorkLists(SoilCore& core, TileTable& tiles) : core_(core), tiles_(tiles) {}
    /// Once the device is there.
    void start();

    // --- what is active
    void activate(BlockKey block);
    /// For a bank that may fail over this block: see grant_asked().
    void ask(BlockKey block) { asked_.push_back(block); }
    /// Activates all that was asked for, if any of it was not before, since anything but banks made
    /// a block active. Else the same would come of it, which is nothing.
    void grant_asked();
    bool is_active(BlockKey block) const { return active_.count(block) != 0; }
    /// Active blocks, and the step in which each last changed.
    const std::unordered_map<BlockKey, int64_t>& active() const { return active_; }
    /// Blocks that banks have been granted, sorted; since anything but banks made a block active.
    const std::vector<BlockKey>& granted() const { return granted_; }
    /// Of the step in progress, before its kernels ran.
    int active_count() const { return active_count_; }

    // --- of the step in progress
    /// Blocks of awake (or, for bodies that can move soil, waking) tiles that the body's shapes
    /// touch and that are near soil.
    void find_body_blocks(const StepBody& body, bool may_wake, std::vector<BlockKey>& blocks);
    /// Coverage is made anew in these; where that moves soil, they are active.
    void mark_rebuild(const std::vector<BlockKey>& blocks, bool changes_soil);
    /// Marks where bodies make a new coverage necessary; wakes the tiles of those that can move
    /// soil.
    void mark_bodies(std::span<StepBody> bodies);
    /// Wakes and lists what is active and the blocks around it.
    void wake_active();
    /// Marks the bodies' blocks once more, now that all tiles are awake: those that woke in this
    /// step, and those with contacts or loads.
    void mark_woken(std::span<StepBody> bodies);
    /// Marks all blocks of awake tiles, for all lists.
    void mark_all();
    /// The lists out of all that was marked.
    void build();
    /// One more, of pairs of words, the first of which is a slot; in the order of the slots.
    /// Between build() and build_pairs().
    void add_list(ListedWork& list, std::span<const std::pair<int32_t, int32_t>> groups);
    /// (slot, body) pairs of small bodies whose middle is in an awake tile. As add_list().
    void list_small_bodies(std::span<const StepBody> bodies);
    /// (block, shape) pairs of the blocks whose coverage is made anew. Uploads the lists.
    void build_pairs(const ShapeUpload& shapes);

    bool is_listed(int slot, int zb) const {
        const auto block = static_cast<size_t>(slot) * static_cast<size_t>(core_.blocks_per_tile) +
                           static_cast<size_t>(zb);
        return listed_step_[block] == core_.step_index;
    }
    const ListedWork& listed() const { return listed_; }      ///< soil may move
    const ListedWork& tiles() const { return tile_; }         ///< tiles with a listed block
    const ListedWork& restored() const { return restored_; }  ///< others: TileTable::is_restored()
    const ListedWork& rebuild() const { return rebuild_; }    ///< coverage is made anew
    const ListedWork& pairs() const { return pair_; }         ///< these with a shape each
    const ListedWork& contacts() const { return contact_; }   ///< at bodies that move
    const ListedWork& small_bodies() const { return small_body_; }

    /// A kernel has something to do.
    bool any_work() const {
        return listed_.group_count + rebuild_.group_count + tile_.group_count > 0;
    }

    /// Forgets all marks; these blocks are active, and these have been granted.
    void restart(std::unordered_map<BlockKey, int64_t> active,
                 std::span<const BlockKey> granted = {});

  private:
    void make_active(BlockKey block);
    int device_block(BlockKey key) const;
    /// Adds those of `before`, where a body's coverage stood, that its boxes still touch: it is
    /// made anew there as long as anything is, and has to go when the body does.
    void keep_covered(const StepBody& body, std::span<const BlockKey> before,
                      std::vector<BlockKey>& blocks);
    bool touches(const StepBody& body, BlockKey key) const;
    void mark_contacts(std::span<const BlockKey> blocks);
    void list_restored();
    void fit();
    /// So that a step allocates nothing for the blocks that get active in it.
    void keep_room_for(size_t block_count);

    SoilCore& core_;
    TileTable& tiles_;
    std::unordered_map<BlockKey, int64_t> active_;
    std::vector<BlockKey> asked_;
    std::vector<BlockKey> granted_;
    int active_count_ = 0;
    ListedWork listed_, tile_, restored_, rebuild_, pair_, contact_, small_body_;
    /// By device block: the last step it was in that list.
    std::vector<int64_t> listed_step_, rebuild_step_, contact_step_;
    size_t capacity_ = 0;  ///< of Buffer::block_list
    /// Words of all lists but the pairs, and how many of them the device has.
    size_t used_ = 0, uploaded_ = 0;
    bool device_lists_any_ = true;  ///< whether a kFlagListed of the device may be set
    // Scratch, kept so that a step does not allocate once warm.
    std::vector<int32_t> words_, listed_flags_;
    std::vector<BlockKey> body_blocks_, fresh_blocks_, covered_blocks_;
    std::vector<int> waking_;  ///< tiles
    std::vector<std::pair<BlockKey, int64_t>> sorted_active_;
    std::vector<std::unordered_map<BlockKey, int64_t>::node_type> spare_;  ///< out of active_
    std::vector<std::pair<int32_t, int32_t>> block_shapes_, slot_bodies_;
};

}  // namespace bsoil
