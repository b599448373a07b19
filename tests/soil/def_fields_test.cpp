// The tables of fields: what the headers say, what validate() refuses and what snapshots hold.
#include "soil/def_fields.h"

#include <fmt/format.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "bsoil/snapshot_file.h"
#include "soil_fixture.h"

namespace bsoil::def_fields_test {
namespace {

struct Row {
    std::string name;
    double least = 0, most = 0;
    bool is_enumeration = false;
    std::string what, more;
};

std::vector<Row> material_rows() {
    return {
#define BSOIL_ROW(name, least, most, use, what, more) {#name, least, most, false, what, more},
        BSOIL_MATERIAL_FIELDS(BSOIL_ROW)
#undef BSOIL_ROW
    };
}
std::vector<Row> soil_rows() {
    return {
#define BSOIL_ROW(name, least, most, use, what, more) \
    {#name, least, most, std::is_enum_v<decltype(SoilDef::name)>, what, more},
        BSOIL_SOIL_FIELDS(BSOIL_ROW)
#undef BSOIL_ROW
    };
}

std::vector<Row> contact_law_rows() {
    return {
#define BSOIL_ROW(name, least, most, what, more) \
    {#name, least, most, std::is_same_v<decltype(ContactLawDef::name), bool>, what, more},
        BSOIL_CONTACT_LAW_FIELDS(BSOIL_ROW)
#undef BSOIL_ROW
    };
}

std::string lowered(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// A struct of a header, and the comment of each of its members, as one line of small letters.
class CommentedStruct {
  public:
    CommentedStruct(const std::string& header, const std::string& name) {
        std::ifstream file(std::string(BSOIL_SOURCE_DIR) + "/" + header);
        std::stringstream text;
        text << file.rdbuf();
        const std::string all = text.str(), head = "struct " + name + " {";
        const size_t from = all.find(head);
        EXPECT_NE(from, std::string::npos) << header << " has no " << name;
        if (from == std::string::npos) return;
        std::istringstream lines(all.substr(from + head.size(), all.find("\n}", from) - from));
        for (std::string line; std::getline(lines, line);) lines_.push_back(line);
    }

    /// Before the member or behind it; empty where there is no such member.
    std::string comment_of(const std::string& member) const {
        const std::regex declared("^    [A-Za-z_0-9:]+ " + member + "(\\[[0-9]\\])?[ ;{=].*");
        for (size_t i = 0; i < lines_.size(); ++i) {
            if (!std::regex_match(lines_[i], declared)) continue;
            std::string text = words(lines_[i]);
            for (size_t j = i; j-- > 0 && is_comment(lines_[j]);) {
                text = words(lines_[j]) + " " + text;
            }
            return lowered(text);
        }
        return {};
    }

  private:
    static bool is_comment(const std::string& line) {
        return std::regex_match(line, std::regex("^    ( ?\\*|/\\*\\*|///).*"));
    }
    /// Of a comment line, or of the comment at a line's end.
    static std::string words(const std::string& line) {
        std::string text = line;
        if (!is_comment(line)) {
            const size_t at = std::min(line.find("///<"), line.find("/**<"));
            text = at == std::string::npos ? "" : line.substr(at);
        }
        text = std::regex_replace(text, std::regex("///<?|/\\*\\*<?|\\*/|^     ?\\*"), " ");
        text = std::regex_replace(text, std::regex(" +"), " ");
        return std::regex_replace(text, std::regex("^ | $"), "");
    }

    std::vector<std::string> lines_;
};

/// "1/20" or "200e3".
double number_of(const std::string& text) {
    const size_t stroke = text.find('/');
    if (stroke == std::string::npos) return std::stod(text);
    return std::stod(text.substr(0, stroke)) / std::stod(text.substr(stroke + 1));
}

void expect_comments(const CommentedStruct& members, const std::vector<Row>& rows) {
    for (const Row& row : rows) {
        const std::string comment = members.comment_of(row.name);
        EXPECT_NE(comment.find(lowered(row.what)), std::string::npos)
            << row.name << ": '" << comment << "' has no '" << row.what << "'";
        EXPECT_NE(comment.find(lowered(row.more)), std::string::npos)
            << row.name << ": '" << comment << "' has no '" << row.more << "'";
        if (row.is_enumeration || row.least == row.most) continue;
        std::smatch range;
        if (!std::regex_search(comment, range,
                               std::regex("([-0-9.e/]*[0-9])\\.\\.([-0-9.e/]*[0-9])"))) {
            ADD_FAILURE() << row.name << ": '" << comment << "' has no range";
            continue;
        }
        EXPECT_EQ(number_of(range[1]), row.least) << row.name << ": " << comment;
        EXPECT_EQ(number_of(range[2]), row.most) << row.name << ": " << comment;
    }
}

TEST(DefFields, headers_say_what_the_tables_say) {
    expect_comments({"plugin/include/bsoil/material.h", "MaterialDef"}, material_rows());
    expect_comments({"plugin/include/bsoil/soil_def.h", "SoilDef"}, soil_rows());
    expect_comments({"bridge/include/bsoil/c/bulletsoil.h", "bulletsoil_material"},
                    material_rows());
}

TEST(DefFields, the_contact_laws_header_says_what_its_table_says) {
    std::vector<Row> rows = contact_law_rows();
    expect_comments({"bridge/include/bsoil/c/bulletsoil.h", "bulletsoil_contact_constants"}, rows);
    // ContactLawDef says more of each, in other words.
    for (Row& row : rows) row.more.clear();
    expect_comments({"plugin/include/bsoil/contact/contact_law_def.h", "ContactLawDef"}, rows);
}

TEST(DefFields, the_c_interface_says_what_the_tables_say) {
    std::vector<Row> rows = soil_rows();
    rows.front().more.clear();  // how the box is rounded: SoilDef tells
    expect_comments({"bridge/include/bsoil/c/bulletsoil.h", "bulletsoil_soil_def"}, rows);
}

/// The error of a definition whose one field has this value.
template <typename Def>
std::string error_with(void (*set)(Def&, double), double value) {
    Def def;
    set(def, value);
    const Status status = def.validate();
    return status ? "" : status.error();
}

template <typename T>
void set_number(T& member, double value) {
    member = static_cast<T>(value);
}
[[maybe_unused]] void set_number(Vec3& member, double value) { member.y = value; }

TEST(DefFields, every_field_is_refused_out_of_its_range_by_name) {
    int count = 0;
    const auto expect_range = [&](const auto set, const Row& row) {
        if (row.least == row.most) return;
        const bool is_whole = row.is_enumeration || std::floor(row.least) == row.least;
        const double step = is_whole ? 1 : (row.most - row.least) / 1e3;
        for (const double value : {row.least - step, row.most + step}) {
            const std::string error = error_with(+set, value);
            EXPECT_NE(error.find(row.name), std::string::npos) << value << ": " << error;
            EXPECT_NE(error.find(fmt::format(", must be {} to {}", row.least, row.most)),
                      std::string::npos)
                << row.name << " " << value << ": " << error;
        }
        for (const double value : {row.least, row.most}) {
            EXPECT_EQ(error_with(+set, value).find(", must be " + std::to_string(row.least)),
                      std::string::npos)
                << row.name;
        }
        ++count;
    };
    size_t i = 0;
    const std::vector<Row> materials = material_rows(), soils = soil_rows();
#define BSOIL_EXPECT(name, ...)                                                       \
    expect_range([](MaterialDef& def, double value) { set_number(def.name, value); }, \
                 materials[i++]);
    BSOIL_MATERIAL_FIELDS(BSOIL_EXPECT)
#undef BSOIL_EXPECT
    i = 0;
#define BSOIL_EXPECT(name, ...) \
    expect_range([](SoilDef& def, double value) { set_number(def.name, value); }, soils[i++]);
    BSOIL_SOIL_FIELDS(BSOIL_EXPECT)
#undef BSOIL_EXPECT
    EXPECT_EQ(count, 19 + 25);
}

/// The head of a soil's state: what it is of. The rest of the bytes follows.
struct StateHead {
    std::vector<std::string> materials;
    std::vector<std::pair<std::string, double>> values;

    void list(StateStream& stream) {
        stream.list(materials, 8, [&](std::string& name) { stream(name); });
        stream.list(values, 16, [&](auto& v) { stream(v.first, v.second); });
    }
    /// Where the value of this name is.
    auto find(const std::string& name) {
        return std::find_if(values.begin(), values.end(),
                            [&](const auto& v) { return v.first == name; });
    }
};

/// The state with its head changed.
std::vector<uint8_t> with_head(const std::vector<uint8_t>& state,
                               const std::function<void(StateHead&)>& change) {
    StateHead head;
    StateStream in(state), as_it_was, changed;
    head.list(in);
    head.list(as_it_was);
    change(head);
    head.list(changed);
    std::vector<uint8_t> out = changed.bytes();
    out.insert(out.end(), state.begin() + static_cast<std::ptrdiff_t>(as_it_was.bytes().size()),
               state.end());
    return out;
}

std::string refused(Soil& soil, const std::vector<uint8_t>& state) {
    const auto put = soil.prepare(state);
    return put ? "" : put.error();
}

TEST(DefFields, a_snapshot_of_before_a_field_is_of_its_default) {
    for (const double overflow_passes : {4.0, 6.0}) {
        SoilDef def = grid_def(16, 16, 8);
        def.overflow_passes = static_cast<int>(overflow_passes);
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {16, 16, 4})));
        const auto state = soil->state();
        EXPECT_EQ(refused(*soil, state), "");
        const auto before = with_head(
            state, [](StateHead& head) { head.values.erase(head.find("overflow_passes")); });
        const std::string error = refused(*soil, before);
        if (overflow_passes == 4) {
            EXPECT_EQ(error, "");
        } else {
            EXPECT_NE(error.find("is of a soil with overflow_passes 4, this one has "
                                 "overflow_passes 6"),
                      std::string::npos)
                << error;
        }
    }
}

TEST(DefFields, a_snapshot_with_a_field_of_tomorrow_is_refused_by_name) {
    const auto soil = make_soil(grid_def(16, 16, 8));
    const auto tomorrow = with_head(
        soil->state(), [](StateHead& head) { head.values.emplace_back("moisture", 0.25); });
    const std::string error = refused(*soil, tomorrow);
    EXPECT_NE(error.find("moisture 0.25, which this version does not know"), std::string::npos)
        << error;
    const auto twice = with_head(
        soil->state(), [](StateHead& head) { head.values.push_back(*head.find("voxel_m")); });
    EXPECT_NE(refused(*soil, twice), "");
}

}  // namespace
}  // namespace bsoil::def_fields_test
