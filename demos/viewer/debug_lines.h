/// Bullet's own drawing, collected as lines.
#pragma once

#include <LinearMath/btIDebugDraw.h>

#include <vector>

#include "bsoil/render/renderer.h"

namespace bsoil::viewer {

class DebugLines final : public btIDebugDraw {
  public:
    explicit DebugLines(std::vector<render::Line>& lines) : lines_(lines) {}

    void drawLine(const btVector3& from, const btVector3& to, const btVector3& color) override {
        lines_.push_back({at(from),
                          at(to),
                          {static_cast<float>(color.x()), static_cast<float>(color.y()),
                           static_cast<float>(color.z())}});
    }
    void drawContactPoint(const btVector3& point, const btVector3& normal, btScalar, int,
                          const btVector3& color) override {
        drawLine(point, point + normal * btScalar(kContactM), color);
    }
    void reportErrorWarning(const char*) override {}
    void draw3dText(const btVector3&, const char*) override {}
    void setDebugMode(int mode) override { mode_ = mode; }
    int getDebugMode() const override { return mode_; }

  private:
    static constexpr double kContactM = 0.2;
    static Vec3 at(const btVector3& v) {
        return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
    }

    std::vector<render::Line>& lines_;
    int mode_ = 0;
};

}  // namespace bsoil::viewer
