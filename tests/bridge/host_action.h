// An action of the host's for tests.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <utility>

namespace bsoil::bullet {

class HostAction final : public btActionInterface {
  public:
    explicit HostAction(std::function<void()> act) : act_(std::move(act)) {}
    void updateAction(btCollisionWorld*, btScalar) override { act_(); }
    void debugDraw(btIDebugDraw*) override {}

  private:
    std::function<void()> act_;
};

}  // namespace bsoil::bullet
