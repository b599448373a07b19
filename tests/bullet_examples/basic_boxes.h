/// BasicExample: 5 x 5 x 5 boxes of 20 cm and 1 kg fall from 2 m.
#pragma once

#include "example.h"

namespace bsoil::bullet {

class Boxes : public Example {
  public:
    /// iterations: of Bullet's solver, whose own default is 10.
    explicit Boxes(Ground ground, int iterations = 10, int threads = 0)
        : Example(ground, {.side_m = 8, .depth_m = 0.5, .threads = threads}) {
        scene_.world->getSolverInfo().m_numIterations = iterations;
        btCollisionShape& box = scene_.shape<btBoxShape>(btVector3(0.1f, 0.1f, 0.1f));
        for (int k = 0; k < 5; ++k) {
            for (int i = 0; i < 5; ++i) {
                for (int j = 0; j < 5; ++j) {
                    scene_.add(
                        1, box,
                        btVector3(0.2f * static_cast<float>(i), 2 + 0.2f * static_cast<float>(k),
                                  0.2f * static_cast<float>(j)));
                }
            }
        }
    }
};

}  // namespace bsoil::bullet
