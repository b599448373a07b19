#include "bullet_dna.h"

#include <algorithm>
#include <charconv>

#include "files/byte_cursor.h"

// Bullet's own, in LinearMath.
extern char sBulletDNAstr64[];
extern int sBulletDNAlen64;

namespace bsoil::scene {
namespace {

/// Of types that are no structures; what Bullet's converter takes them to be.
const std::map<std::string, size_t, std::less<>> kBasicSizes{
    {"char", 1}, {"uchar", 1}, {"short", 2}, {"ushort", 2}, {"int", 4},
    {"long", 4}, {"ulong", 4}, {"float", 4}, {"double", 8}, {"void", 0}};

/// Bullet takes half of this structure for the size of a pointer, and reads two sizes of an array.
constexpr const char* kTwoPointers = "ListBase";
constexpr int kDimensionsMost = 2;

/// "*name", "**name", "name[3]", "name[3][3]" taken apart; false where it is none of these.
bool read_name(std::string_view text, BulletDna::Field& field) {
    field.pointer_depth = 0;
    while (text.starts_with('*')) {
        ++field.pointer_depth;
        text.remove_prefix(1);
    }
    const size_t bracket = std::min(text.find('['), text.size());
    field.name = std::string(text.substr(0, bracket));
    text.remove_prefix(bracket);
    if (field.name.find('*') != std::string::npos) return false;  // Bullet looks for one there
    field.count = 1;
    for (int dimension = 0; !text.empty(); ++dimension) {
        if (dimension == kDimensionsMost) return false;
        const size_t end = text.find(']');
        size_t count = 0;
        if (text[0] != '[' || end == std::string_view::npos) return false;
        const auto [rest, failed] = std::from_chars(text.data() + 1, text.data() + end, count);
        if (failed != std::errc() || rest != text.data() + end || count < 1 || count > 4096) {
            return false;
        }
        field.count *= count;
        if (field.count > 4096) return false;
        text.remove_prefix(end + 1);
    }
    return !field.name.empty() && field.pointer_depth <= 2;
}

}  // namespace

const BulletDna::Field* BulletDna::Structure::find(std::string_view field) const {
    const auto found =
        std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == field; });
    return found == fields.end() ? nullptr : &*found;
}

Result<BulletDna> BulletDna::parse(std::string_view bytes, size_t pointer_size) {
    const Error damaged{"its description of structures is damaged"};
    ByteCursor in(bytes);
    const auto texts = [&in](std::string_view tag) {
        in.expect(tag);
        std::vector<std::string_view> out;
        const auto count = in.get<uint32_t>();
        for (uint32_t i = 0; i < count && in.good(); ++i) out.push_back(in.get_text());
        in.align();
        return out;
    };
    in.expect("SDNA");
    const auto names = texts("NAME"), types = texts("TYPE");
    in.expect("TLEN");
    std::vector<size_t> lengths;
    for (size_t i = 0; i < types.size() && in.good(); ++i) lengths.push_back(in.get<uint16_t>());
    in.align();
    in.expect("STRC");
    const auto structure_count = in.get<uint32_t>();
    if (!in.good()) return damaged;

    BulletDna dna;
    for (size_t i = 0; i < types.size(); ++i) {
        if (!dna.sizes.emplace(types[i], lengths[i]).second) return damaged;
    }
    for (const auto& [type, size] : kBasicSizes) {
        if (const auto found = dna.sizes.find(type);
            found != dna.sizes.end() && found->second != size) {
            return damaged;
        }
    }
    size_t first_type = types.size();
    std::vector<std::vector<size_t>> field_types;
    for (uint32_t s = 0; s < structure_count; ++s) {
        const auto type = in.get<uint16_t>(), field_count = in.get<uint16_t>();
        if (!in.good() || type >= types.size() || kBasicSizes.contains(types[type])) return damaged;
        if (s == 0) first_type = type;
        Structure& structure = dna.structures.emplace_back();
        structure.name = types[type];
        structure.size = lengths[type];
        if (!dna.numbers.emplace(structure.name, static_cast<int>(s)).second) return damaged;
        auto& its_types = field_types.emplace_back();
        for (uint16_t f = 0; f < field_count; ++f) {
            const auto field_type = in.get<uint16_t>(), field_name = in.get<uint16_t>();
            if (!in.good() || field_type >= types.size() || field_name >= names.size()) {
                return damaged;
            }
            Field field;
            field.type = types[field_type];
            if (!read_name(names[field_name], field)) return damaged;
            field.offset = structure.fields.empty()
                               ? 0
                               : structure.fields.back().offset + structure.fields.back().size;
            field.size =
                field.count * (field.pointer_depth > 0 ? pointer_size : lengths[field_type]);
            structure.fields.push_back(std::move(field));
            its_types.push_back(field_type);
        }
        const size_t end = structure.fields.empty()
                               ? 0
                               : structure.fields.back().offset + structure.fields.back().size;
        if (structure.size == 0 || end != structure.size) return damaged;
    }
    const auto pointers = dna.numbers.find(kTwoPointers);
    if (pointers == dna.numbers.end() ||
        dna.structures[static_cast<size_t>(pointers->second)].size != 2 * pointer_size) {
        return damaged;
    }
    for (size_t s = 0; s < dna.structures.size(); ++s) {
        for (size_t f = 0; f < dna.structures[s].fields.size(); ++f) {
            Field& field = dna.structures[s].fields[f];
            if (const auto found = dna.numbers.find(field.type); found != dna.numbers.end()) {
                field.structure = found->second;
            }
            if (field.pointer_depth > 0) continue;
            // Bullet takes types behind the first structure's for structures, and goes into them.
            const bool goes_in = field_types[s][f] >= first_type;
            if (goes_in != (field.structure >= 0)) return damaged;
            // Structures are described before they are used: none is inside itself.
            if (field.structure >= static_cast<int>(s)) return damaged;
            if (field.structure < 0 && !kBasicSizes.contains(field.type)) return damaged;
        }
    }
    return dna;
}

const BulletDna& BulletDna::own() {
    static const BulletDna kOwn =
        *parse({sBulletDNAstr64, static_cast<size_t>(sBulletDNAlen64)}, sizeof(void*));
    return kOwn;
}

bool BulletDna::is_a(int structure, std::string_view name) const {
    while (structure >= 0) {
        const Structure& s = structures[static_cast<size_t>(structure)];
        if (s.name == name) return true;
        const Field* first = s.fields.empty() ? nullptr : &s.fields.front();
        structure = first && first->pointer_depth == 0 ? first->structure : -1;
    }
    return false;
}

bool BulletDna::fits(const BulletDna& own) const {
    return std::all_of(structures.begin(), structures.end(), [&](const Structure& theirs) {
        const auto number = own.numbers.find(theirs.name);
        if (number == own.numbers.end()) return true;  // left alone
        const Structure& ours = own.structures[static_cast<size_t>(number->second)];
        return std::all_of(theirs.fields.begin(), theirs.fields.end(), [&](const Field& field) {
            const Field* same = ours.find(field.name);
            if (!same) return true;
            const bool is_structure = field.pointer_depth == 0 && field.structure >= 0;
            const bool same_kind =
                is_structure == (same->pointer_depth == 0 && same->structure >= 0) &&
                field.pointer_depth == same->pointer_depth;
            // Pointers to structures, too: Bullet follows them as to its own.
            const bool is_number = !own.numbers.contains(same->type);
            return same_kind && field.count == same->count &&
                   (is_number || field.type == same->type);
        });
    });
}

}  // namespace bsoil::scene
