// Snapshots: the whole state of a soil in a file.
//
//   8 bytes  "BSOILSNP"
//   u32      version
//   u64      hash of the bytes that follow (before compression)
//   u64      their count
//   ...      zstd: header words (grid, materials, step), then per tile that ever held something:
//            index, revision of packing, byte count, packed spans; then slip speeds of awake tiles;
//            then active blocks.
#include <fmt/format.h>
#include <zstd.h>

#include <cstdio>
#include <cstring>
#include <memory>

#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;
using device::Buffer;

namespace {

constexpr char kMagic[8] = {'B', 'S', 'O', 'I', 'L', 'S', 'N', 'P'};
constexpr uint32_t kVersion = 2;  // 2: slope_q16
constexpr uint64_t kBytesMax = uint64_t{1}
                               << 36;  // refuses sizes that only a damaged header can name

uint64_t hash_bytes(std::span<const uint8_t> bytes) {
    uint64_t h = 0xcbf29ce484222325ull;  // FNV-1a
    for (uint8_t byte : bytes) {
        h = (h ^ byte) * 0x100000001b3ull;
    }
    return h;
}

class Writer {
  public:
    template <typename T>
    void put(T value) {
        uint8_t raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        for (uint8_t byte : raw) {
            bytes.push_back(byte);
        }
    }
    void put_bytes(std::span<const uint8_t> data) {
        put<uint64_t>(data.size());
        bytes.insert(bytes.end(), data.begin(), data.end());
    }
    std::vector<uint8_t> bytes;
};

class Reader {
  public:
    explicit Reader(std::span<const uint8_t> data) : data_(data) {}
    template <typename T>
    T get() {
        T value{};
        if (data_.size() - at_ < sizeof(T)) {
            ok = false;
            return value;
        }
        std::memcpy(&value, data_.data() + at_, sizeof(T));
        at_ += sizeof(T);
        return value;
    }
    std::span<const uint8_t> get_bytes() {
        const uint64_t count = get<uint64_t>();
        if (!ok || count > data_.size() - at_) {
            ok = false;
            return {};
        }
        at_ += count;
        return data_.subspan(at_ - count, count);
    }
    bool at_end() const { return at_ == data_.size(); }
    bool ok = true;

  private:
    std::span<const uint8_t> data_;
    size_t at_ = 0;
};

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

}  // namespace

Status Soil::save(const std::string& path) const {
    const Impl& s = *impl_;
    Writer w;
    for (int size : s.frame.size) {
        w.put<int32_t>(size);
    }
    w.put<double>(s.frame.voxel_m);
    w.put<int32_t>(s.params.material_count);
    for (const MaterialDef& material : s.materials) {
        w.put_bytes({reinterpret_cast<const uint8_t*>(material.name.data()), material.name.size()});
    }
    w.put<int64_t>(s.step_index);
    w.put<int64_t>(s.speed_q16);
    w.put<int32_t>(s.slope_q16);
    w.put<uint32_t>(s.status);
    w.put<int32_t>(s.params.slip_turn);
    w.put<int32_t>(s.params.pass_stamp);
    TileVoxels voxels;
    std::vector<int32_t> columns(kTileColumns * kColumnWords);
    for (size_t index = 0; index < s.tiles.size(); ++index) {
        const Tile* tile = s.tiles[index].get();
        if (!tile) {
            continue;
        }
        w.put<int64_t>(static_cast<int64_t>(index));
        w.put<int32_t>(tile->slot >= 0);
        if (tile->slot < 0) {
            w.put_bytes(tile->packed);
            continue;
        }
        s.read_voxels(static_cast<int>(index), voxels);
        w.put_bytes(pack_tile(voxels));
        w.put<int64_t>(tile->last_used_step);
        s.device->read(Buffer::spans,
                       static_cast<int64_t>(tile->slot) * kTileColumns * kColumnWords, columns);
        for (int c = 0; c < kTileColumns; ++c) {
            for (int i = 0; i < 2 * kSpanCapacity; ++i) {
                w.put<int32_t>(columns[c * kColumnWords + kColumnSpeed + i]);
            }
        }
    }
    w.put<int64_t>(-1);
    w.put<uint64_t>(s.active.size());
    for (const auto& [block, changed] : s.active) {
        w.put<int64_t>(block);
        w.put<int64_t>(changed);
    }
    std::vector<uint8_t> packed(ZSTD_compressBound(w.bytes.size()));
    const size_t size =
        ZSTD_compress(packed.data(), packed.size(), w.bytes.data(), w.bytes.size(), 3);
    if (ZSTD_isError(size)) {
        return Error{fmt::format("snapshot '{}': {}", path, ZSTD_getErrorName(size))};
    }
    Writer head;
    for (char c : kMagic) {
        head.put(c);
    }
    head.put(kVersion);
    head.put(hash_bytes(w.bytes));
    head.put<uint64_t>(w.bytes.size());
    // Written beside and renamed: a crash does not leave half a snapshot under the name.
    const std::string part = path + ".part";
    bool good = false;
    if (File file{std::fopen(part.c_str(), "wb")}) {
        good =
            std::fwrite(head.bytes.data(), 1, head.bytes.size(), file.get()) == head.bytes.size() &&
            std::fwrite(packed.data(), 1, size, file.get()) == size && std::fflush(file.get()) == 0;
    }
    if (!good || std::rename(part.c_str(), path.c_str()) != 0) {
        std::remove(part.c_str());
        return Error{
            fmt::format("snapshot '{}' cannot be written: {}", path, std::strerror(errno))};
    }
    return Done{};
}

Status Soil::load(const std::string& path) {
    Impl& s = *impl_;
    const File file{std::fopen(path.c_str(), "rb")};
    if (!file) {
        return Error{fmt::format("snapshot '{}' cannot be read: {}", path, std::strerror(errno))};
    }
    std::vector<uint8_t> raw;
    uint8_t chunk[65536];
    while (const size_t got = std::fread(chunk, 1, sizeof(chunk), file.get())) {
        raw.insert(raw.end(), chunk, chunk + got);
    }
    const auto refuse = [&](const std::string& why) {
        return Error{fmt::format("snapshot '{}': {}", path, why)};
    };
    constexpr size_t kHead = sizeof(kMagic) + 4 + 8 + 8;
    if (raw.size() < kHead || std::memcmp(raw.data(), kMagic, sizeof(kMagic)) != 0) {
        return refuse("is not a BulletSoil snapshot");
    }
    Reader head(std::span<const uint8_t>(raw).subspan(sizeof(kMagic)));
    const auto version = head.get<uint32_t>();
    const auto hash = head.get<uint64_t>();
    const auto count = head.get<uint64_t>();
    if (version != kVersion) {
        return refuse(fmt::format("has version {}, this build reads {}", version, kVersion));
    }
    const std::span<const uint8_t> body = std::span<const uint8_t>(raw).subspan(kHead);
    if (count > kBytesMax || ZSTD_getFrameContentSize(body.data(), body.size()) != count) {
        return refuse("is damaged or cut short");
    }
    std::vector<uint8_t> bytes(count);
    const size_t got = ZSTD_decompress(bytes.data(), bytes.size(), body.data(), body.size());
    if (ZSTD_isError(got) || got != count || hash_bytes(bytes) != hash) {
        return refuse("is damaged or cut short");
    }
    Reader r(bytes);
    for (int size : s.frame.size) {
        if (r.get<int32_t>() != size) {
            return refuse("is of a grid of another size");
        }
    }
    if (r.get<double>() != s.frame.voxel_m) {
        return refuse("is of a grid with another voxel_m");
    }
    if (r.get<int32_t>() != s.params.material_count) {
        return refuse("has another number of materials");
    }
    for (const MaterialDef& material : s.materials) {
        const auto name = r.get_bytes();
        if (std::string(name.begin(), name.end()) != material.name) {
            return refuse("has other materials");
        }
    }
    struct Entry {
        int64_t index = 0;
        bool awake = false;
        std::vector<uint8_t> packed;
        int64_t last_used = 0;
        std::vector<int32_t> speeds;
    };
    std::vector<Entry> entries;
    const auto step_index = r.get<int64_t>();
    const auto speed = r.get<int64_t>();
    const auto slope = r.get<int32_t>();
    const auto status = r.get<uint32_t>();
    const auto slip_turn = r.get<int32_t>();
    const auto pass_stamp = r.get<int32_t>();
    TileVoxels voxels;
    voxels.reset(s.height, s.kept_planes);
    for (int64_t index = r.get<int64_t>(); r.ok && index != -1; index = r.get<int64_t>()) {
        Entry entry;
        entry.index = index;
        entry.awake = r.get<int32_t>() != 0;
        const auto packed = r.get_bytes();
        entry.packed.assign(packed.begin(), packed.end());
        if (entry.awake) {
            entry.last_used = r.get<int64_t>();
            for (int i = 0; i < kTileColumns * 2 * kSpanCapacity; ++i) {
                entry.speeds.push_back(r.get<int32_t>());
            }
        }
        if (!r.ok || index < 0 || index >= static_cast<int64_t>(s.tiles.size()) ||
            !unpack_tile(entry.packed, voxels)) {
            return refuse("is damaged");
        }
        entries.push_back(std::move(entry));
    }
    std::unordered_map<BlockKey, int64_t> active;
    const auto active_count = r.get<uint64_t>();
    for (uint64_t i = 0; r.ok && i < active_count; ++i) {
        const auto block = r.get<int64_t>();
        active[block] = r.get<int64_t>();
        if (block < 0 || block >= static_cast<int64_t>(s.tiles.size()) * s.blocks_per_tile) {
            return refuse("is damaged");
        }
    }
    if (!r.ok || !r.at_end()) {
        return refuse("is damaged");
    }
    // All is sound: replace the state.
    for (size_t index = 0; index < s.tiles.size(); ++index) {
        if (s.tiles[index] && s.tiles[index]->slot >= 0) {
            s.put_to_sleep(static_cast<int>(index));
        }
        if (s.tiles[index]) {
            s.tiles[index]->packed.clear();
            s.tiles[index]->surface.clear();
            ++s.tiles[index]->revision;
        }
    }
    s.step_index = step_index;
    s.speed_q16 = speed;
    s.slope_q16 = slope;
    s.status = status;
    s.params.slip_turn = slip_turn & 1;
    s.params.pass_stamp = pass_stamp;
    s.device->fill_zero(Buffer::block_flags, 0,
                        static_cast<int64_t>(kFlagArrays) * s.slot_count * s.blocks_per_tile);
    s.active = std::move(active);
    s.bodies.clear();
    s.body_ids.clear();
    s.any_unchecked = false;
    std::vector<int32_t> columns(kTileColumns * kColumnWords, 0);
    for (Entry& entry : entries) {
        Tile& tile = s.tile_for(static_cast<int>(entry.index));
        unpack_tile(entry.packed, voxels);
        s.write_voxels(static_cast<int>(entry.index), voxels);
        tile.revision += 1;
        if (entry.awake) {
            const int slot = s.wake(static_cast<int>(entry.index));
            tile.last_used_step = entry.last_used;
            for (int i = 0; slot >= 0 && i < kTileColumns * 2 * kSpanCapacity; ++i) {
                columns[i / (2 * kSpanCapacity) * kColumnWords + kColumnSpeed +
                        i % (2 * kSpanCapacity)] = entry.speeds[i];
            }
            if (slot >= 0) {
                s.device->write(Buffer::spans,
                                static_cast<int64_t>(slot) * kTileColumns * kColumnWords, columns);
            }
        }
    }
    return Done{};
}

}  // namespace bsoil
