#include "soil/tile_codec.h"

#include <algorithm>
#include <bit>

namespace bsoil {
namespace {

// A column starts with its number of runs; 0 stands for "as the column before" (a tile has at least
// one voxel up, so no column has 0 runs).
constexpr uint32_t kSameColumn = 0;

/// Bytes one after the other where there is room for all of them.
struct RoomyBytes {
    uint8_t* at;
    void push_back(uint8_t byte) { *at++ = byte; }
};

template <typename Out>
void put(Out& out, uint32_t value) {
    while (value >= 128) {
        out.push_back(static_cast<uint8_t>(value | 128));
        value >>= 7;
    }
    out.push_back(static_cast<uint8_t>(value));
}

uint32_t zigzag(int32_t v) {
    return (static_cast<uint32_t>(v) << 1) ^ static_cast<uint32_t>(v >> 31);
}
int32_t unzigzag(uint32_t v) { return static_cast<int32_t>((v >> 1) ^ (0u - (v & 1))); }

struct Reader {
    std::span<const uint8_t> bytes;
    size_t at = 0;
    bool ok = true;

    uint32_t get() {
        uint32_t value = 0;
        for (int shift = 0; shift < 35; shift += 7) {
            if (at >= bytes.size()) {
                ok = false;
                return 0;
            }
            const uint8_t byte = bytes[at++];
            value |= static_cast<uint32_t>(byte & 127) << shift;
            if (byte < 128) return value;
        }
        ok = false;
        return 0;
    }
};

template <typename Out>
void put_run(Out& out, const ColumnRun& run, int plane_count) {
    put(out, static_cast<uint32_t>(run.length));
    uint32_t mask = 0;
    for (int p = 0; p < plane_count; ++p) {
        mask |= run.values[static_cast<size_t>(p)] != 0 ? 1u << p : 0u;
    }
    put(out, mask);
    for (uint32_t rest = mask; rest != 0; rest &= rest - 1) {
        put(out, zigzag(run.values[static_cast<size_t>(std::countr_zero(rest))]));
    }
}

/// Calls same(column) for a column that is as the one before, else run(column, z, ...) for each of
/// its runs. False when the bytes are damaged.
template <typename Same, typename Run>
bool read_columns(std::span<const uint8_t> bytes, int height, int plane_count, Same&& same,
                  Run&& run_found) {
    if (bytes.empty()) {
        return true;  // a tile of nothing but air
    }
    Reader in{bytes};
    for (int column = 0; column < 64; ++column) {
        const uint32_t run_count = in.get();
        if (!in.ok || (run_count == kSameColumn && column == 0)) return false;
        if (run_count == kSameColumn) {
            same(column);
            continue;
        }
        int z = 0;
        for (uint32_t i = 0; i < run_count; ++i) {
            const uint32_t length = in.get();
            const uint32_t mask = in.get();
            if (!in.ok || length == 0 || length > static_cast<uint32_t>(height - z) ||
                (mask >> plane_count) != 0) {
                return false;
            }
            ColumnRun run;
            run.length = static_cast<int>(length);
            for (int p = 0; p < plane_count; ++p) {
                if (mask & (1u << p)) run.values[static_cast<size_t>(p)] = unzigzag(in.get());
            }
            if (!in.ok) return false;
            run_found(column, z, run);
            z += run.length;
        }
        if (z != height) return false;
    }
    return in.at == bytes.size();
}

/// What `tile` has room for: the first planes and the lowest levels.
bool unpack_part(std::span<const uint8_t> bytes, int packed_height, int packed_plane_count,
                 TileVoxels& tile) {
    std::fill(tile.words.begin(), tile.words.end(), 0);
    // Columns that are as the one before them, and not written yet: side by side in each level.
    int same_first = 0, same_count = 0;
    const auto write_same = [&] {
        for (int p = 0; p < tile.plane_count && same_count > 0; ++p) {
            for (int z = 0; z < tile.height; ++z) {
                std::fill_n(&tile.at(p, z, same_first), same_count, tile.at(p, z, same_first - 1));
            }
        }
        same_count = 0;
    };
    const bool is_whole = read_columns(
        bytes, packed_height, packed_plane_count,
        [&](int column) {
            if (same_count++ == 0) same_first = column;
        },
        [&](int column, int z, const ColumnRun& run) {
            if (z == 0) write_same();
            const int end = std::min(z + run.length, tile.height);
            for (int p = 0; p < tile.plane_count; ++p) {
                const int32_t value = run.values[static_cast<size_t>(p)];
                for (int up = z; value != 0 && up < end; ++up) tile.at(p, up, column) = value;
            }
        });
    write_same();
    return is_whole;
}

}  // namespace

std::vector<uint8_t> pack_tile(const TileVoxels& tile) {
    // Which bits differ from the voxel below and from the column before, of all planes: layer by
    // layer, as they lie in memory.
    thread_local std::vector<int32_t> changes;
    const auto height = static_cast<size_t>(tile.height);
    // What lies above is air, and as what is below it.
    const int levels = std::min(tile.height, filled_levels(tile) + 1);
    const auto looked = static_cast<size_t>(levels);
    changes.assign(looked * 64, 0);
    std::array<int32_t, 64> beside{};
    for (int p = 0; p < tile.plane_count; ++p) {
        const int32_t* words = &tile.words[static_cast<size_t>(p) * height * 64];
        for (size_t v = 64; v < looked * 64; ++v) changes[v] |= words[v] ^ words[v - 64];
        for (size_t z = 0; z < looked; ++z) {
            const int32_t* layer = words + z * 64;
            for (size_t c = 1; c < 64; ++c) beside[c] |= layer[c] ^ layer[c - 1];
        }
    }
    std::vector<uint8_t> out;
    for (int column = 0; column < 64; ++column) {
        if (column > 0 && beside[static_cast<size_t>(column)] == 0) {
            put(out, kSameColumn);
            continue;
        }
        const auto changes_at = [column](int z) {
            return changes[static_cast<size_t>(z) * 64 + static_cast<size_t>(column)] != 0;
        };
        uint32_t run_count = 1;
        for (int z = 1; z < levels; ++z) run_count += changes_at(z);
        put(out, run_count);
        for (int z = 0; z < tile.height;) {
            int end = z + 1;
            while (end < levels && !changes_at(end)) ++end;
            if (end >= levels) end = tile.height;
            ColumnRun run;
            run.length = end - z;
            for (int p = 0; p < tile.plane_count; ++p) {
                run.values[static_cast<size_t>(p)] = tile.at(p, z, column);
            }
            put_run(out, run, tile.plane_count);
            z = end;
        }
    }
    out.shrink_to_fit();
    return out;
}

bool unpack_tile(std::span<const uint8_t> bytes, TileVoxels& tile) {
    return unpack_part(bytes, tile.height, tile.plane_count, tile);
}

bool unpack_first_planes(std::span<const uint8_t> bytes, int packed_plane_count, TileVoxels& tile) {
    return unpack_part(bytes, tile.height, packed_plane_count, tile);
}

bool unpack_levels(std::span<const uint8_t> bytes, int packed_height, TileVoxels& tile) {
    return unpack_part(bytes, packed_height, tile.plane_count, tile);
}

int filled_levels(std::span<const uint8_t> bytes, int height, int plane_count) {
    constexpr std::array<int32_t, kTilePlanesMost> kAir{};
    int levels = 0;
    const bool is_whole = read_columns(
        bytes, height, plane_count, [](int) {},
        [&](int, int z, const ColumnRun& run) {
            if (run.values != kAir) levels = std::max(levels, z + run.length);
        });
    return is_whole ? levels : 0;
}

int filled_levels(const TileVoxels& tile) {
    const auto plane_words = static_cast<size_t>(tile.height) * 64;
    int levels = 0;
    for (int p = 0; p < tile.plane_count; ++p) {
        const int32_t* words = &tile.words[static_cast<size_t>(p) * plane_words];
        int z = tile.height;
        // All words of a level, without a branch for each: the compiler makes vectors of it.
        const auto is_air = [](const int32_t* level) {
            int32_t any = 0;
            for (int c = 0; c < 64; ++c) any |= level[c];
            return any == 0;
        };
        while (z > levels && is_air(words + static_cast<ptrdiff_t>(z - 1) * 64)) --z;
        levels = z;
    }
    return levels;
}

void TileRuns::append(int first, const ColumnRun& run) {
    if (static_cast<size_t>(first) < runs.size() && runs.back().values == run.values) {
        runs.back().length += run.length;
    } else {
        runs.push_back(run);
    }
}

std::vector<uint8_t> pack_runs(const TileRuns& tile) {
    // Grown once, not for every tile.
    thread_local std::vector<uint8_t> room;
    constexpr size_t kNumberBytes = 5;  // of 32 bits, 7 in each
    size_t run_count = 0;               // of columns that share theirs, every time
    for (const TileRuns::Range& range : tile.columns) run_count += static_cast<size_t>(range.count);
    const size_t most = kNumberBytes * (64 + run_count * (2 + kTilePlanesMost));
    if (room.size() < most) room.resize(most);
    RoomyBytes out{room.data()};
    for (int c = 0; c < 64; ++c) {
        const std::span<const ColumnRun> column = tile.column(c);
        const auto alike = [](const ColumnRun& a, const ColumnRun& b) {
            return a.length == b.length && a.values == b.values;
        };
        if (c > 0 && std::ranges::equal(column, tile.column(c - 1), alike)) {
            put(out, kSameColumn);
            continue;
        }
        put(out, static_cast<uint32_t>(column.size()));
        for (const ColumnRun& run : column) put_run(out, run, tile.plane_count);
    }
    return {room.data(), out.at};
}

bool unpack_runs(std::span<const uint8_t> bytes, TileRuns& tile) {
    tile.runs.clear();
    if (bytes.empty()) {
        ColumnRun air;
        air.length = tile.height;
        tile.runs.push_back(air);
        tile.columns.fill({0, 1});
        return true;
    }
    return read_columns(
        bytes, tile.height, tile.plane_count,
        [&](int column) {
            tile.columns[static_cast<size_t>(column)] =
                tile.columns[static_cast<size_t>(column) - 1];
        },
        [&](int column, int z, const ColumnRun& run) {
            TileRuns::Range& range = tile.columns[static_cast<size_t>(column)];
            if (z == 0) range = {static_cast<int>(tile.runs.size()), 0};
            tile.runs.push_back(run);
            ++range.count;
        });
}

}  // namespace bsoil
