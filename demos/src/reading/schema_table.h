/// The machinery behind the scene schema: a key is declared once, with its type, unit, range,
/// default and meaning, and that one declaration reads the file, words the errors and writes the
/// documentation.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "scene/rotations.h"
#include "scene/scene.h"
#include "scene/scene_error.h"
#include "toml_plus_plus.h"

namespace bsoil::scene {

/// Inclusive range of a number, in the unit of the key's suffix.
struct Range {
    double min = 0, max = 0;
};

inline constexpr Range kFraction{0, 1};

struct TableSpec;

/// One key of a table.
struct KeySpec {
    std::string name;
    std::string type;      ///< for the documentation and for errors: "number", "[x, y, z]", ...
    std::string range;     ///< "0.001 .. 1", "box | sphere", or empty
    std::string fallback;  ///< the default as it would be written, empty where there is none
    std::string doc;
    bool required = false;
    std::vector<std::string>
        only;  ///< values of the table's selector for which the key exists; empty: always
    /// Stores the value in the item; the text says what is wrong with it, empty when nothing is.
    std::function<std::string(void* item, const toml::node& value)> read;
    std::shared_ptr<const TableSpec>
        table;  ///< set where the value is a table or an array of tables
    std::function<void*(void* item)> child;  ///< makes room in the parent for one child table
};

/// A table and its keys.
struct TableSpec {
    std::string path;              ///< "body.part"; empty for the file's top level
    std::string file = "a scene";  ///< what the file is, for errors at its top level
    std::string doc;
    bool array = false;
    std::string selector;  ///< the key ("kind", "shape") that decides which others exist, or empty
    std::vector<KeySpec> keys;
    std::function<SceneItem*(void* item)> item;  ///< the SceneItem of an item, for source positions
};

SourcePosition position_of(const toml::node& node);
std::string number_text(double value);
std::string range_text(Range range);
/// Of a node that is an integer or a float.
double number_of(const toml::node& value);
/// Checks type, finiteness and range of a number given in the key's unit.
std::string read_number(const toml::node& value, Range range, double& out);
std::string read_numbers(const toml::node& value, Range range, size_t min_count, size_t max_count,
                         std::vector<double>& out);
/// "a string", "an array": what a value is, for errors.
std::string kind_text(const toml::node& value);

inline Vec3 to_vec3(const std::vector<double>& v, double scale = 1) {
    return Vec3{v[0], v[1], v[2]} * scale;
}

/// Declares the keys of a table read into a T. A `place` is anything std::invoke turns from a T&
/// into the target.
template <typename T>
class TableOf {
  public:
    TableOf(std::string path, bool array, std::string doc) : spec_(std::make_shared<TableSpec>()) {
        spec_->path = std::move(path);
        spec_->array = array;
        spec_->doc = std::move(doc);
        if constexpr (std::is_base_of_v<SceneItem, T>) {
            spec_->item = [](void* item) -> SceneItem* { return static_cast<T*>(item); };
        } else {
            spec_->item = [](void*) -> SceneItem* { return nullptr; };
        }
    }

    /// A real number; `scale` turns the key's unit into the target's (degrees into radians).
    template <typename P>
    TableOf& number(const std::string& name, P place, Range range, const std::string& doc,
                    double scale = 1) {
        return add(name, "number", range_text(range), fallback(std::invoke(place, sample()), scale),
                   doc, [place, range, scale](T& item, const toml::node& value) {
                       double number = 0;
                       std::string error = read_number(value, range, number);
                       if (error.empty()) std::invoke(place, item) = number * scale;
                       return error;
                   });
    }
    template <typename P>
    TableOf& integer(const std::string& name, P place, Range range, const std::string& doc) {
        return add(name, "integer", range_text(range),
                   number_text(static_cast<double>(std::invoke(place, sample()))), doc,
                   [place, range](T& item, const toml::node& value) -> std::string {
                       if (!value.is_integer()) {
                           return "expected an integer, not " + kind_text(value);
                       }
                       double number = 0;
                       std::string error = read_number(value, range, number);
                       using Target = std::remove_reference_t<decltype(std::invoke(place, item))>;
                       if (error.empty()) std::invoke(place, item) = static_cast<Target>(number);
                       return error;
                   });
    }
    template <typename P>
    TableOf& flag(const std::string& name, P place, const std::string& doc) {
        return add(name, "true or false", "", std::invoke(place, sample()) ? "true" : "false", doc,
                   [place](T& item, const toml::node& value) -> std::string {
                       if (!value.is_boolean()) {
                           return "expected true or false, not " + kind_text(value);
                       }
                       std::invoke(place, item) = value.as_boolean()->get();
                       return {};
                   });
    }
    template <typename P>
    TableOf& text(const std::string& name, P place, const std::string& doc) {
        const std::string initial = std::invoke(place, sample());
        return add(name, "text", "", initial.empty() ? "" : '"' + initial + '"', doc,
                   [place](T& item, const toml::node& value) -> std::string {
                       if (!value.is_string()) return "expected a text, not " + kind_text(value);
                       std::invoke(place, item) = value.as_string()->get();
                       return {};
                   });
    }
    /// One of a few words. `apply(item, index)` stores the choice.
    TableOf& choice(const std::string& name, const std::vector<std::string>& words,
                    const std::string& initial, const std::string& doc,
                    std::function<void(T&, size_t)> apply) {
        std::string list;
        for (const std::string& word : words) list += (list.empty() ? "" : " \\| ") + word;
        return add(name, "one of", list, initial.empty() ? "" : '"' + initial + '"', doc,
                   [words, apply](T& item, const toml::node& value) -> std::string {
                       if (!value.is_string()) return "expected a text, not " + kind_text(value);
                       const std::string& given = value.as_string()->get();
                       std::string known;
                       for (size_t i = 0; i < words.size(); ++i) {
                           if (words[i] == given) {
                               apply(item, i);
                               return {};
                           }
                           known += (i ? ", " : "") + words[i];
                       }
                       return '"' + given + "\" is not one of " + known;
                   });
    }
    /// One of a few words, stored as text.
    template <typename P>
    TableOf& word(const std::string& name, P place, const std::vector<std::string>& words,
                  const std::string& doc) {
        return choice(
            name, words, std::invoke(place, sample()), doc,
            [place, words](T& item, size_t index) { std::invoke(place, item) = words[index]; });
    }
    template <typename P>
    TableOf& vector(const std::string& name, P place, Range range, const std::string& doc,
                    double scale = 1) {
        return add(name, "[x, y, z]", range_text(range),
                   fallback(std::invoke(place, sample()), scale), doc,
                   [place, range, scale](T& item, const toml::node& value) {
                       std::vector<double> v;
                       std::string error = read_numbers(value, range, 3, 3, v);
                       if (error.empty()) std::invoke(place, item) = to_vec3(v, scale);
                       return error;
                   });
    }
    /// The pair rotation_deg, axis_angle_deg: two ways to write one rotation.
    template <typename P>
    TableOf& rotation(P place, const std::string& of_what);
    template <typename P>
    TableOf& numbers(const std::string& name, P place, Range range, const std::string& doc) {
        return add(name, "[number, ...]", range_text(range), "", doc,
                   [place, range](T& item, const toml::node& value) {
                       return read_numbers(value, range, 0, 10000, std::invoke(place, item));
                   });
    }
    template <typename P>
    TableOf& texts(const std::string& name, P place, const std::string& doc) {
        return add(name, "[text, ...]", "", "", doc,
                   [place](T& item, const toml::node& value) -> std::string {
                       const toml::array* array = value.as_array();
                       if (!array) return "expected a list of texts, not " + kind_text(value);
                       for (const toml::node& entry : *array) {
                           if (!entry.is_string()) {
                               return "expected texts in the list, not " + kind_text(entry);
                           }
                           std::invoke(place, item).push_back(entry.as_string()->get());
                       }
                       return {};
                   });
    }
    template <typename P>
    TableOf& points(const std::string& name, P place, Range range, const std::string& doc) {
        return add(name, "[[x, y, z], ...]", range_text(range), "", doc,
                   [place, range](T& item, const toml::node& value) -> std::string {
                       const toml::array* array = value.as_array();
                       if (!array) return "expected a list of points, not " + kind_text(value);
                       for (const toml::node& entry : *array) {
                           std::vector<double> v;
                           const std::string error = read_numbers(entry, range, 3, 3, v);
                           if (!error.empty()) return error;
                           std::invoke(place, item).push_back(to_vec3(v));
                       }
                       return {};
                   });
    }
    /// A value of any form; `read(item, value)` says what is wrong with it.
    TableOf& value(const std::string& name, const std::string& type, const std::string& doc,
                   std::function<std::string(T&, const toml::node&)> read) {
        return add(name, type, "", "", doc, std::move(read));
    }
    /// A child table, or an array of them; `make(item)` gives the place of one child.
    template <typename C>
    TableOf& child(const std::string& name, const TableOf<C>& table, std::function<C*(T&)> make) {
        KeySpec key;
        key.name = name;
        key.type = table.spec()->array ? "tables" : "table";
        key.table = table.spec();
        key.child = [make](void* item) -> void* { return make(*static_cast<T*>(item)); };
        spec_->keys.push_back(std::move(key));
        return *this;
    }

    /// The key declared last must be given (where its selector allows it).
    TableOf& required() {
        spec_->keys.back().required = true;
        return *this;
    }
    /// The key declared last exists only for these values of the selector.
    TableOf& only(std::vector<std::string> values) {
        spec_->keys.back().only = std::move(values);
        return *this;
    }
    /// What the file is, where this table is its top level.
    TableOf& file(const std::string& name) {
        spec_->file = name;
        return *this;
    }
    /// `key` decides which other keys exist.
    TableOf& selected_by(const std::string& key) {
        spec_->selector = key;
        return *this;
    }
    std::shared_ptr<const TableSpec> spec() const { return spec_; }

  private:
    /// An item as it is before anything is read: the source of the documented defaults.
    static T& sample() {
        static T item;
        return item;
    }
    static std::string fallback(double value, double scale) { return number_text(value / scale); }
    static std::string fallback(const std::optional<double>&, double) { return {}; }
    static std::string fallback(Vec3 v, double scale) {
        return '[' + number_text(v.x / scale) + ", " + number_text(v.y / scale) + ", " +
               number_text(v.z / scale) + ']';
    }
    static std::string fallback(const std::optional<Vec3>&, double) { return {}; }

    TableOf& add(const std::string& name, const std::string& type, const std::string& range,
                 const std::string& initial, const std::string& doc,
                 std::function<std::string(T&, const toml::node&)> read) {
        KeySpec key;
        key.name = name;
        key.type = type;
        key.range = range;
        key.fallback = initial;
        key.doc = doc;
        key.read = [read](void* item, const toml::node& value) {
            return read(*static_cast<T*>(item), value);
        };
        spec_->keys.push_back(std::move(key));
        return *this;
    }

    std::shared_ptr<TableSpec> spec_;
};

template <typename T>
template <typename P>
TableOf<T>& TableOf<T>::rotation(P place, const std::string& of_what) {
    constexpr Range kTurns{-3600, 3600};
    add("rotation_deg", "[x, y, z]", range_text(kTurns), "",
        of_what + ", as turns about the fixed axes x, then y, then z",
        [place, kTurns](T& item, const toml::node& value) {
            std::vector<double> v;
            std::string error = read_numbers(value, kTurns, 3, 3, v);
            if (error.empty()) std::invoke(place, item) = fixed_axes_rotation(to_vec3(v, kDegree));
            return error;
        });
    return add("axis_angle_deg", "[x, y, z, angle]", range_text(kTurns), "",
               of_what + ", as one turn about an axis; instead of `rotation_deg`",
               [place, kTurns](T& item, const toml::node& value) -> std::string {
                   std::vector<double> v;
                   std::string error = read_numbers(value, kTurns, 4, 4, v);
                   if (!error.empty()) return error;
                   if (length(to_vec3(v)) < 1e-9) return "the axis has no length";
                   std::invoke(place, item) = axis_rotation(to_vec3(v), v[3] * kDegree);
                   return {};
               });
}

/// What an item of a table says, as text, with the defaults of what it leaves out.
std::map<std::string, std::string> values_in(const SceneItem& item, const TableSpec& spec);

/// The whole schema: the file's top level.
const TableSpec& scene_schema();
/// Tables that other kinds of files share with scenes.
TableOf<SoilItem> soil_table();
TableOf<MaterialItem> material_table();
TableOf<RaycastVehicleItem> raycast_vehicle_table();
/// Reads a parsed table into an item as the schema says; errors are added to the list.
void read_table(const toml::table& table, const TableSpec& spec, void* item,
                std::vector<SchemaError>& errors);
/// The keys of a table and of its children as Markdown.
std::string table_markdown(const TableSpec& spec);

}  // namespace bsoil::scene
