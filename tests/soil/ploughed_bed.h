// A wet bed that a plough goes through, for what has to hold while soil and water move.
#pragma once

#include <functional>

#include "stage_scenario.h"

namespace bsoil {

/// What beds have in common: rain, drainage and an open side in a grid of 2.4 x 0.8 x 0.8 m.
inline SoilDef ploughed_def(const MaterialDef& material, Backend backend, int threads) {
    SoilDef def = grid_def(48, 16, 16);
    def.material = material;
    def.material.conductivity_m_s = 0.01;
    def.rain_m_s = 5e-4;
    def.floor_drainage_m_s = 1e-3;
    def.open_sides = kOpenHighX;
    def.backend = backend;
    def.thread_count = threads;
    return def;
}

/// 0.4 m of soil, and a blade whose middle is at a height and that goes at 0.4 m/s.
struct PloughedBed {
    PloughedBed(const SoilDef& def, double blade_height_m)
        : soil(make_soil(def)), blade(1, box_shape({0.1, 0.25, 0.2}), {0.2, 0.4, blade_height_m}) {
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 16, 8})));
        blade.set_velocity({0.4, 0, 0});
    }
    void step() {
        blade.advance(soil->def().step_s);
        soil->step({&blade.body, 1});
    }
    std::unique_ptr<Soil> soil;
    Mover blade;
};

/// With 1 thread and 3, from a snapshot of one step on, and on GL where there is one.
inline void expect_same_bits(const std::function<PloughedBed(Backend, int threads)>& make,
                             int steps, int saved_step) {
    PloughedBed bed = make(Backend::cpu, 1), twin = make(Backend::cpu, 3);
    const std::string path =
        testing::TempDir() + "/" +
        testing::UnitTest::GetInstance()->current_test_info()->test_suite_name() + ".snapshot";
    std::vector<uint64_t> sums;
    for (int i = 0; i < steps; ++i) {
        if (i == saved_step) {
            ASSERT_TRUE(bed.soil->save(path));
            ASSERT_TRUE(twin.soil->load(path));
        }
        bed.step();
        sums.push_back(bed.soil->checksum());
        if (i < saved_step) {
            twin.blade.advance(twin.soil->def().step_s);
        } else {
            twin.step();
            ASSERT_EQ(twin.soil->checksum(), sums.back()) << "step " << i;
        }
    }
    const SoilTotals totals = bed.soil->totals(), of_twin = twin.soil->totals();
    EXPECT_EQ(totals.water_units_in, of_twin.water_units_in);
    EXPECT_EQ(totals.water_units_out, of_twin.water_units_out);
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    PloughedBed on_gl = make(Backend::gl, 1);
    for (size_t i = 0; i < sums.size(); ++i) {
        on_gl.step();
        ASSERT_EQ(on_gl.soil->checksum(), sums[i]) << "step " << i << " on GL";
    }
}

}  // namespace bsoil
