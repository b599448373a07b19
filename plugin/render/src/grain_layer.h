/// Groups of grains on the device.
#pragma once

#include <span>
#include <vector>

#include "frame.h"
#include "gl_objects.h"

namespace bsoil::render {

class GrainLayer {
  public:
    void create();
    /// Copies a view's groups to the device, about its eye.
    void fill(const View& view, const Frame& frame);
    bool is_empty() const { return group_count_ == 0; }
    /// Draws all groups with the program in use: one call.
    void draw() const;

  private:
    GlVertexArray layout_;
    GlBuffer offsets_, groups_;
    std::vector<float> floats_;
    GLsizei group_count_ = 0;
};

}  // namespace bsoil::render
