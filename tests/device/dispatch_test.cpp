/// Buffers, and dispatches with many groups, atomics and colours, on every backend.
#include <algorithm>
#include <numeric>

#include "device_fixture.h"

namespace bsoil::device::dispatch_test {
namespace {

class Dispatch : public AnyDevice {};

TEST_P(Dispatch, new_buffers_are_zero_and_keep_what_is_written) {
    ASSERT_TRUE(device_->allocate(Buffer::inputs, 1000));
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 1000), std::vector<int32_t>(1000, 0));
    const std::vector<int32_t> words{1, -2, 3};
    device_->write(Buffer::inputs, 500, words);
    std::vector<int32_t> back(5);
    device_->read(Buffer::inputs, 499, back);
    EXPECT_EQ(back, (std::vector<int32_t>{0, 1, -2, 3, 0}));
    device_->fill_zero(Buffer::inputs, 501, 1);
    device_->read(Buffer::inputs, 499, back);
    EXPECT_EQ(back, (std::vector<int32_t>{0, 1, 0, 3, 0}));
    ASSERT_TRUE(device_->allocate(Buffer::inputs, 600));
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 600), std::vector<int32_t>(600, 0));
}

TEST_P(Dispatch, what_moves_is_kept_when_a_buffer_is_rearranged) {
    ASSERT_TRUE(device_->allocate(Buffer::inputs, 6));
    device_->write(Buffer::inputs, 0, std::vector<int32_t>{1, 2, 3, 4, 5, 6});
    const WordMove rows[2] = {{0, 0, 2}, {3, 5, 2}};
    ASSERT_TRUE(device_->rearrange(Buffer::inputs, 10, rows));
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 10),
              (std::vector<int32_t>{1, 2, 0, 0, 0, 4, 5, 0, 0, 0}));
    const WordMove back[2] = {{0, 0, 2}, {5, 2, 2}};
    ASSERT_TRUE(device_->rearrange(Buffer::inputs, 4, back));
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 4), (std::vector<int32_t>{1, 2, 4, 5}));
}

// More than an address space has, and a device: an error, and the words are still there.
TEST_P(Dispatch, a_buffer_that_cannot_be_rearranged_stays_as_it_was) {
    ASSERT_TRUE(device_->allocate(Buffer::inputs, 2));
    device_->write(Buffer::inputs, 0, std::vector<int32_t>{7, 8});
    const WordMove all{0, 0, 2};
    EXPECT_FALSE(device_->rearrange(Buffer::inputs, int64_t{1} << 46, {&all, 1}));
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 2), (std::vector<int32_t>{7, 8}));
    EXPECT_EQ(device_->memory_bytes(), 8);
}

TEST_P(Dispatch, writes_and_fills_count_in_their_order) {
    using Words = std::vector<int32_t>;
    ASSERT_TRUE(device_->allocate(Buffer::inputs, 10));
    // Side by side, in no order, one of them twice.
    device_->write(Buffer::inputs, 4, Words{5, 6});
    device_->write(Buffer::inputs, 0, Words{1, 2});
    device_->write(Buffer::inputs, 2, Words{9, 9});
    device_->write(Buffer::inputs, 6, Words{7});
    device_->write(Buffer::inputs, 2, Words{3, 4});
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 10), (Words{1, 2, 3, 4, 5, 6, 7, 0, 0, 0}));
    // One over another.
    device_->write(Buffer::inputs, 5, Words{11, 12, 13});
    device_->fill_zero(Buffer::inputs, 0, 6);
    device_->write(Buffer::inputs, 3, Words{14, 15});
    device_->fill_zero(Buffer::inputs, 7, 1);
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 10), (Words{0, 0, 0, 14, 15, 0, 12, 0, 0, 0}));
    device_->write(Buffer::inputs, 9, Words{16});
    const WordMove all{0, 1, 10};
    ASSERT_TRUE(device_->rearrange(Buffer::inputs, 11, {&all, 1}));
    EXPECT_EQ(read_words(*device_, Buffer::inputs, 11),
              (Words{0, 0, 0, 0, 14, 15, 0, 12, 0, 0, 16}));
}

// Each more than half of what waits on its way to OpenGL; the last one more than all of it.
TEST_P(Dispatch, large_writes_count_in_their_order) {
    constexpr int kWords = 5 << 20;
    ASSERT_TRUE(device_->allocate(Buffer::inputs, kWords));
    for (const int32_t value : {1, 2}) {
        device_->write(Buffer::inputs, 0, std::vector<int32_t>(kWords / 2, value));
    }
    device_->write(Buffer::inputs, kWords - 1, std::vector<int32_t>{3});
    const std::vector<int32_t> words = read_words(*device_, Buffer::inputs, kWords);
    EXPECT_TRUE(std::all_of(words.begin(), words.begin() + kWords / 2,
                            [](int32_t word) { return word == 2; }));
    EXPECT_EQ(words[kWords / 2], 0);
    EXPECT_EQ(words.back(), 3);
    std::vector<int32_t> all(kWords, 4);
    all[7] = 5;
    device_->write(Buffer::inputs, 7, std::vector<int32_t>{6});
    device_->write(Buffer::inputs, 0, all);
    EXPECT_EQ(read_words(*device_, Buffer::inputs, kWords), all);
}

TEST_P(Dispatch, empty_transfers_and_dispatches_do_nothing) {
    ASSERT_TRUE(device_->allocate(Buffer::counts, 0));
    device_->write(Buffer::counts, 0, {});
    device_->read(Buffer::counts, 0, {});
    device_->read({});
    device_->fill_zero(Buffer::counts, 0, 0);
    dispatch(*device_, mark_groups, WorkList{});
    EXPECT_EQ(device_->failure(), "");
}

TEST_P(Dispatch, memory_is_counted) {
    const int64_t before = device_->memory_bytes();
    ASSERT_TRUE(device_->allocate(Buffer::inputs, 1 << 20));
    EXPECT_EQ(device_->memory_bytes() - before, 4 << 20);
}

TEST_P(Dispatch, buffers_have_the_names_of_the_kernels) {
    for (int i = 0; i < Buffer::count; ++i) {
        ASSERT_TRUE(device_->allocate(BufferIndex{i}, kLanesPerGroup));
        const std::vector<int32_t> initial(kLanesPerGroup, 100);
        device_->write(BufferIndex{i}, 0, initial);
    }
    dispatch(*device_, touch_buffers, plain_work(1));
    for (int i = 0; i < Buffer::count; ++i) {
        EXPECT_EQ(read_words(*device_, BufferIndex{i}, kLanesPerGroup),
                  std::vector<int32_t>(kLanesPerGroup, 101 + i))
            << i;
    }
}

TEST_P(Dispatch, more_groups_than_one_row_each_run_once) {
    constexpr int kGroups = 65535 + 777;  // a full row of work groups and part of a second one
    constexpr int kOffset = 5;
    std::vector<int32_t> list(kOffset + kGroups);
    std::iota(list.begin(), list.end(), 40);
    ASSERT_TRUE(device_->allocate(Buffer::entries, std::ssize(list)));
    ASSERT_TRUE(device_->allocate(Buffer::counts, 2 * kGroups));
    device_->write(Buffer::entries, 0, list);
    TestParams params{};
    params.list_offset = kOffset;
    dispatch(*device_, mark_groups, plain_work(kGroups, 16), params);
    const auto result = read_words(*device_, Buffer::counts, 2 * kGroups);
    for (int group = 0; group < kGroups; ++group) {
        ASSERT_EQ(result[2 * group], kLanesPerGroup) << group;
        ASSERT_EQ(result[2 * group + 1], list[kOffset + group]) << group;
    }
}

TEST_P(Dispatch, atomics_lose_nothing) {
    constexpr int kGroups = 300;
    constexpr int kLanes = kGroups * kLanesPerGroup;
    ASSERT_TRUE(device_->allocate(Buffer::counts, 16));
    ASSERT_TRUE(device_->allocate(Buffer::tickets, kLanes));
    const std::vector<int32_t> lowest(1, -1'000'000);
    device_->write(Buffer::counts, 2, lowest);
    dispatch(*device_, count_atomically, plain_work(kGroups));
    const auto result = read_words(*device_, Buffer::counts, 5);
    EXPECT_EQ(result[0], kLanes);
    EXPECT_EQ(result[1], kLanes - 1);
    EXPECT_EQ(result[2], -1);
    EXPECT_EQ(result[3], -1);
    EXPECT_EQ(result[4], 0);
    EXPECT_EQ(read_words(*device_, Buffer::tickets, kLanes), std::vector<int32_t>(kLanes, 1));
}

/// The layout the kernels read, as constants of the host.
namespace layout {
#define CONST_INT(name, value) inline constexpr int name = value;
#include "kernels/test_layout.h"
#undef CONST_INT
}  // namespace layout

/// A square of tiles without a border beyond it, coloured like a 2 x 2 chessboard.
struct TileGrid {
    static constexpr int kSide = 13;
    static constexpr int kTiles = kSide * kSide;
    static constexpr int kGroupsPerTile = 3;
    static constexpr int kColumns = kTiles * layout::kTileColumns;

    TileGrid() : tile_table(kTiles * layout::kTileNeighbours, layout::kAbsent) {
        for (int tile = 0; tile < kTiles; ++tile) {
            const int x = tile % kSide, y = tile / kSide;
            for (int side = 0; side < 9; ++side) {
                tile_table[tile * layout::kTileNeighbours + side] =
                    tile_at(x + side % 3 - 1, y + side / 3 - 1);
            }
            const int first_group = static_cast<int>(tile_of_group.size());
            tile_of_group.insert(tile_of_group.end(), kGroupsPerTile, tile);
            work.tiles_by_colour[(y & 1) * 2 + (x & 1)].push_back({first_group, kGroupsPerTile});
        }
        work.group_count = static_cast<int>(tile_of_group.size());
    }

    static int tile_at(int x, int y) {
        const bool is_inside = x >= 0 && y >= 0 && x < kSide && y < kSide;
        return is_inside ? y * kSide + x : layout::kAbsent;
    }

    std::vector<int32_t> tile_table, tile_of_group;
    WorkList work;
};

TEST_P(Dispatch, scatter_over_colours_adds_up) {
    const TileGrid grid;
    ASSERT_TRUE(device_->allocate(Buffer::neighbours, std::ssize(grid.tile_table)));
    ASSERT_TRUE(device_->allocate(Buffer::entries, std::ssize(grid.tile_of_group)));
    ASSERT_TRUE(device_->allocate(Buffer::outputs, TileGrid::kColumns));
    ASSERT_TRUE(device_->allocate(Buffer::counts, TileGrid::kColumns));
    device_->write(Buffer::neighbours, 0, grid.tile_table);
    device_->write(Buffer::entries, 0, grid.tile_of_group);
    constexpr int kRepeats = 10;
    for (int i = 0; i < kRepeats; ++i) dispatch(*device_, scatter_to_neighbours, grid.work);

    // The same from the receiving column's side, in coordinates of the whole grid.
    std::vector<int32_t> sums(TileGrid::kColumns), largest(TileGrid::kColumns);
    const int width = TileGrid::kSide * layout::kTileSide;
    for (int y = 0; y < width; ++y) {
        for (int x = 0; x < width; ++x) {
            const int column = (y / 8 * TileGrid::kSide + x / 8) * 64 + y % 8 * 8 + x % 8;
            for (int way = 0; way < 9; ++way) {
                const int from_x = x - (way % 3 - 1) * 4, from_y = y - (way / 3 - 1) * 4;
                if (from_x < 0 || from_y < 0 || from_x >= width || from_y >= width) continue;
                const int tile = TileGrid::tile_at(from_x / 8, from_y / 8);
                sums[column] += kRepeats * TileGrid::kGroupsPerTile * (1000 * way + tile);
                largest[column] = std::max(largest[column], 9 * tile + way);
            }
        }
    }
    EXPECT_EQ(read_words(*device_, Buffer::outputs, TileGrid::kColumns), sums);
    EXPECT_EQ(read_words(*device_, Buffer::counts, TileGrid::kColumns), largest);
}

TEST_P(Dispatch, one_read_takes_parts_of_several_buffers) {
    std::vector<int32_t> numbers(5000);
    std::iota(numbers.begin(), numbers.end(), -2500);
    ASSERT_TRUE(device_->allocate(Buffer::inputs, 5000));
    ASSERT_TRUE(device_->allocate(Buffer::outputs, 100));
    device_->write(Buffer::inputs, 0, numbers);
    device_->write(Buffer::outputs, 0, std::span(numbers).first(100));
    std::vector<int32_t> end(1000), none, middle(7), other(100);
    const ReadRange ranges[] = {{Buffer::inputs, 4000, end},
                                {Buffer::inputs, 0, none},
                                {Buffer::inputs, 13, middle},
                                {Buffer::outputs, 0, other}};
    device_->read(ranges);
    EXPECT_TRUE(std::ranges::equal(end, std::span(numbers).subspan(4000)));
    EXPECT_TRUE(std::ranges::equal(middle, std::span(numbers).subspan(13, 7)));
    EXPECT_TRUE(std::ranges::equal(other, std::span(numbers).first(100)));
}

// Three blocks where they are small: words in each, across their borders, and as they grow.
TEST_P(Dispatch, a_long_buffer_lies_in_as_many_blocks_as_it_needs) {
    constexpr int64_t kBlock = 1 << 20, kWords = 2 * kBlock + 5000, kGrown = 3 * kBlock + 100;
    device_->expect(Buffer::marks, kGrown);
    ASSERT_TRUE(device_->allocate(Buffer::marks, kBlock - 5));
    ASSERT_TRUE(device_->allocate(Buffer::outputs, 4096));
    const std::vector<int32_t> first{1, 2, 3};
    device_->write(Buffer::marks, kBlock - 8, first);
    ASSERT_TRUE(device_->grow(Buffer::marks, kWords));
    std::vector<int32_t> numbers(kBlock + 100);
    std::iota(numbers.begin(), numbers.end(), 0);
    device_->write(Buffer::marks, kBlock - 50, numbers);
    device_->fill_zero(Buffer::marks, 2 * kBlock - 3, 6);
    std::vector<int32_t> back(kBlock + 100);
    device_->read(Buffer::marks, kBlock - 50, back);
    std::ranges::fill(std::span(numbers).subspan(kBlock + 47, 6), 0);
    EXPECT_EQ(back, numbers);

    const WordMove moves[] = {{kBlock - 10, 5, 20}, {100, 2 * kBlock - 40, kBlock}};
    ASSERT_TRUE(device_->rearrange(Buffer::marks, kGrown, moves));
    std::vector<int32_t> moved(20), rest(kBlock);
    const ReadRange ranges[] = {{Buffer::marks, 5, moved}, {Buffer::marks, 2 * kBlock - 40, rest}};
    device_->read(ranges);
    EXPECT_TRUE(std::ranges::equal(moved, std::span(numbers).subspan(40, 20)));
    EXPECT_EQ(rest[kBlock - 151], 0);  // as the words below block 1 were
    EXPECT_EQ(rest[kBlock - 150], 0);  // the first number
    EXPECT_EQ(rest[kBlock - 149], 1);

    constexpr int kLanes = 4096, kStride = static_cast<int>(kGrown / kLanes);
    ASSERT_TRUE(device_->allocate(Buffer::marks, kGrown));
    TestParams params{};
    params.stride = kStride;
    for (int i = 0; i < 2; ++i) {
        dispatch(*device_, touch_long_buffer, plain_work(kLanes / kLanesPerGroup), params);
    }
    const std::vector<int32_t> marks = read_words(*device_, Buffer::marks, kGrown);
    const std::vector<int32_t> outputs = read_words(*device_, Buffer::outputs, kLanes);
    for (int i = 0; i < kLanes; ++i) {
        const int at = i * kStride, after_first = 1000 + at;
        ASSERT_EQ(marks[static_cast<size_t>(at)], after_first + 11) << i;
        ASSERT_EQ(outputs[static_cast<size_t>(i)], (after_first + 1) * 4 + 1) << i;
    }
    EXPECT_EQ(std::ranges::count_if(marks, [](int32_t mark) { return mark != 0; }), kLanes);
    EXPECT_EQ(device_->failure(), "");
}

// More than the staging memory of OpenGL holds at once, and many times over before anyone waits.
TEST_P(Dispatch, much_is_written_before_anyone_waits) {
    constexpr int64_t kWords = 5 << 20;
    std::vector<int32_t> numbers(kWords);
    ASSERT_TRUE(device_->allocate(Buffer::inputs, kWords + 7));
    for (int round = 1; round <= 3; ++round) {
        std::iota(numbers.begin(), numbers.end(), round);
        device_->write(Buffer::inputs, round, numbers);
    }
    std::vector<int32_t> back(kWords);
    device_->read(Buffer::inputs, 3, back);
    EXPECT_EQ(back, numbers);
}

TEST_P(Dispatch, what_is_asked_of_a_device_is_counted) {
    ASSERT_TRUE(device_->allocate(Buffer::counts, 64));
    ASSERT_TRUE(device_->allocate(Buffer::entries, 8));
    const DeviceCounters before = device_->counters();
    const std::vector<int32_t> words(8, 1);
    device_->write(Buffer::entries, 0, words);
    device_->write(Buffer::entries, 0, {});
    device_->fill_zero(Buffer::counts, 0, 64);
    dispatch(*device_, mark_groups, plain_work(8));
    dispatch(*device_, mark_groups, WorkList{});
    std::vector<int32_t> back(16), entries(8);
    const ReadRange ranges[] = {{Buffer::counts, 0, back}, {Buffer::entries, 0, entries}};
    device_->read(ranges);
    const DeviceCounters& after = device_->counters();
    EXPECT_EQ(after.write_count - before.write_count, 1);
    EXPECT_EQ(after.write_bytes - before.write_bytes, 32);
    EXPECT_EQ(after.fill_count - before.fill_count, 1);
    EXPECT_EQ(after.dispatch_count - before.dispatch_count, 1);
    EXPECT_EQ(after.group_count - before.group_count, 8);
    EXPECT_EQ(after.read_count - before.read_count, 1);
    EXPECT_EQ(after.read_bytes - before.read_bytes, 96);
}

TEST_P(Dispatch, stages_have_the_times_of_a_session_before) {
    ASSERT_TRUE(device_->allocate(Buffer::counts, 2 * 4096));
    ASSERT_TRUE(device_->allocate(Buffer::entries, 4096));
    for (int i = 0; i < 3; ++i) {
        const DeviceSession session(*device_);
        for (int stage : {1, 3, 1}) {
            device_->mark_stage(stage);
            dispatch(*device_, mark_groups, plain_work(4096));
        }
        std::vector<int32_t> back(1);
        device_->read(Buffer::counts, 0, back);
    }
    const std::span<const double> ms = device_->stage_ms();
    for (int stage = 0; stage < Device::kStageCapacity; ++stage) {
        EXPECT_EQ(ms[static_cast<size_t>(stage)] > 0, stage == 1 || stage == 3) << stage;
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, Dispatch,
                         testing::Values("cpu1", "cpu2", "gl", "gl_as_hardware",
                                         "gl_in_small_blocks"),
                         [](const auto& device) { return device.param; });

}  // namespace
}  // namespace bsoil::device::dispatch_test
