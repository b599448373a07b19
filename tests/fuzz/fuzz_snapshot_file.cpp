#include <cstring>

#include "bsoil/snapshot_file.h"
#include "targets.h"

namespace bsoil::fuzz {
namespace {

// As plugin/src/soil/snapshot_file.cpp lays a file out.
constexpr size_t kHeadBytes = 16, kEntryBytes = 40, kNameBytes = 16, kSectionsMost = 64;

uint64_t hash_of(Bytes bytes) {
    uint64_t h = 0xcbf29ce484222325ull;
    for (const uint8_t byte : bytes) h = (h ^ byte) * 0x100000001b3ull;
    return h;
}

template <typename T>
T number_at(Bytes bytes, size_t at) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// Puts right every hash that the file has a place for, so that changes get past them.
void seal(std::vector<uint8_t>& file) {
    if (file.size() < kHeadBytes) return;
    const size_t count = number_at<uint32_t>(file, 12);
    const size_t head = kHeadBytes + count * kEntryBytes;
    if (count > kSectionsMost || file.size() < head + 8) return;
    size_t at = head + 8;
    for (size_t i = 0; i < count; ++i) {
        const size_t entry = kHeadBytes + i * kEntryBytes;
        const auto size = number_at<uint64_t>(file, entry + kNameBytes + 8);
        if (size > file.size() - at) break;
        const uint64_t hash = hash_of(Bytes(file).subspan(at, size));
        std::memcpy(&file[entry + kNameBytes + 16], &hash, sizeof hash);
        at += size;
    }
    const uint64_t hash = hash_of(Bytes(file).first(head));
    std::memcpy(&file[head], &hash, sizeof hash);
}

const std::vector<uint8_t>& good_snapshot_file() {
    static const std::vector<uint8_t> kFile = [] {
        std::vector<SnapshotSection> sections{{"soil", {}}, {"world", {1, 2, 3}}, {"host", {}}};
        for (int i = 0; i < 3000; ++i) sections[0].bytes.push_back(static_cast<uint8_t>(i * i));
        const std::string path = scratch_path("good.snapshot");
        require(write_snapshot_file(path, sections).ok(), "the good file cannot be written");
        const auto read = read_snapshot_file(path);
        require(read && read->size() == sections.size() && (*read)[0].bytes == sections[0].bytes,
                "the good file is not read as it was written");
        return read_scratch(path);
    }();
    return kFile;
}

}  // namespace

void fuzz_snapshot_file(Bytes bytes) {
    std::vector<uint8_t> file = good_snapshot_file();
    Choices choices(bytes);
    edit(file, choices);
    seal(file);
    const auto sections = read_snapshot_file(scratch_file("changed.snapshot", file));
    if (!sections) return;
    size_t content = 0;
    for (const SnapshotSection& section : *sections) content += section.bytes.size();
    require(content <= (size_t{64} << 20) + 4096 * file.size(), "a small file takes much memory");
}

}  // namespace bsoil::fuzz
