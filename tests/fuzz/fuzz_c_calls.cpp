#include <cmath>
#include <cstring>

#include "../c_api/test_world.h"
#include "bsoil/c/bulletsoil.h"
#include "targets.h"

namespace bsoil::fuzz {
namespace {

/// A world whose soil is made, filled, asked and destroyed as the choices say.
class CCaller {
  public:
    explicit CCaller(Choices& choices) : c_(choices), world_(test_world_create()) {}
    ~CCaller() {
        if (c_.flag()) bulletsoil_destroy(soil_);
        test_world_destroy(world_);
        bulletsoil_destroy(soil_);  // again: a dead handle is refused
    }
    CCaller(const CCaller&) = delete;
    CCaller& operator=(const CCaller&) = delete;

    void run() {
        create();
        for (int i = 0; i < 30 && !c_.at_end(); ++i) call();
    }

  private:
    /// What a result promises: a text with each failure, and no failure of the library's own.
    bool done(bulletsoil_result result) {
        if (result == BULLETSOIL_OK) return true;
        require(bulletsoil_last_error()[0] != '\0', "a failure without a text");
        require(result != BULLETSOIL_INTERNAL_ERROR, bulletsoil_last_error());
        require(result != BULLETSOIL_OUT_OF_MEMORY, "memory runs out");
        return false;
    }
    const double* point(double reach) {
        for (double& x : point_[point_index_]) x = c_.number(-reach, reach);
        const double* p = c_.below(64) == 63 ? nullptr : point_[point_index_];
        point_index_ = 1 - point_index_;
        return p;
    }
    const char* material() {
        constexpr const char* kNames[] = {nullptr, "", "dry_sand", "clay", "loam", "?"};
        return kNames[c_.below(static_cast<int>(std::size(kNames)))];
    }
    void* body() {
        if (balls_.empty()) return nullptr;
        return balls_[static_cast<size_t>(c_.below(static_cast<int>(balls_.size())))];
    }

    void create() {
        bulletsoil_material list[9];
        for (bulletsoil_material& m : list) {
            std::memset(&m, 0, sizeof m);
            const char* name = material();
            if (!done(bulletsoil_material_init(&m, sizeof m - (c_.below(32) == 31), name))) {
                bulletsoil_material_init(&m, sizeof m, "dry_sand");
            }
            if (c_.below(8) == 0) {
                m.density_kg_m3 = c_.number(200, 4000);
                m.friction_angle_rad = c_.number(0, 1.2);
                m.cohesion_pa = c_.number(0, 2e5);
                m.shear_displacement_m = c_.number(0, 0.2);
                m.roughness = c_.number(0, 40);
                m.viscosity = c_.number(0, 1);
            }
        }
        bulletsoil_soil_def def;
        require(bulletsoil_soil_def_init(&def, sizeof def) == BULLETSOIL_OK, "no definition");
        def.backend = BULLETSOIL_BACKEND_CPU;
        def.thread_count = 1;
        def.voxel_m = 0.1;
        for (double& size : def.size_m) size = 0.1 * (1 + c_.below(20));
        if (c_.below(4) == 0) {
            def.up = c_.below(3);
            def.yaw_rad = c_.number(-7, 7);
            def.gravity_m_s2 = c_.number(0, 30);
            def.step_s = c_.number(1.0 / 2000, 1.0 / 20);
            def.substeps_max = c_.below(34);
            def.tile_capacity = c_.below(6);
            def.propagation_iterations = c_.below(8);
            if (def.propagation_iterations % 4 == 3) def.step_budget_ms = 1e-6;
            for (double& x : def.floor_center_m) x = c_.number(-10, 10);
            def.material_count = static_cast<size_t>(c_.below(10));
            def.materials = c_.below(8) == 0 ? nullptr : list;
        }
        if (c_.below(32) == 31) def.struct_size = c_.word(2);
        const size_t scalar = test_world_scalar_bytes() + (c_.below(64) == 63 ? 4u : 0u);
        if (!done(bulletsoil_create(c_.below(64) == 63 ? nullptr : world_, scalar, &def, &soil_))) {
            require(soil_ == nullptr, "a handle without a soil");
        }
        check(false);
    }

    /// Soil comes from fills alone.
    void check(bool filled) {
        if (!soil_) return;
        size_t count = 0;
        require(bulletsoil_get_material_count(soil_, &count) == BULLETSOIL_OK, "no material count");
        std::vector<int64_t> units(count);
        std::vector<double> mass(count);
        require(bulletsoil_get_totals(soil_, count, units.data(), mass.data()) == BULLETSOIL_OK,
                "no totals");
        units_.resize(count, 0);
        for (size_t m = 0; m < count; ++m) {
            require(units[m] >= units_[m] && (filled || units[m] == units_[m]),
                    "soil is not conserved");
            require(std::isfinite(mass[m]), "a mass is not finite");
        }
        units_ = units;
    }

    void call() {
        switch (c_.below(16)) {
            case 0:
                return check(done(bulletsoil_fill_box(soil_, point(2), point(2), material())));
            case 1:
                return check(done(bulletsoil_fill_cylinder(soil_, point(2), c_.number(0, 2),
                                                           c_.number(0, 2), material())));
            case 2: {
                float heights[36];
                for (float& h : heights) h = static_cast<float>(c_.number(-0.5, 2));
                const int width = c_.below(8) - 1;
                const int height = width > 0 ? std::min(36 / width, c_.below(8) - 1) : c_.below(8);
                return check(done(bulletsoil_fill_height_map(
                    soil_, width, height, c_.below(32) == 31 ? nullptr : heights, material())));
            }
            case 3:
                if (balls_.size() < 5) {
                    balls_.push_back(
                        c_.below(6) == 0
                            ? test_world_add_empty(world_)
                            : test_world_add_ball(world_, 1 + c_.below(100), 0.1 * c_.below(20)));
                }
                return;
            case 4:
                done(bulletsoil_set_body_ignored(soil_, body(), c_.below(2)));
                return;
            case 5:
                done(bulletsoil_set_body_coverage_only(soil_, body(), c_.below(2)));
                return;
            case 6:
                done(bulletsoil_set_body_surface(soil_, body(), c_.number(-1, 2),
                                                 c_.number(-1, 2e5)));
                return;
            case 7:
                done(bulletsoil_set_enabled(soil_, c_.below(2)));
                return;
            case 8: {
                bulletsoil_body_report report;
                report.struct_size = c_.below(32) == 31 ? c_.word(1) : sizeof report;
                if (done(bulletsoil_get_body_report(soil_, body(), &report))) {
                    require(std::isfinite(report.force_n[0]) && std::isfinite(report.load_kg),
                            "a report is not finite");
                }
                return;
            }
            case 9: {
                double height = 0;
                if (done(bulletsoil_get_surface_height(soil_, point(1), &height))) {
                    require(std::isfinite(height), "a height is not finite");
                }
                return;
            }
            case 10: {
                char text[64];
                size_t needed = 0;
                const size_t capacity = static_cast<size_t>(c_.below(65));
                done(bulletsoil_get_status_text(soil_, capacity > 0 ? text : nullptr, capacity,
                                                c_.flag() ? &needed : nullptr));
                done(bulletsoil_clear_status(soil_));
                return;
            }
            case 11:
                return save_and_load();
            case 12: {
                uint64_t checksum = 0;
                int64_t steps = 0;
                done(bulletsoil_get_checksum(soil_, &checksum));
                done(bulletsoil_get_step_count(soil_, &steps));
                return;
            }
            default:
                test_world_step(world_, 1 + c_.below(2));
                return check(false);
        }
    }

    void save_and_load() {
        if (!soil_) return;
        const std::string path = scratch_path("c.snapshot");
        if (!done(bulletsoil_save(soil_, path.c_str()))) return;
        if (c_.flag()) test_world_step(world_, 1);
        require(done(bulletsoil_load(soil_, path.c_str())), "a snapshot just written is refused");
        check(false);
    }

    Choices& c_;
    void* world_;
    bulletsoil_soil* soil_ = nullptr;
    std::vector<void*> balls_;
    std::vector<int64_t> units_;
    double point_[2][3] = {};
    int point_index_ = 0;
};

}  // namespace

void fuzz_c_calls(Bytes bytes) { run_calls<CCaller>(bytes); }

}  // namespace bsoil::fuzz
