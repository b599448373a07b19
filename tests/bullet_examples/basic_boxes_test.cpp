// BasicExample: 5 x 5 x 5 boxes of 20 cm and 1 kg fall from 2 m.
#include "example.h"

namespace bsoil::bullet::basic_boxes_test {
namespace {

class Boxes : public Example {
  public:
    explicit Boxes(Ground ground) : Example(ground, {.side_m = 8, .depth_m = 0.5}) {
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

TEST(BasicExample, boxes_pile_up_on_sand_and_sleep) {
    Boxes rigid(Ground::rigid), sand(Ground::sand);
    const Course on_rigid = rigid.watch(30), on_sand = sand.watch(30);
    // 5 s on rigid ground, where the towers in the middle stay up. On sand they lean, and one or
    // the other falls later.
    EXPECT_LT(on_rigid.slept_s, 10);
    EXPECT_LT(on_sand.slept_s, 30);
    // Bullet pushes boxes that overlap after their fall apart.
    EXPECT_LT(on_sand.risen_j, on_rigid.risen_j);
    EXPECT_LT(on_sand.unbalanced_n, 0.02 * sand.weight_n());
    for (const auto& body : sand.bodies()) {
        EXPECT_GT(sand.height_m(*body), 0.1 - 0.05) << "5 kPa of boxes sink less than a voxel";
    }
    sand.run(15);  // sand that slides down between them takes some seconds longer
    EXPECT_TRUE(sand.soil().last_report().contacts_unchanged) << "at rest they cost nothing";
}

}  // namespace
}  // namespace bsoil::bullet::basic_boxes_test
