// The file of a snapshot.
//
//   8 bytes  "BSOILSNP"
//   u32      version
//   u32      number of sections, 1 .. 64
//   per section
//     16 bytes  name, filled up with zeros
//     u64       bytes of its content
//     u64       bytes of it in this file: one zstd frame
//     u64       hash of the frame
//   u64      hash of all bytes so far
//   ...      the frames, in the order of the list, and nothing after them
#include "bsoil/snapshot_file.h"

#include <fmt/format.h>
#include <zstd.h>

#include <cerrno>
#include <cstdio>
#include <memory>

namespace bsoil {
namespace {

constexpr char kMagic[8] = {'B', 'S', 'O', 'I', 'L', 'S', 'N', 'P'};
// 27: what bodies press on their carriers with.
constexpr uint32_t kVersion = 27;
constexpr uint32_t kSectionsMost = 64;
constexpr size_t kNameBytes = 16;
constexpr size_t kHeadBytes = sizeof(kMagic) + 4 + 4;
constexpr size_t kEntryBytes = kNameBytes + 3 * 8;
// What all sections together may grow to: this much, and more only in proportion to their bytes in
// the file, so that a small file cannot ask for all memory there is. States shrink to a hundredth
// at best.
constexpr uint64_t kContentFree = uint64_t{64} << 20;
constexpr uint64_t kContentPerByte = 4096;

uint64_t hash_of(std::span<const uint8_t> bytes) {
    uint64_t h = 0xcbf29ce484222325ull;  // FNV-1a
    for (const uint8_t byte : bytes) h = (h ^ byte) * 0x100000001b3ull;
    return h;
}

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// What the head says of one section.
struct Entry {
    char name[kNameBytes] = {};
    uint64_t content_bytes = 0, frame_bytes = 0, hash = 0;

    void list(StateStream& stream) {
        for (char& c : name) stream(c);
        stream(content_bytes, frame_bytes, hash);
    }
};

Error refusal(const std::string& path, const std::string& why) {
    return Error{fmt::format("snapshot '{}': {}", path, why)};
}

/// What is written has to be readable.
Status check_sections(const std::string& path, std::span<const SnapshotSection> sections) {
    if (sections.empty() || sections.size() > kSectionsMost) {
        return refusal(path, fmt::format("has {} sections, must have 1 to {}", sections.size(),
                                         kSectionsMost));
    }
    for (const SnapshotSection& section : sections) {
        const std::string& name = section.name;
        if (name.empty() || name.size() > kNameBytes || name.find('\0') != std::string::npos) {
            return refusal(path, fmt::format("section name '{}' must have 1 to {} characters, none "
                                             "of them zero",
                                             name, kNameBytes));
        }
        if (find_section(sections, name) != &section.bytes) {
            return refusal(path, fmt::format("has two sections named '{}'; rename one", name));
        }
    }
    return Done{};
}

}  // namespace

const std::vector<uint8_t>* find_section(std::span<const SnapshotSection> sections,
                                         std::string_view name) {
    for (const SnapshotSection& section : sections) {
        if (section.name == name) return &section.bytes;
    }
    return nullptr;
}

Status write_snapshot_file(const std::string& path, std::span<const SnapshotSection> sections) {
    if (Status sound = check_sections(path, sections); !sound) return sound;
    std::vector<std::vector<uint8_t>> frames;
    StateStream head;
    for (char c : kMagic) head(c);
    uint32_t version = kVersion, count = static_cast<uint32_t>(sections.size());
    head(version, count);
    uint64_t content_bytes = 0, frame_bytes = 0;
    for (const SnapshotSection& section : sections) {
        std::vector<uint8_t> frame(ZSTD_compressBound(section.bytes.size()));
        const size_t size = ZSTD_compress(frame.data(), frame.size(), section.bytes.data(),
                                          section.bytes.size(), 3);
        if (ZSTD_isError(size)) return refusal(path, ZSTD_getErrorName(size));
        frame.resize(size);
        Entry entry;
        std::memcpy(entry.name, section.name.data(), section.name.size());
        entry.content_bytes = section.bytes.size();
        entry.frame_bytes = size;
        entry.hash = hash_of(frame);
        content_bytes += entry.content_bytes;
        frame_bytes += entry.frame_bytes;
        entry.list(head);
        frames.push_back(std::move(frame));
    }
    if (content_bytes > kContentFree + kContentPerByte * frame_bytes) {
        return refusal(path, fmt::format("its {} bytes shrink by more than {} times: they could "
                                         "not be told from damaged ones; save less beside the soil",
                                         content_bytes, kContentPerByte));
    }
    uint64_t hash = hash_of(head.bytes());
    head(hash);

    // Written beside and renamed: a crash does not leave half a snapshot under the name.
    const std::string part = path + ".part";
    bool good = false;
    if (File file{std::fopen(part.c_str(), "wb")}) {
        const auto put = [&](const std::vector<uint8_t>& bytes) {
            return std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
        };
        good = put(head.bytes());
        for (const std::vector<uint8_t>& frame : frames) good = good && put(frame);
        // What a full disk or a server refuses may be known as late as at closing.
        good = std::fclose(file.release()) == 0 && good;
    }
    if (!good || std::rename(part.c_str(), path.c_str()) != 0) {
        const int why = errno;
        std::remove(part.c_str());
        return Error{
            fmt::format("snapshot '{}' cannot be written: {}; check its folder and the disk", path,
                        std::strerror(why))};
    }
    return Done{};
}

Result<std::vector<SnapshotSection>> read_snapshot_file(const std::string& path) {
    const File file{std::fopen(path.c_str(), "rb")};
    if (!file) {
        return Error{fmt::format("snapshot '{}' cannot be read: {}; check its name", path,
                                 std::strerror(errno))};
    }
    std::vector<uint8_t> raw;
    uint8_t chunk[65536];
    const auto is_snapshot = [&raw] {
        return raw.size() >= kHeadBytes && std::memcmp(raw.data(), kMagic, sizeof(kMagic)) == 0;
    };
    while (const size_t got = std::fread(chunk, 1, sizeof(chunk), file.get())) {
        raw.insert(raw.end(), chunk, chunk + got);
        if (!is_snapshot()) break;  // it may be large
    }
    if (std::ferror(file.get()) != 0) {
        return Error{fmt::format("snapshot '{}' cannot be read: {}; check its name", path,
                                 std::strerror(errno))};
    }

    const Error damaged = refusal(path, std::string("is damaged or cut short") + kTakeAnotherCopy);
    if (!is_snapshot()) {
        return refusal(path, "is not a BulletSoil snapshot; take a file that save() wrote");
    }
    const std::span<const uint8_t> all(raw);
    StateStream head(all.subspan(sizeof(kMagic)));
    uint32_t version = 0, count = 0;
    head(version, count);
    if (version != kVersion) {
        return refusal(path, fmt::format("has version {}, this build reads {}; load it with the "
                                         "build that wrote it",
                                         version, kVersion));
    }
    if (count == 0 || count > kSectionsMost) return damaged;
    std::vector<Entry> entries(count);
    for (Entry& entry : entries) entry.list(head);
    uint64_t hash = 0;
    head(hash);
    const size_t head_bytes = kHeadBytes + count * kEntryBytes;
    if (!head.good() || hash != hash_of(all.first(head_bytes))) return damaged;

    std::vector<SnapshotSection> sections;
    size_t at = head_bytes + sizeof(hash);
    uint64_t content_left = kContentFree + kContentPerByte * raw.size();
    for (const Entry& entry : entries) {
        if (entry.frame_bytes > raw.size() - at || entry.content_bytes > content_left) {
            return damaged;
        }
        content_left -= entry.content_bytes;
        const std::span<const uint8_t> frame = all.subspan(at, entry.frame_bytes);
        at += entry.frame_bytes;
        // Of the frame, not of what is in it: zstd does not read every bit of its own head.
        if (hash_of(frame) != entry.hash ||
            ZSTD_getFrameContentSize(frame.data(), frame.size()) != entry.content_bytes) {
            return damaged;
        }
        SnapshotSection section;
        section.name.assign(entry.name, strnlen(entry.name, kNameBytes));
        section.bytes.resize(entry.content_bytes);
        const size_t got =
            ZSTD_decompress(section.bytes.data(), section.bytes.size(), frame.data(), frame.size());
        if (ZSTD_isError(got) || got != entry.content_bytes ||
            find_section(sections, section.name)) {
            return damaged;
        }
        sections.push_back(std::move(section));
    }
    if (at != raw.size()) return damaged;
    return sections;
}

}  // namespace bsoil
