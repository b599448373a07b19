/// Clouds of dust on the device.
#pragma once

#include <vector>

#include "frame.h"
#include "gl_objects.h"

namespace bsoil::render {

class DustLayer {
  public:
    void create();
    /// Copies a view's clouds to the device as they are at its time, the far ones first.
    void fill(const View& view, const Frame& frame);
    bool is_empty() const { return count_ == 0; }
    /// What the clouds may cover of the picture, -1..1: x and y of its lower left corner, then of
    /// the upper right one.
    glm::vec4 bounds() const { return bounds_; }
    /// Draws all of them with the program in use: one call.
    void draw() const;

  private:
    struct Cloud {
        glm::vec4 center_radius, color_alpha;
        glm::vec4 seed;  ///< three numbers 0..1
    };
    GlVertexArray layout_;
    GlBuffer instances_;
    std::vector<Cloud> clouds_;
    GLsizei count_ = 0;
    glm::vec4 bounds_{0};
};

}  // namespace bsoil::render
