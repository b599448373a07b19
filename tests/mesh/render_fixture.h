/// A renderer for tests, and what they look at of its pictures.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "bsoil/render/primitives.h"
#include "bsoil/render/renderer.h"

namespace bsoil::render {

class Render : public ::testing::Test {
  protected:
    void SetUp() override {
        Result<std::unique_ptr<Renderer>> created = Renderer::create();
        if (!created) {
            GTEST_SKIP() << created.error();
        }
        renderer_ = std::move(*created);
    }

    Image draw(const View& view) {
        Result<Image> image = renderer_->render(view);
        EXPECT_TRUE(image) << image.error();
        return image ? *image : Image{};
    }

    std::unique_ptr<Renderer> renderer_;
};

inline double brightness(const Image& image, int x, int y) {
    const uint8_t* p = image.pixel(x, y);
    return (p[0] + p[1] + p[2]) / 3.0;
}

inline double mean_brightness(const Image& image, int x0, int y0, int x1, int y1) {
    double sum = 0;
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) sum += brightness(image, x, y);
    }
    return sum / ((x1 - x0) * (y1 - y0));
}

inline Item item_of(MeshId mesh, const Pose& pose) {
    Item item;
    item.mesh = mesh;
    item.pose = pose;
    return item;
}

/// Looks along -z at the origin; 1 m is 80 pixels there.
inline View front_view() {
    View view;
    view.width = 320;
    view.height = 200;
    view.camera = {{0, 0, 10}, {}, {0, 1, 0}, 2 * std::atan(100.0 / 80 / 10)};
    view.to_sun = {1, 0.2, 0.5};
    return view;
}

}  // namespace bsoil::render
