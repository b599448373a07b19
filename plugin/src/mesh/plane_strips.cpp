#include "mesh/plane_strips.h"

namespace bsoil::mesh {
namespace {

constexpr int kFloorSample = 1;  ///< the sample on the floor; sample 0, there too, is empty

}  // namespace

void PlaneStrips::build(const TileLevels& levels) {
    for (int j = field_.cell_first(1) - 1; j <= field_.cell_last(1) + 1; ++j) {
        for (int i = field_.cell_first(0) - 1; i <= field_.cell_last(0) + 1; ++i) {
            if (!field_.is_in_window(i, j)) continue;
            is_plain_[field_.column_index(i, j)] = levels.is_plain(field_.level(), i, j);
        }
    }
}

uint64_t PlaneStrips::whole_of_side(int i, int j, int along, int w) const {
    if (!is_plain(i, j)) return 0;
    const int word_count = field_.word_count();
    const uint64_t* low = field_.inside_bits(i, j);
    const uint64_t* high = field_.inside_bits(i + (along == 0), j + (along == 1));
    return low[w] & shifted_down(low, w, word_count) & high[w] & shifted_down(high, w, word_count);
}

uint64_t PlaneStrips::kept_on_side(int i, int j, int along, int w) const {
    const uint64_t inside = field_.inside_bits(i, j)[w];
    if (inside == 0) return 0;
    const int before_i = i - (along == 0), before_j = j - (along == 1);
    const auto whole = [&](int word) {
        return whole_of_side(before_i, before_j, along, word) & whole_of_side(i, j, along, word);
    };
    const uint64_t here = whole(w), below = w > 0 ? whole(w - 1) : 0;
    return inside & (~(here & (here << 1 | below >> 63)) | field_.material_borders(i, j, w));
}

bool PlaneStrips::is_whole_of_floor(int i, int j) const {
    const auto stands = [&](int x, int y) {
        return (field_.inside_bits(x, y)[0] >> kFloorSample & 1) != 0;
    };
    return is_plain(i, j) && stands(i, j) && stands(i + 1, j) && stands(i, j + 1) &&
           stands(i + 1, j + 1);
}

bool PlaneStrips::is_kept_on_floor(int i, int j) const {
    if (i % TileLevels::cells_of(field_.level()) == 0) return true;
    for (int y = j - 1; y <= j; ++y) {
        for (int x = i - 1; x <= i; ++x) {
            if (!is_whole_of_floor(x, y)) return true;
        }
    }
    const uint8_t own = field_.material(i, j, 0);
    return field_.material(i - 1, j, 0) != own || field_.material(i + 1, j, 0) != own;
}

}  // namespace bsoil::mesh
