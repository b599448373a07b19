// Another definition while the soil runs: what it refuses, and that a soil that was changed is the
// soil that would have been made so.
#include <cmath>
#include <functional>
#include <numbers>

#include "bsoil/snapshot_file.h"
#include "soil/def_fields.h"
#include "soil_fixture.h"

namespace bsoil::change_test {
namespace {

/// Sand and a moist loam with all that a material can have, on a grid of 40 x 40 x 24 voxels.
SoilDef rich_def() {
    SoilDef def = grid_def(40, 40, 24);
    def.backend = Backend::cpu;
    def.thread_count = 1;
    MaterialDef loam = materials::loam();
    loam.pore_water_fraction = 0.2;
    loam.placed_saturation = 0.5;
    loam.moist_cohesion_pa = 500;
    loam.conductivity_m_s = 1e-3;
    def.materials = {materials::dry_sand(), loam};
    return def;
}

/// A bed of loam, a tower of sand on it and a block of loam that stands, a box that ploughs.
struct Field {
    std::unique_ptr<Soil> soil;
    std::vector<Mover> movers;

    explicit Field(const SoilDef& def) : soil(make_soil(def)) {
        movers.emplace_back(1, box_shape({0.15, 0.3, 0.2}), Vec3{0.4, 1, 0.35});
        movers[0].set_velocity({0.8, 0, 0});
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {40, 40, 6}, "loam")));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {24, 16, 6}, {32, 28, 16}, "dry_sand")));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {4, 28, 6}, {12, 36, 14}, "loam")));
        SourceDef source;
        source.center_m = {1.5, 0.4, 1};
        source.radius_m = 0.2;
        source.rate_kg_s = 20;
        source.material = "loam";
        EXPECT_TRUE(soil->add_source(source)) << "source";
    }
    void run(int steps) {
        for (int i = 0; i < steps; ++i) {
            movers[0].advance(1.0 / 60);
            soil->step(bodies_of(movers));
        }
    }
};

/// A change of a definition, and the field that it changes.
struct Change {
    std::string name;
    FieldUse use = FieldUse::state;
    std::function<void(SoilDef&)> make;
};

template <typename Number>
void nudge(Number& number, double least, double most) {
    if constexpr (std::is_same_v<Number, Vec3>) {
        number.x += 0.5;
    } else {
        // A tenth of the range further, down from its upper half. Cohesions and rates have ranges
        // far beyond what soils have.
        const double now = static_cast<double>(number), way = most > least ? most - least : 1;
        const double step = std::min(0.1 * way, std::max(1.0, std::abs(now)));
        const double to = now + (now - least < way / 2 ? step : -step);
        number = static_cast<Number>(std::is_integral_v<Number> || std::is_enum_v<Number>
                                         ? (to > now ? now + 1 : now - 1)
                                         : to);
    }
}

/// One for each number of a definition and of its second material.
std::vector<Change> all_changes() {
    std::vector<Change> out;
#define BSOIL_ADD(field, least, most, use, ...) \
    out.push_back({#field, FieldUse::use, [](SoilDef& def) { nudge(def.field, least, most); }});
    BSOIL_SOIL_FIELDS(BSOIL_ADD)
#undef BSOIL_ADD
#define BSOIL_ADD(field, least, most, use, ...)                 \
    out.push_back({#field " of material 'loam'", FieldUse::use, \
                   [](SoilDef& def) { nudge(def.materials[1].field, least, most); }});
    BSOIL_MATERIAL_FIELDS(BSOIL_ADD)
#undef BSOIL_ADD
    return out;
}

TEST(SoilChange, refuses_what_cannot_differ_and_says_it) {
    Field field(rich_def());
    const std::vector<uint8_t> before = field.soil->state();
    int refused = 0;
    const auto expect_refused = [&](const SoilDef& def, const std::string& text) {
        const Status status = field.soil->change(def);
        ASSERT_FALSE(status) << text;
        EXPECT_NE(status.error().find(text), std::string::npos) << status.error();
        ++refused;
    };
    for (const Change& change : all_changes()) {
        if (change.use == FieldUse::live || change.use == FieldUse::pace) continue;
        SoilDef def = rich_def();
        if (change.name == "open_sides") {
            def.open_sides = kOpenLowX;
        } else if (change.name == "size_m") {
            def.size_m.x += 1;
        } else {
            change.make(def);
        }
        if (!def.validate()) continue;  // of densities: below
        expect_refused(def, change.name);
    }
    EXPECT_GE(refused, 12);
    SoilDef def = rich_def();
    def.materials[0].density_kg_m3 += 1;
    expect_refused(def, "density_kg_m3 of material 'dry_sand' is 1601, this soil has 1600");
    def = rich_def();
    def.materials[1].loose_density_kg_m3 += 1;
    expect_refused(def, "loose_density_kg_m3 of material 'loam'");
    def = rich_def();
    std::swap(def.materials[0], def.materials[1]);
    expect_refused(def, "names");
    def = rich_def();
    def.materials.pop_back();
    expect_refused(def, "names");
    def = rich_def();
    def.contact_law.trapped_soil = false;
    expect_refused(def, "contact_law");
    def = rich_def();
    def.materials[0].cohesion_pa = -1;
    expect_refused(def, "cohesion_pa");
    EXPECT_EQ(field.soil->def_revision(), 0u);
    EXPECT_EQ(field.soil->state(), before);
}

// The smallest promise and the strongest: a change before the first step leaves nothing of the
// definition before.
TEST(SoilChange, leaves_the_soil_that_would_have_been_made_so) {
    Field plain(rich_def());
    plain.run(12);
    int other_count = 0;
    for (const Change& change : all_changes()) {
        // What a fill puts in with the soil: a change comes too late for that.
        if (change.use != FieldUse::live || change.name == "water_table_m" ||
            change.name.starts_with("placed_saturation")) {
            continue;
        }
        SoilDef def = rich_def();
        change.make(def);
        ASSERT_TRUE(def.validate()) << change.name << ": " << def.validate().error();
        Field made(def), changed(rich_def());
        const Status status = changed.soil->change(def);
        ASSERT_TRUE(status) << status.error();
        EXPECT_EQ(changed.soil->def_revision(), 1u) << change.name;
        made.run(12);
        changed.run(12);
        EXPECT_EQ(changed.soil->checksum(), made.soil->checksum()) << change.name;
        other_count += made.soil->checksum() != plain.soil->checksum();
    }
    EXPECT_GE(other_count, 10) << "hardly any field is felt by this soil";
}

TEST(SoilChange, and_back_again_leaves_no_trace) {
    Field through(rich_def()), there_and_back(rich_def());
    SoilDef other = rich_def();
    other.materials[0].friction_angle_rad = 0.2;
    other.materials[1].cohesion_pa = 0;
    other.wind_m_s = {3, 0, 0};
    for (int i = 0; i < 5; ++i) {
        through.run(8);
        there_and_back.run(8);
        ASSERT_TRUE(there_and_back.soil->change(other));
        ASSERT_TRUE(there_and_back.soil->change(rich_def()));
        EXPECT_EQ(there_and_back.soil->checksum(), through.soil->checksum()) << i;
    }
    EXPECT_EQ(there_and_back.soil->def_revision(), 10u);
}

/// Half-way through a run the loam loses its cohesion and the sand its friction.
SoilDef weak_def() {
    SoilDef def = rich_def();
    def.materials[0].friction_angle_rad = 0.3;
    def.materials[1].cohesion_pa = def.materials[1].moist_cohesion_pa = 0;
    def.materials[1].color = {1, 0, 0};
    def.rain_m_s = 1e-4;
    return def;
}

TEST(SoilChange, is_the_same_on_any_number_of_threads_and_on_gl) {
    const auto run = [](Backend backend, int threads) {
        SoilDef def = rich_def();
        def.backend = backend;
        def.thread_count = threads;
        Field field(def);
        field.run(15);
        SoilDef weak = weak_def();
        weak.backend = backend;
        weak.thread_count = threads;
        EXPECT_TRUE(field.soil->change(weak));
        field.run(15);
        return field.soil->checksum();
    };
    const uint64_t one = run(Backend::cpu, 1);
    EXPECT_EQ(run(Backend::cpu, 2), one);
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    EXPECT_EQ(run(Backend::gl, 1), one);
}

TEST(SoilChange, goes_on_bit_for_bit_from_a_snapshot) {
    Field through(rich_def());
    through.run(15);
    ASSERT_TRUE(through.soil->change(weak_def()));
    const std::vector<uint8_t> saved = through.soil->state();
    const SoilBody there = through.movers[0].body;
    through.run(15);

    Field first(rich_def());  // of the definition before: it says what differs
    const auto refused = first.soil->prepare(saved);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("is of a soil with"), std::string::npos) << refused.error();

    Field again(weak_def());
    const auto put = again.soil->prepare(saved);
    ASSERT_TRUE(put) << put.error();
    (*put)();
    again.movers[0].body.pose = there.pose;
    again.run(15);
    EXPECT_EQ(again.soil->checksum(), through.soil->checksum());
}

/// The slope of a heap from its foot to its top [deg], by the heights of the middle row.
double slope_deg(const Soil& soil, int row) {
    double steepest = 0;
    constexpr int kOver = 6;
    for (int x = 0; x + kOver < soil.frame().size[0]; ++x) {
        const double rise = soil.surface_height_m(x + kOver, row) - soil.surface_height_m(x, row);
        steepest = std::max(steepest, std::abs(rise) / (kOver * soil.frame().voxel_m));
    }
    return std::atan(steepest) * 180 / std::numbers::pi;
}

// All of it sleeps when it is changed.
TEST(SoilChange, a_heap_at_rest_comes_down_to_its_new_angle) {
    SoilDef def = grid_def(64, 16, 40);
    def.backend = Backend::cpu;
    def.material = sand(36);
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {20, 0, 0}, {44, 16, 20})));
    ASSERT_TRUE(soil->settle(3000)->is_at_rest);
    EXPECT_NEAR(slope_deg(*soil, 8), 36, 2.5);
    ASSERT_EQ(soil->settle(0)->tile_awake_count, 0);
    def.material = sand(24);
    ASSERT_TRUE(soil->change(def));
    const auto settled = soil->settle(3000);
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_GT(settled->step_count, 10);
    EXPECT_NEAR(slope_deg(*soil, 8), 24, 2.5);
    def.material = sand(40);  // what lies flatter than it could does not move
    const uint64_t before = soil->checksum();
    ASSERT_TRUE(soil->change(def));
    EXPECT_TRUE(soil->settle(3000)->is_at_rest);
    EXPECT_EQ(soil->checksum(), before);
}

// A cut of 0.8 m in loam of 6 kPa stands (Hc = 2.0 m); without its cohesion it cannot.
TEST(SoilChange, a_bank_falls_when_it_loses_its_cohesion) {
    SoilDef def = grid_def(48, 16, 24);
    def.backend = Backend::cpu;
    def.material = materials::loam();
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {20, 16, 16})));
    ASSERT_TRUE(soil->settle(600)->is_at_rest);
    EXPECT_NEAR(soil->surface_height_m(19, 8), 0.8, 1e-9);
    def.material.cohesion_pa = 0;
    ASSERT_TRUE(soil->change(def));
    ASSERT_TRUE(soil->settle(3000)->is_at_rest);
    EXPECT_LT(soil->surface_height_m(19, 8), 0.6);
    EXPECT_LT(slope_deg(*soil, 8), 28);
}

TEST(SoilChange, of_a_colour_alone_is_a_new_mesh_and_no_new_step) {
    SoilDef def = grid_def(16, 16, 16);
    def.backend = Backend::cpu;
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {16, 16, 4})));
    ASSERT_TRUE(soil->settle(10)->is_at_rest);
    const uint64_t revision = soil->tile_revision(0, 0);
    ASSERT_TRUE(soil->change(def));
    EXPECT_EQ(soil->def_revision(), 0u);
    EXPECT_EQ(soil->tile_revision(0, 0), revision);
    def.material.color = {1, 0, 0};
    ASSERT_TRUE(soil->change(def));
    EXPECT_GT(soil->tile_revision(0, 0), revision);
    EXPECT_EQ(soil->settle(10)->step_count, 0);
    EXPECT_EQ(soil->materials()[0].color[1], 0);
}

}  // namespace
}  // namespace bsoil::change_test
