#include "oracle/wind.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace oracle {

namespace {

bool is_sheltered(const Model& model, const Field& field, int x, int y, int z) {
    const double most = std::max(std::abs(model.wind.x), std::abs(model.wind.y));
    if (most == 0) return false;
    const double dx = -model.wind.x / most, dy = -model.wind.y / most;
    const double rise = std::tan(std::numbers::pi / 12) * std::hypot(dx, dy);
    const auto whole = [](double value) { return static_cast<int>(std::floor(value + 0.5)); };
    for (int n = 1; n <= model.shelter; ++n) {
        const int nx = x + whole(n * dx), ny = y + whole(n * dy), nz = z + whole(n * rise);
        if (!field.inside(nx, ny, nz)) return false;
        const Voxel& voxel = field.at(nx, ny, nz);
        if (voxel.psi() >= model.solid_coverage || voxel.soil + voxel.psi() >= 1) return true;
    }
    return false;
}

/// Between -1 and 1, by the integer hash of the kernels.
double corner(int64_t x, int64_t y) {
    const auto cut = [](int64_t value) { return static_cast<uint32_t>(value & 1023); };
    const uint32_t place = cut(x) * 73856093u ^ cut(y) * 19349663u;
    return static_cast<double>((place ^ place >> 15) * 2246822519u >> 15) / 65536 - 1;
}

double gust_at(const Model& model, int x, int y) {
    const double u = (x + model.gust_x) / model.gust_cell, v = (y + model.gust_y) / model.gust_cell;
    const auto i = static_cast<int64_t>(std::floor(u)), j = static_cast<int64_t>(std::floor(v));
    const double low = std::lerp(corner(i, j), corner(i + 1, j), u - std::floor(u));
    const double high = std::lerp(corner(i, j + 1), corner(i + 1, j + 1), u - std::floor(u));
    return std::lerp(low, high, v - std::floor(v));
}

}  // namespace

Vec3 air_velocity(const Model& model, const Field& field, int x, int y, int z) {
    if (is_sheltered(model, field, x, y, z)) return {};
    const Vec3 wind = (1 + model.gust * gust_at(model, x, y)) * model.wind;
    const double fastest = std::max({std::abs(wind.x), std::abs(wind.y), std::abs(wind.z)});
    return fastest > model.substeps ? model.substeps / fastest * wind : wind;
}

Vec3 fall_in_air(const Model& model, Vec3 velocity, Vec3 air, double rate, double dt) {
    const double x = rate * dt, share = std::min(1.0, x / (1 + x / 2));
    return velocity + share * (air - velocity) + Vec3{0, 0, -model.gravity * dt * share / x};
}

}  // namespace oracle
