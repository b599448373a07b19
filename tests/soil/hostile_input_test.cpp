// Definitions, fills and terrain that cannot be: each gives an error that names the field, and
// changes nothing.
#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "bsoil/backend_choice.h"
#include "soil_fixture.h"

namespace bsoil::hostile_input_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct BadField {
    const char* name;
    std::function<void(SoilDef&)> spoil;
};

TEST(SoilDefinition, every_field_out_of_range_is_named) {
    std::vector<BadField> cases;
    const auto add = [&](const char* name, auto member, std::initializer_list<double> values) {
        for (double value : values) {
            cases.push_back({name, [=](SoilDef& def) {
                                 member(def) =
                                     static_cast<std::remove_reference_t<decltype(member(def))>>(
                                         value);
                             }});
        }
    };
    add("voxel_m", [](SoilDef& d) -> double& { return d.voxel_m; },
        {0, -1, 0.0009, 1.1, kNan, kInfinity});
    add("step_s", [](SoilDef& d) -> double& { return d.step_s; },
        {0, -1, 1e-5, 0.06, kNan, kInfinity});
    add("gravity_m_s2", [](SoilDef& d) -> double& { return d.gravity_m_s2; },
        {-1, 31, kNan, kInfinity});
    add("propagation_iterations", [](SoilDef& d) -> int& { return d.propagation_iterations; },
        {-1, 65});
    add("overflow_passes", [](SoilDef& d) -> int& { return d.overflow_passes; }, {-1, 65});
    add("substeps_max", [](SoilDef& d) -> int& { return d.substeps_max; }, {0, -1, 33});
    add("tile_capacity", [](SoilDef& d) -> int& { return d.tile_capacity; }, {-1});
    add("thread_count", [](SoilDef& d) -> int& { return d.thread_count; }, {-1, 1025});
    add("yaw_rad", [](SoilDef& d) -> double& { return d.yaw_rad; }, {kNan, kInfinity, 90});
    add("floor_center_m", [](SoilDef& d) -> double& { return d.floor_center_m.y; },
        {kNan, kInfinity, 1.1e7, -1e300});
    add("size_m", [](SoilDef& d) -> double& { return d.size_m.x; }, {0, -1, 1e9, kNan, kInfinity});
    add("size_m", [](SoilDef& d) -> double& { return d.size_m.y; }, {0, -1, 1e9, kNan, kInfinity});
    add("size_m", [](SoilDef& d) -> double& { return d.size_m.z; }, {0, -1, 1e9, kNan, kInfinity});
    add("density_kg_m3", [](SoilDef& d) -> double& { return d.material.density_kg_m3; },
        {0, -1, 199, 4001, kNan});
    add("friction_angle_rad", [](SoilDef& d) -> double& { return d.material.friction_angle_rad; },
        {-0.1, 1.3, 33, kNan});
    add("cohesion_pa", [](SoilDef& d) -> double& { return d.material.cohesion_pa; },
        {-1, 2e6, kNan, kInfinity});
    add("loose_cohesion_fraction",
        [](SoilDef& d) -> double& { return d.material.loose_cohesion_fraction; },
        {-0.1, 1.1, kNan});
    add("compaction_cohesion_ratio",
        [](SoilDef& d) -> double& { return d.material.compaction_cohesion_ratio; },
        {-0.1, 0.6, kNan});
    add("dilatancy_angle_rad", [](SoilDef& d) -> double& { return d.material.dilatancy_angle_rad; },
        {-0.1, 0.2, kNan});
    add("tool_friction", [](SoilDef& d) -> double& { return d.material.tool_friction; },
        {-0.1, 2.1, kNan});
    cases.push_back({"name", [](SoilDef& d) { d.material.name.clear(); }});
    cases.push_back({"materials", [](SoilDef& d) {
                         d.materials = {materials::loam(), materials::loam()};
                     }});
    cases.push_back({"materials", [](SoilDef& d) {
                         for (int i = 0; i < 9; ++i) {
                             d.materials.push_back(materials::clay());
                             d.materials.back().name += std::to_string(i);
                         }
                     }});
    cases.push_back({"backend", [](SoilDef& d) { d.backend = static_cast<Backend>(7); }});
    cases.push_back({"up", [](SoilDef& d) { d.up = static_cast<UpAxis>(7); }});
    cases.push_back(
        {"overflow", [](SoilDef& d) { d.overflow = static_cast<OverflowHeuristic>(7); }});
    for (const BadField& bad : cases) {
        SoilDef def = grid_def(16, 16, 16);
        bad.spoil(def);
        const auto soil = Soil::create(def);
        EXPECT_FALSE(soil) << bad.name;
        EXPECT_NE(soil.error().find(bad.name), std::string::npos)
            << bad.name << ": " << soil.error();
    }
}

class HostileFill : public testing::Test {
  protected:
    void SetUp() override {
        soil_ = make_soil(grid_def(16, 16, 16));
        ASSERT_TRUE(soil_->fill(voxel_box(*soil_, {0, 0, 0}, {16, 16, 4})));
        checksum_ = soil_->checksum();
    }
    void TearDown() override { EXPECT_EQ(soil_->checksum(), checksum_); }

    template <typename Input>
    void expect_refused(const Input& input, const char* field) {
        Status status = Done{};
        if constexpr (requires { soil_->fill(input); }) {
            status = soil_->fill(input);
        } else {
            status = soil_->add_terrain(input);
        }
        ASSERT_FALSE(status) << field;
        EXPECT_NE(status.error().find(field), std::string::npos) << field << ": " << status.error();
    }
    std::unique_ptr<Soil> soil_;
    uint64_t checksum_ = 0;
};

TEST_F(HostileFill, boxes) {
    for (double bad : {kNan, kInfinity, -kInfinity}) {
        expect_refused(BoxFill{{{0, 0, 0}, {bad, 1, 1}}, {}}, "box");
        expect_refused(BoxFill{{{0, bad, 0}, {1, 1, 1}}, {}}, "box");
    }
    expect_refused(BoxFill{{{1, 1, 1}, {0, 0, 0}}, {}}, "box");
    expect_refused(BoxFill{{{0, 0, 0}, {0, 1, 1}}, {}}, "box");
    expect_refused(BoxFill{{{50, 50, 50}, {51, 51, 51}}, {}}, "outside");
    expect_refused(BoxFill{{{-1e300, -1e300, 1e300}, {-1e299, 1e300, 1.1e300}}, {}}, "outside");
    expect_refused(voxel_box(*soil_, {0, 0, 0}, {16, 16, 4}), "no soil");
    expect_refused(voxel_box(*soil_, {0, 0, 4}, {16, 16, 6}, "cheese"), "material");
}

TEST_F(HostileFill, cylinders) {
    for (double bad : {0.0, -1.0, kNan, kInfinity}) {
        expect_refused(CylinderFill{{0.4, 0.4, 0.3}, bad, 0.1, {}}, "radius_m");
        expect_refused(CylinderFill{{0.4, 0.4, 0.3}, 0.1, bad, {}}, "height_m");
    }
    expect_refused(CylinderFill{{kNan, 0, 0}, 0.1, 0.1, {}}, "base_center_m");
    expect_refused(CylinderFill{{90, 0, 0}, 0.1, 0.1, {}}, "outside");
}

TEST_F(HostileFill, height_maps) {
    HeightMapFill good{4, 4, std::vector<float>(16, 0.3f), {}};
    for (float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        HeightMapFill fill = good;
        fill.heights_m[7] = bad;
        expect_refused(fill, "heights_m");
    }
    for (int size : {0, 1, -4, 1 << 20}) {
        HeightMapFill fill = good;
        fill.width = size;
        expect_refused(fill, "width");
        fill = good;
        fill.height = size;
        expect_refused(fill, "height");
    }
    HeightMapFill fill = good;
    fill.heights_m.pop_back();
    expect_refused(fill, "heights_m");
    fill = good;
    fill.heights_m.assign(16, -1e30f);
    expect_refused(fill, "no soil");
}

TEST_F(HostileFill, noise) {
    const auto refused = [&](auto NoiseFill::*field, auto value, const char* name) {
        NoiseFill fill;
        fill.*field = value;
        expect_refused(fill, name);
    };
    refused(&NoiseFill::base_m, kNan, "base_m");
    refused(&NoiseFill::amplitude_m, -1.0, "amplitude_m");
    refused(&NoiseFill::wavelength_m, 0.0, "wavelength_m");
    refused(&NoiseFill::wavelength_m, kInfinity, "wavelength_m");
    refused(&NoiseFill::octaves, 0, "octaves");
    refused(&NoiseFill::octaves, 60, "octaves");
    refused(&NoiseFill::persistence, 1.5, "persistence");
}

TEST_F(HostileFill, functions) {
    expect_refused(FunctionFill{}, "density");
    expect_refused(FunctionFill{[](Vec3) { return kNan; }, {}}, "no soil");
    expect_refused(DensityFunction(), "density");
    expect_refused(DensityFunction([](Vec3) { return kNan; }), "terrain");
}

TEST_F(HostileFill, terrain_that_would_bury_soil) {
    expect_refused(DensityFunction([](Vec3 at) { return 0.1 - at.z; }), "bury");
    // Only the last tile looked at collides: the ones before it must not keep their rock.
    expect_refused(DensityFunction([](Vec3 at) {
                       return at.z > 0.5 || (at.x > 0.7 && at.y > 0.7) ? 1.0 : -1.0;
                   }),
                   "bury");
}

/// A box as a closed mesh, outward normals.
TriangleMesh box_mesh(Vec3 low, Vec3 high) {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i) {
        mesh.vertices.push_back(
            {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    }
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

TEST_F(HostileFill, meshes) {
    const TriangleMesh good = box_mesh({0.1, 0.1, 0.4}, {0.5, 0.5, 0.6});
    TriangleMesh open = good;
    open.triangles.pop_back();
    expect_refused(open, "closed");
    TriangleMesh twisted = good;
    std::swap(twisted.triangles[0][0], twisted.triangles[0][1]);
    expect_refused(twisted, "closed");
    TriangleMesh dangling = good;
    dangling.triangles[3][1] = 99;
    expect_refused(dangling, "vertex");
    dangling.triangles[3][1] = -1;
    expect_refused(dangling, "vertex");
    TriangleMesh broken = good;
    broken.vertices[2].z = kNan;
    expect_refused(broken, "vertex");
    expect_refused(TriangleMesh{}, "triangles");
    expect_refused(box_mesh({10, 10, 10}, {11, 11, 11}), "outside");
    expect_refused(box_mesh({0.1, 0.1, 0.0}, {0.5, 0.5, 0.6}), "bury");
}

TEST(HostileGrid, work_that_never_ends_is_refused_with_the_cure) {
    // 8192 x 8192 columns: the most there may be; what is put in has to be shallow.
    SoilDef def = grid_def(8192, 8192, 512);
    auto soil = make_soil(def);
    const auto expect_refused = [](const Status& status, const std::string& text) {
        EXPECT_FALSE(status);
        EXPECT_NE(status.error().find(text), std::string::npos) << status.error();
    };
    const DensityFunction density = [](Vec3) { return 1.0; };
    expect_refused(soil->fill(FunctionFill{density, {}}), "another kind of ground");
    expect_refused(soil->add_terrain(density), "another kind of ground");
    expect_refused(soil->add_terrain(box_mesh({-200, -200, -1}, {200, 200, 20})),
                   "take larger voxels or a smaller box");
    TriangleMesh pile;
    for (int i = 0; i < 1000; ++i) {
        const TriangleMesh box = box_mesh({-200, -200, -1}, {200, 200, 1e-3 * i});
        const int first = static_cast<int>(pile.vertices.size());
        pile.vertices.insert(pile.vertices.end(), box.vertices.begin(), box.vertices.end());
        for (const auto& t : box.triangles) {
            pile.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
        }
    }
    expect_refused(soil->add_terrain(pile), "too many triangles over each other");
    EXPECT_EQ(soil->totals().units, std::vector<int64_t>{0});
    def.size_m.x *= 1.01;
    EXPECT_NE(def.validate().error().find("take larger voxels or a smaller box"),
              std::string::npos);
}

TEST(HostileGrid, tiles_outside_of_it_are_empty) {
    auto soil = make_soil(grid_def(16, 16, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {16, 16, 4})));
    std::vector<float> volume, solid;
    std::vector<uint8_t> material;
    const std::vector<std::array<int, 2>> outside{{2, 0}, {0, 2}, {-1, 1}, {0, -1}, {1 << 30, 7}};
    soil->read_ahead(outside);
    for (const auto& [tx, ty] : outside) {
        soil->read_tile(0, 0, volume, solid, material);
        ASSERT_GT(*std::ranges::max_element(volume), 0);
        EXPECT_EQ(soil->tile_revision(tx, ty), 0u) << tx << ", " << ty;
        soil->read_tile(tx, ty, volume, solid, material);
        EXPECT_EQ(volume.size(), 64u * 16);
        EXPECT_EQ(*std::ranges::max_element(volume), 0) << tx << ", " << ty;
        soil->read_terrain(tx, ty, solid);
        EXPECT_EQ(*std::ranges::max_element(solid), 0) << tx << ", " << ty;
    }
}

TEST(ChooseBackend, takes_as_many_threads_as_a_soil_does) {
    for (const int count : {-1, 1025, std::numeric_limits<int>::max()}) {
        const auto chosen = choose_backend(Backend::cpu, count);
        ASSERT_FALSE(chosen) << count;
        EXPECT_NE(chosen.error().find("thread_count"), std::string::npos) << chosen.error();
    }
    EXPECT_TRUE(choose_backend(Backend::cpu, 1));
}

TEST(Terrain, a_closed_mesh_has_its_volume) {
    auto soil = make_soil(grid_def(16, 16, 16));
    ASSERT_TRUE(soil->add_terrain(box_mesh({0.12, 0.13, 0.41}, {0.52, 0.51, 0.63})));
    double volume = 0;
    for (int z = 0; z < 16; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) volume += soil->sample(x, y, z).coverage;
        }
    }
    // Two lines a voxel each way: a face lies up to a quarter of a voxel off, of 8 voxels' width.
    EXPECT_NEAR(volume * std::pow(0.05, 3), 0.40 * 0.38 * 0.22, 0.1 * 0.40 * 0.38 * 0.22);
}

}  // namespace
}  // namespace bsoil::hostile_input_test
