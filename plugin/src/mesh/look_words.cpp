#include "mesh/look_words.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "mesh/mesh_kernels.h"

namespace bsoil::mesh {
namespace {

static_assert(kernels::kLookWords ==
              kernels::kLookWeights + sizeof(MaterialWeights) / sizeof(int32_t));

void push(const Look& look, std::vector<int32_t>& words) {
    for (const float channel : look.color) words.push_back(std::bit_cast<int32_t>(channel));
    words.push_back(std::bit_cast<int32_t>(static_cast<float>(look.wetness) / 255));
    int32_t weights[sizeof(MaterialWeights) / sizeof(int32_t)];
    std::memcpy(weights, look.weights.data(), sizeof(weights));
    words.insert(words.end(), std::begin(weights), std::end(weights));
}

}  // namespace

void LookWords::begin(std::vector<int32_t>& words) const {
    for (const Look& look : writer_.plain_looks()) push(look, words);
}

int32_t LookWords::plain(uint8_t material) const {
    const size_t last = writer_.plain_looks().size() - 1;
    return static_cast<int32_t>(std::min<size_t>(material, last)) * kernels::kLookWords;
}

int32_t LookWords::add(const Look& look, std::vector<int32_t>& words) const {
    push(look, words);
    return static_cast<int32_t>(words.size()) - kernels::kLookWords;
}

int32_t LookWords::add_layers(const DisplayField& field, int i, int j,
                              std::vector<int32_t>& words) const {
    const auto layers = field.layers(i, j);
    const auto mixes = field.mixes(i, j);
    const auto runs = field.runs(i, j);
    // Below the lowest layer there is what is at the top of the lowest run.
    uint8_t material = runs.empty() ? uint8_t{0} : runs.front().material;
    const MixedLayer* mixture = nullptr;
    std::vector<int32_t> entries;
    size_t l = 0, m = 0;
    while (l < layers.size() || m < mixes.size()) {
        const int bottom = m == mixes.size() || (l < layers.size() &&
                                                 layers[l].bottom_voxel <= mixes[m].bottom_voxel)
                               ? layers[l].bottom_voxel
                               : mixes[m].bottom_voxel;
        for (; l < layers.size() && layers[l].bottom_voxel == bottom; ++l) {
            material = layers[l].material;
        }
        for (; m < mixes.size() && mixes[m].bottom_voxel == bottom; ++m) mixture = &mixes[m];
        const int32_t look =
            mixture ? add(writer_.look_mixed(material, mixture), words) : plain(material);
        entries.insert(entries.end(), {bottom, look});
    }
    const auto begin = static_cast<int32_t>(words.size());
    words.insert(words.end(), entries.begin(), entries.end());
    return begin;
}

}  // namespace bsoil::mesh
