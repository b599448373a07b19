#include "soil/tile_codec.h"

namespace bsoil {
namespace {

// A column starts with its number of runs; 0 stands for "as the column before" (a tile has at least
// one voxel up, so no column has 0 runs).
constexpr uint32_t kSameColumn = 0;

void put(std::vector<uint8_t>& out, uint32_t value) {
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
            if (byte < 128) {
                return value;
            }
        }
        ok = false;
        return 0;
    }
};

bool same_voxel(const TileVoxels& t, int column, int z, int other_column, int other_z) {
    for (int p = 0; p < t.plane_count; ++p) {
        if (t.at(p, z, column) != t.at(p, other_z, other_column)) {
            return false;
        }
    }
    return true;
}

}  // namespace

std::vector<uint8_t> pack_tile(const TileVoxels& tile) {
    std::vector<uint8_t> out;
    for (int column = 0; column < 64; ++column) {
        bool same = column > 0;
        for (int z = 0; same && z < tile.height; ++z) {
            same = same_voxel(tile, column, z, column - 1, z);
        }
        if (same) {
            put(out, kSameColumn);
            continue;
        }
        uint32_t run_count = 1;
        for (int z = 1; z < tile.height; ++z) {
            run_count += !same_voxel(tile, column, z, column, z - 1);
        }
        put(out, run_count);
        for (int z = 0; z < tile.height;) {
            int end = z + 1;
            while (end < tile.height && same_voxel(tile, column, end, column, z)) {
                ++end;
            }
            put(out, static_cast<uint32_t>(end - z));
            uint32_t mask = 0;
            for (int p = 0; p < tile.plane_count; ++p) {
                mask |= tile.at(p, z, column) != 0 ? 1u << p : 0u;
            }
            put(out, mask);
            for (int p = 0; p < tile.plane_count; ++p) {
                if (mask & (1u << p)) {
                    put(out, zigzag(tile.at(p, z, column)));
                }
            }
            z = end;
        }
    }
    out.shrink_to_fit();
    return out;
}

bool unpack_tile(std::span<const uint8_t> bytes, TileVoxels& tile) {
    std::fill(tile.words.begin(), tile.words.end(), 0);
    if (bytes.empty()) {
        return true;  // a tile of nothing but air
    }
    Reader in{bytes};
    for (int column = 0; column < 64; ++column) {
        const uint32_t run_count = in.get();
        if (!in.ok || (run_count == kSameColumn && column == 0)) {
            return false;
        }
        if (run_count == kSameColumn) {
            for (int p = 0; p < tile.plane_count; ++p) {
                for (int z = 0; z < tile.height; ++z) {
                    tile.at(p, z, column) = tile.at(p, z, column - 1);
                }
            }
            continue;
        }
        int z = 0;
        for (uint32_t run = 0; run < run_count; ++run) {
            const uint32_t length = in.get();
            const uint32_t mask = in.get();
            if (!in.ok || length == 0 || length > static_cast<uint32_t>(tile.height - z) ||
                (mask >> tile.plane_count) != 0) {
                return false;
            }
            for (int p = 0; p < tile.plane_count; ++p) {
                if (mask & (1u << p)) {
                    const int32_t value = unzigzag(in.get());
                    for (uint32_t i = 0; i < length; ++i) {
                        tile.at(p, z + static_cast<int>(i), column) = value;
                    }
                }
            }
            z += static_cast<int>(length);
        }
        if (!in.ok || z != tile.height) {
            return false;
        }
    }
    return in.at == bytes.size();
}

}  // namespace bsoil
