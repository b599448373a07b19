/// What the soil of a window looks like, as the kernel that keeps meshes reads it.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/display_field.h"
#include "mesh/vertex_writer.h"

namespace bsoil::mesh {

class LookWords {
  public:
    explicit LookWords(const VertexWriter& writer) : writer_(writer) {}
    /// The materials by themselves: in front of all else.
    void begin(std::vector<int32_t>& words) const;
    /// The place in `words` of a look that it adds, or of the last one added if it is the same.
    int32_t add(const Look& look, std::vector<int32_t>& words) const;
    /// The place of a material by itself.
    int32_t plain(uint8_t material) const;
    /// Adds the layers of a column, from below, behind the looks that they have. Their end is the
    /// end of `words`. Returns where they begin.
    int32_t add_layers(const DisplayField& field, int i, int j, std::vector<int32_t>& words) const;

  private:
    const VertexWriter& writer_;
};

}  // namespace bsoil::mesh
