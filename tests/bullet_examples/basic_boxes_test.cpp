#include "basic_boxes.h"

namespace bsoil::bullet::basic_boxes_test {
namespace {

TEST(SlowBasicExample, boxes_pile_up_on_sand_and_sleep) {
    Boxes rigid(Ground::rigid), sand(Ground::sand);
    const Course on_rigid = rigid.watch(30), on_sand = sand.watch(30);
    // 5 s on rigid ground, where the towers in the middle stay up. On sand they lean, and one or
    // the other falls later.
    EXPECT_LT(on_rigid.slept_s, 10);
    EXPECT_LT(on_sand.slept_s, 30);
    // Bullet pushes boxes that overlap after their fall apart.
    EXPECT_LT(on_sand.risen_j, on_rigid.risen_j);
    EXPECT_LT(on_sand.unbalanced_n, 0.02 * sand.weight_n());
    // The sides of 125 boxes have 12,000 voxels' faces, not all of them in sand. Measured: 9,177
    // and 0.63.
    sand.expect_work(on_sand, 12000, 1);
    EXPECT_LT(on_sand.drift_m, 0.2) << "as much as a box; measured 0.12 on either ground";
    for (const auto& body : sand.bodies()) {
        EXPECT_GT(sand.height_m(*body), 0.1 - 0.05) << "5 kPa of boxes sink less than a voxel";
    }
    sand.run(15);  // sand that slides down between them takes some seconds longer
    EXPECT_TRUE(sand.soil().last_report().contacts_unchanged) << "at rest they cost nothing";
}

// A tower of five boxes is more than ten iterations of Bullet's solver can hold still: it rocks on
// rigid ground as well, and sand gives way below it. With 30 all sleep after 5 s, with 10 after 9.
TEST(BasicExample, boxes_sleep_sooner_where_the_solver_holds_them) {
    Boxes sand(Ground::sand, 30);
    const Course course = sand.watch(10);
    EXPECT_LT(course.slept_s, 7);
    sand.expect_work(course, 6200, 0.55);  // measured: 4,908 and 0.44
    EXPECT_LT(course.drift_m, 0.1) << "half a box; measured 0.05";
}

}  // namespace
}  // namespace bsoil::bullet::basic_boxes_test
