#include "bsoil/bullet/world_snapshot.h"

#include "snapshot_access.h"
#include "world_objects.h"
#include "world_state.h"

namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {
namespace {

constexpr char kWorld[] = "world";
constexpr char kObjects[] = "objects";
constexpr char kHostPrefix[] = "host";

Error refusal(const std::string& path, const std::string& why) {
    return Error{"snapshot '" + path + "': " + why};
}

}  // namespace

Status save_world(btDiscreteDynamicsWorld& world, std::span<SoilAction* const> soils,
                  const std::string& path, std::span<const SnapshotSection> host) {
    if (const Status known = check_world(world, soils); !known) return refusal(path, known.error());
    for (SoilAction* soil : soils) SnapshotAccess::close_substep(*soil);
    StateStream objects;
    std::vector<ObjectKind> kinds = object_kinds(world);
    objects.list(kinds, 1, [&](ObjectKind& kind) { kind.list(objects); });
    auto state = world_state(world);
    if (!state) return refusal(path, state.error());
    std::vector<SnapshotSection> sections{{kObjects, objects.bytes()}, {kWorld, std::move(*state)}};
    for (size_t i = 0; i < soils.size(); ++i) {
        auto parts = SnapshotAccess::sections(*soils[i], i);
        if (!parts) return refusal(path, parts.error());
        for (SnapshotSection& part : *parts) sections.push_back(std::move(part));
    }
    for (const SnapshotSection& section : host) {
        if (section.name.rfind(kHostPrefix, 0) != 0) {
            return refusal(path, "section '" + section.name + "' of the host must begin with host");
        }
        sections.push_back(section);
    }
    return write_snapshot_file(path, sections);
}

Status load_world(btDiscreteDynamicsWorld& world, std::span<SoilAction* const> soils,
                  const std::string& path) {
    if (const Status known = check_world(world, soils); !known) return refusal(path, known.error());
    const auto sections = read_snapshot_file(path);
    if (!sections) return Error{sections.error()};
    const std::vector<uint8_t>* objects = find_section(*sections, kObjects);
    const std::vector<uint8_t>* state = find_section(*sections, kWorld);
    if (!objects || !state) {
        return refusal(path, "holds no world; load a file that save_world() wrote");
    }
    StateStream stream(*objects);
    std::vector<ObjectKind> kinds;
    stream.list(kinds, 32, [&](ObjectKind& kind) { kind.list(stream); });
    if (!stream.at_end()) return refusal(path, std::string("is damaged") + kTakeAnotherCopy);
    if (const Status same = check_same_objects(kinds, world); !same) {
        return refusal(path, same.error());
    }
    if (find_section(*sections, "soil." + std::to_string(std::max<size_t>(soils.size(), 1))) ||
        (soils.empty() && find_section(*sections, "soil"))) {
        return refusal(path, "is of a world with more soils; give all of them");
    }
    for (SoilAction* soil : soils) SnapshotAccess::close_substep(*soil);
    std::vector<std::function<void()>> puts;
    for (size_t i = 0; i < soils.size(); ++i) {
        auto put = SnapshotAccess::prepare(*soils[i], *sections, i);
        if (!put) return refusal(path, put.error());
        puts.push_back(std::move(*put));
    }
    if (const Status set = set_world_state(world, *state); !set) return refusal(path, set.error());
    for (const auto& put : puts) put();  // after the world: they note its objects' new proxies
    return Done{};
}

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
