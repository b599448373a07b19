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
    /// Copies a view's groups to the device, about its eye. Each pixel is lit in `samples_aside`
    /// places along x and y.
    void fill(const View& view, const Frame& frame, int samples_aside);
    bool is_empty() const { return part_count_ == 0; }
    bool casts_shadows() const { return in_air_count_ > 0; }
    /// Draws all groups with the program in use: one call.
    void draw() const { draw(part_count_); }
    /// Only those that cast shadows: what lies flat on the ground darkens nothing else.
    void draw_casters() const { draw(in_air_count_); }

  private:
    void append(const GrainGroup& group, const View& view, const Frame& frame, double least_pixels);
    void draw(GLsizei part_count) const;

    GlVertexArray layout_;
    GlBuffer offsets_, groups_;
    std::vector<float> floats_;
    GLsizei part_count_ = 0, in_air_count_ = 0;  ///< of groups; those in the air are the first
};

}  // namespace bsoil::render
