/// Random numbers from a seed, the same with every standard library: std's engines are specified to
/// the bit, its distributions are not.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <vector>

#include "bsoil/geometry.h"

namespace bsoil::random_worlds {

class Random {
  public:
    explicit Random(uint64_t seed) : bits_(seed) {}

    /// In [low, high).
    double uniform(double low, double high) {
        return low + (high - low) * (static_cast<double>(bits_() >> 11) * 0x1p-53);
    }
    /// Every order of magnitude alike.
    double log_uniform(double low, double high) {
        return std::exp(uniform(std::log(low), std::log(high)));
    }
    /// In low..high, both included.
    int integer(int low, int high) {
        return low + static_cast<int>(bits_() % static_cast<uint64_t>(high - low + 1));
    }
    bool chance(double probability) { return uniform(0, 1) < probability; }
    template <typename T>
    T choose(std::initializer_list<T> values) {
        return values.begin()[integer(0, static_cast<int>(values.size()) - 1)];
    }
    /// Each component in [-1, 1).
    Vec3 in_cube() {
        const double x = uniform(-1, 1), y = uniform(-1, 1);
        return {x, y, uniform(-1, 1)};
    }
    /// A unit vector, any direction.
    Vec3 direction() {
        for (;;) {
            const Vec3 v = in_cube();
            const double squared = dot(v, v);
            if (squared > 0.01 && squared <= 1) return v * (1 / std::sqrt(squared));
        }
    }
    Quat rotation() { return turn(direction(), uniform(0, 3.1)); }

    static Quat turn(Vec3 unit_axis, double angle_rad) {
        const Vec3 v = unit_axis * std::sin(angle_rad / 2);
        return {v.x, v.y, v.z, std::cos(angle_rad / 2)};
    }

  private:
    std::mt19937_64 bits_;
};

}  // namespace bsoil::random_worlds
