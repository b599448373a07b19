// What moves along the ground: asked for by pictures, so asking changes nothing.
#include <cmath>

#include "soil_fixture.h"

namespace bsoil::ground_motion_test {
namespace {

/// A block that comes down to a heap.
std::unique_ptr<Soil> block(Backend backend, SlideMotion slides) {
    SoilDef def = grid_def(32, 32, 16);
    def.material = fixed_density(sand(30));
    def.slides = slides;
    def.backend = backend;
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {12, 12, 0}, {20, 20, 10})));
    return soil;
}

struct Motions {
    int count = 0;  ///< columns that move
    double fastest_m_s = 0;
    std::vector<double> all_m_s;
    friend bool operator==(const Motions&, const Motions&) = default;
};

Motions motions_of(const Soil& soil) {
    Motions motions;
    for (int y = 0; y < soil.frame().size[1]; ++y) {
        for (int x = 0; x < soil.frame().size[0]; ++x) {
            const GroundMotion motion = soil.ground_motion(x, y);
            const double speed = std::max(motion.slip_m_s, length(motion.velocity_m_s));
            motions.count += speed > 0;
            motions.fastest_m_s = std::max(motions.fastest_m_s, speed);
            motions.all_m_s.push_back(speed);
        }
    }
    return motions;
}

TEST(GroundMotion, is_that_of_slides_and_asking_for_it_changes_nothing) {
    for (const SlideMotion slides : {SlideMotion::settle, SlideMotion::run_out}) {
        SCOPED_TRACE(slides == SlideMotion::settle ? "settle" : "run_out");
        auto asked = block(Backend::cpu, slides), other = block(Backend::cpu, slides);
        EXPECT_EQ(motions_of(*asked), motions_of(*other));
        EXPECT_EQ(motions_of(*asked).count, 0);
        double fastest_m_s = 0;
        int most = 0;
        for (int step = 0; step < 400; ++step) {
            asked->step({});
            other->step({});
            const Motions motions = motions_of(*asked);
            EXPECT_EQ(motions_of(*asked), motions);
            fastest_m_s = std::max(fastest_m_s, motions.fastest_m_s);
            most = std::max(most, motions.count);
        }
        EXPECT_EQ(asked->checksum(), other->checksum());
        EXPECT_EQ(asked->state(), other->state());
        EXPECT_LT(motions_of(*asked).fastest_m_s, 0.01);  // at rest
        // A fall of half a metre ends at 3 m/s, and a column of 8 x 8 comes down with what is
        // around it.
        EXPECT_GT(fastest_m_s, 0.3);
        EXPECT_LT(fastest_m_s, 3.2);
        EXPECT_GT(most, 64);
    }
}

TEST(GroundMotion, is_the_same_on_opengl_and_after_a_snapshot) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    for (const SlideMotion slides : {SlideMotion::settle, SlideMotion::run_out}) {
        SCOPED_TRACE(slides == SlideMotion::settle ? "settle" : "run_out");
        auto on_cpu = block(Backend::cpu, slides), on_gl = block(Backend::gl, slides);
        for (int step = 0; step < 10; ++step) {
            on_cpu->step({});
            on_gl->step({});
        }
        const Motions motions = motions_of(*on_cpu);
        EXPECT_GT(motions.count, 0);
        EXPECT_EQ(motions_of(*on_gl), motions);
        auto restored = block(Backend::cpu, slides);
        const auto put = restored->prepare(on_cpu->state());
        ASSERT_TRUE(put) << put.error();
        (*put)();
        EXPECT_EQ(motions_of(*restored), motions);
    }
}

}  // namespace
}  // namespace bsoil::ground_motion_test
