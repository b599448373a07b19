#include "scene_origin.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <string>

#include "bsoil/snapshot_file.h"
#include "reading/scene_load.h"
#include "scene/rotations.h"
#include "soil_settings.h"

namespace bsoil::scene {
namespace {

/// One value of a scene.
struct Statement {
    std::string table;  ///< "[soil]", "[[source]] 2"
    std::string key;
    std::string value;  ///< what is compared
    std::string shown;  ///< as the scene writes it
    std::string name;   ///< of what the table is of, where it has one; not in snapshots
};

/// A hash of numbers, FNV-1a over their bytes.
class ContentHash {
  public:
    template <typename Number>
    void add(const Number& number) {
        uint8_t bytes[sizeof(Number)];
        std::memcpy(bytes, &number, sizeof(Number));
        for (const uint8_t byte : bytes) hash_ = (hash_ ^ byte) * 1099511628211ull;
    }
    std::string text() const { return fmt::format("contents {:016x}", hash_); }

  private:
    uint64_t hash_ = 14695981039346656037ull;
};

std::string contents_of(const HeightMapFill& map) {
    ContentHash hash;
    hash.add(map.width);
    for (const float height_m : map.heights_m) hash.add(height_m);
    return hash.text();
}

std::string contents_of(const TriangleMesh& mesh) {
    ContentHash hash;
    for (const Vec3& v : mesh.vertices) {
        for (const double x : {v.x, v.y, v.z}) hash.add(x);
    }
    for (const auto& triangle : mesh.triangles) {
        for (const int corner : triangle) hash.add(corner);
    }
    return hash.text();
}

class Statements {
  public:
    Statements(const Scene& scene, const SoilDef* soil) : scene_(scene) {
        all_.push_back({"[world]", "up", scene.world.up, '"' + scene.world.up + '"', {}});
        if (soil) add_soil(*soil);
        add_tables("fill", scene.fills, [](const FillItem& fill) {
            return fill.kind == "height_map" ? contents_of(fill.height_map) : std::string();
        });
        add_tables("terrain", scene.terrains, [](const TerrainItem& terrain) {
            return terrain.kind == "mesh" ? contents_of(terrain.mesh) : std::string();
        });
        const auto no_file = [](const SceneItem&) { return std::string(); };
        add_tables("source", scene.sources, no_file);
        add_tables("sink", scene.sinks, no_file);
        for (size_t i = 0; i < scene.bodies.size(); ++i) add_body(i, scene.bodies[i]);
    }
    std::vector<Statement> take() { return std::move(all_); }

  private:
    void add_soil(const SoilDef& soil) {
        for (const NamedNumber& number : soil_numbers(soil)) {
            std::string table = "[soil]", key = number.name;
            double value = number.value;
            if (std::isdigit(static_cast<unsigned char>(key.front()))) {
                const size_t dot = key.find('.');
                table = "material \"" + soil.materials[std::stoul(key)].name + '"';
                key = key.substr(dot + 1);
            }
            if (key.ends_with("_rad")) {
                key.replace(key.size() - 4, 4, "_deg");
                value /= kDegree;
            }
            std::string shown = fmt::format("{:.9g}", value);
            if (table == "[soil]" && scene_.soil) {
                const auto said = scene_.soil->said.find(key.substr(0, key.find('.')));
                if (said != scene_.soil->said.end()) shown = said->second;
            }
            all_.push_back({table, key, fmt::format("{}", number.value), shown, {}});
        }
    }

    /// What the file says of each table. `contents(item)` stands for the name of a file, if any.
    template <typename Item, typename Contents>
    void add_tables(const char* name, const std::vector<Item>& items, const Contents& contents) {
        for (size_t i = 0; i < items.size(); ++i) {
            const std::string table = fmt::format("[[{}]] {}", name, i + 1);
            const std::string file = contents(items[i]);
            for (const auto& [key, value] : values_of(name, items[i])) {
                const std::string& text = key == "file" ? file : value;
                all_.push_back({table, key, text, text, {}});
            }
        }
    }

    // By its number: a body may get another name.
    void add_body(size_t index, const BodyItem& body) {
        const std::string table = fmt::format("[[body]] {}", index + 1);
        const auto add = [&](const char* key, std::initializer_list<double> numbers) {
            std::string text;
            for (const double number : numbers) {
                const double rounded = std::abs(number) < 1e-12 ? 0 : number;
                text += fmt::format("{}{:.6g}", text.empty() ? "[" : ", ", rounded);
            }
            text += ']';
            all_.push_back({table, key, text, text, body.name});
        };
        const Vec3 at = body.pose.position, v = body.velocity_m_s, w = body.angular_velocity_rad_s;
        const Quat turn = body.pose.rotation;
        add("position_m", {at.x, at.y, at.z});
        add("rotation", {turn.x, turn.y, turn.z, turn.w});
        add("velocity_m_s", {v.x, v.y, v.z});
        add("angular_velocity_deg_s", {w.x / kDegree, w.y / kDegree, w.z / kDegree});
    }

    const Scene& scene_;
    std::vector<Statement> all_;
};

void list(StateStream& stream, std::vector<Statement>& all) {
    stream.list(all, 32, [&](Statement& s) { stream(s.table, s.key, s.value, s.shown); });
}

bool has_table(const std::vector<Statement>& all, const std::string& table) {
    return std::ranges::find(all, table, &Statement::table) != all.end();
}

/// The first table of these that the others lack; empty: none.
std::string table_beyond(const std::vector<Statement>& all, const std::vector<Statement>& others) {
    for (const Statement& s : all) {
        if (!has_table(others, s.table)) return s.table;
    }
    return {};
}

}  // namespace

std::vector<uint8_t> scene_origin(const Scene& scene, const SoilDef* soil) {
    std::vector<Statement> all = Statements(scene, soil).take();
    StateStream stream;
    list(stream, all);
    return stream.bytes();
}

// A key that only one of the two knows is of another version, or of another kind of table, whose
// `kind` or `shape` then differs as well.
Status check_origin(std::span<const uint8_t> saved, const Scene& scene, const SoilDef* soil) {
    std::vector<Statement> before;
    StateStream stream(saved);
    list(stream, before);
    if (!stream.at_end()) return Error{std::string("is damaged") + kTakeAnotherCopy};
    const std::vector<Statement> here = Statements(scene, soil).take();
    for (const Statement& now : here) {
        const auto then = std::ranges::find_if(
            before, [&](const Statement& s) { return s.table == now.table && s.key == now.key; });
        if (then == before.end() || then->value == now.value) continue;
        const std::string where = now.table + (now.name.empty() ? "" : " (" + now.name + ')');
        return Error{
            fmt::format("is of a scene with `{0}` {1} in {2}, this one has `{0}` {3}; set it back, "
                        "or run this scene anew",
                        now.key, then->shown, where, now.shown)};
    }
    if (const std::string gone = table_beyond(before, here); !gone.empty()) {
        return Error{fmt::format(
            "is of a scene with {}, which this one lacks; put it back, or run this scene anew",
            gone)};
    }
    if (const std::string added = table_beyond(here, before); !added.empty()) {
        return Error{fmt::format(
            "is of a scene without {}, which this one has; leave it out, or run this scene anew",
            added)};
    }
    return Done{};
}

}  // namespace bsoil::scene
