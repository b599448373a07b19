/* What the C interface refuses, and what it says then. */
#include "refusals.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "checks.h"
#include "test_world.h"

void the_other_precision_is_refused(void) {
    const bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil = NULL;
    void* world = test_world_create();
    const size_t other = 12 - test_world_scalar_bytes();
    CHECK_ERROR(bulletsoil_create(world, other, &def, &soil), BULLETSOIL_WRONG_PRECISION,
                other == 4 ? "4 bytes in the program and 8 in this library: link bulletsoil_bullet"
                           : "8 bytes in the program and 4 in this library: link "
                             "bulletsoil_bullet_double");
    CHECK(soil == NULL);
    test_world_destroy(world);
}

void bad_definitions_are_refused(void) {
    const size_t bytes = test_world_scalar_bytes();
    bulletsoil_soil_def def = small_def();
    bulletsoil_material materials[2];
    bulletsoil_soil* soil = NULL;
    void* world = test_world_create();
    void* simple = test_world_create_simple();

    CHECK_INVALID(bulletsoil_soil_def_init(NULL, sizeof def), "def is null");
    CHECK_INVALID(bulletsoil_soil_def_init(&def, 8), "def.struct_size is 8");
    CHECK_INVALID(bulletsoil_soil_def_init(&def, sizeof def + 8), "newer");
    CHECK_INVALID(bulletsoil_material_init(NULL, sizeof *materials, "clay"), "material is null");
    CHECK_INVALID(bulletsoil_material_init(materials, 0, "clay"), "material.struct_size is 0");
    CHECK_INVALID(bulletsoil_material_init(materials, sizeof *materials, NULL), "name is null");
    CHECK_INVALID(bulletsoil_material_init(materials, sizeof *materials, "cheese"), "dry_sand");

    CHECK_INVALID(bulletsoil_create(NULL, bytes, &def, &soil), "world is null");
    CHECK_INVALID(bulletsoil_create(world, bytes, NULL, &soil), "def is null");
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, NULL), "soil is null");
    CHECK_INVALID(bulletsoil_create(simple, bytes, &def, &soil), "btDiscreteDynamicsWorld");

#define CHECK_MEMBER(member, value, word)                                  \
    do {                                                                   \
        def = small_def();                                                 \
        def.member = (value);                                              \
        CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), word); \
        CHECK(soil == NULL);                                               \
    } while (0)
    CHECK_MEMBER(struct_size, 0, "def.struct_size is 0");
    CHECK_MEMBER(struct_size, sizeof def + 1, "newer");
    CHECK_MEMBER(size_m[0], -1, "size_m");
    CHECK_MEMBER(size_m[1], NAN, "size_m");
    CHECK_MEMBER(size_m[2], 1e30, "size_m");
    CHECK_MEMBER(floor_center_m[1], INFINITY, "floor_center_m");
    CHECK_MEMBER(yaw_rad, 100, "yaw_rad");
    CHECK_MEMBER(voxel_m, 0, "voxel_m");
    CHECK_MEMBER(gravity_m_s2, -1, "gravity_m_s2");
    CHECK_MEMBER(step_s, NAN, "step_s");
    CHECK_MEMBER(up, 2, "up");
    CHECK_MEMBER(up, -1, "up");
    CHECK_MEMBER(backend, 3, "backend");
    CHECK_MEMBER(thread_count, -1, "thread_count");
    CHECK_MEMBER(substeps_max, 0, "substeps_max");
    CHECK_MEMBER(tile_capacity, -1, "tile_capacity");
    CHECK_MEMBER(propagation_iterations, 65, "propagation_iterations");
    CHECK_MEMBER(overflow, BULLETSOIL_OVERFLOW_UP_SPREAD + 1, "overflow is 3, must be 0 to 2");
    CHECK_MEMBER(overflow_passes, 65, "overflow_passes is 65, must be 0 to 64");
    CHECK_MEMBER(contact_law, BULLETSOIL_CONTACT_WORK + 1, "contact_law.kind is 4, must be 0 to 3");
    CHECK_MEMBER(contact_law, BULLETSOIL_CONTACT_BEKKER,
                 "contact_law.bekker has 0 entries for 1 materials");
    CHECK_MEMBER(bekker_count, 1, "def.bekker is null");
    CHECK_MEMBER(reserved, 1, "def.reserved is 1");
    CHECK_MEMBER(reserved_2, 1, "def.reserved_2 is 1");
    CHECK_MEMBER(step_budget_ms, -1, "step_budget_ms");
    CHECK_MEMBER(step_spread_max, 1, "step_spread_max");
    CHECK_MEMBER(material_count, 1, "def.materials is null");

    CHECK_OK(bulletsoil_material_init(&materials[0], sizeof *materials, "clay"));
    CHECK_OK(bulletsoil_material_init(&materials[1], sizeof *materials, "loam"));
    def = small_def();
    def.materials = materials;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "material_count is 0");
    def.material_count = 9;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "material_count is 9");
    def.material_count = 2;
    materials[0].struct_size = sizeof *materials - 1;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "must be a multiple of 8");
    materials[0].struct_size = sizeof *materials;
    materials[1].struct_size = 0;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "materials[1].struct_size is 0");
    materials[1].struct_size = sizeof *materials;
    materials[1].name = NULL;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "material.name is null");
    materials[1].name = "clay";
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "two entries named 'clay'");
    materials[1].name = "loam";
    materials[1].reserved = 7;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "materials[1].reserved is 7");
    materials[1].reserved = 0;
    materials[1].cohesion_pa = -5;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "cohesion_pa");
    CHECK(soil == NULL);
    test_world_destroy(simple);
    test_world_destroy(world);
}

/* A struct of a later version's caller, or an earlier one's, is told by its size. */
void sizes_of_structs_are_kept(void) {
    struct {
        bulletsoil_body_report report;
        char canary[16];
    } out;
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    void* ball = test_world_add_ball(world, 100, 0.85);
    memset(&out, 0x5a, sizeof out);
    out.report.struct_size = 0;
    CHECK_INVALID(bulletsoil_get_body_report(soil, ball, &out.report), "report.struct_size is 0");
    out.report.struct_size = sizeof out;
    CHECK_INVALID(bulletsoil_get_body_report(soil, ball, &out.report), "newer");
    out.report.struct_size = sizeof out.report;
    CHECK_OK(bulletsoil_get_body_report(soil, ball, &out.report));
    CHECK(out.report.struct_size == sizeof out.report);
    CHECK(out.canary[0] == 0x5a && out.canary[15] == 0x5a);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

/* A program of before `overflow` was a member: nothing behind the struct it knows is read or
 * written. */
void shorter_definitions_get_defaults(void) {
    const size_t known = offsetof(bulletsoil_soil_def, overflow);
    void* world = test_world_create();
    bulletsoil_soil_def def = small_def(), full = small_def();
    CHECK(full.overflow == BULLETSOIL_OVERFLOW_UP);
    CHECK(full.overflow_passes == 4);
    def.overflow = def.overflow_passes = -7;
    CHECK_OK(bulletsoil_soil_def_init(&def, known));
    CHECK(def.struct_size == known);
    CHECK(def.overflow == -7 && def.overflow_passes == -7);
    def.backend = BULLETSOIL_BACKEND_CPU;
    CHECK_OK(bulletsoil_destroy(create(world, &def)));
    full.overflow = BULLETSOIL_OVERFLOW_EVEN;
    full.overflow_passes = 0;
    CHECK_OK(bulletsoil_destroy(create(world, &full)));
    test_world_destroy(world);
}

void bad_arguments_are_refused(void) {
    const double nan_m[3] = {0, NAN, 0}, outside_m[3] = {50, 0, 0}, inside_m[3] = {0, 0, 0};
    const float heights_m[4] = {0.2f, 0.2f, 0.2f, 0.2f}, nan_height_m[4] = {0, 0, NAN, 0};
    double height_m = 0;
    int64_t units = 0;
    size_t count = 0;
    char text[4];
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    void* ball = test_world_add_ball(world, 100, 0.85);
    const uint64_t before = checksum(soil);
    bulletsoil_body_report report = {sizeof report, {0}, {0}, 0, 0, 0, 0, 0, 0, {0}, {0}};

    CHECK_INVALID(bulletsoil_fill_box(soil, NULL, bed_max_m, NULL), "min_m is null");
    CHECK_INVALID(bulletsoil_fill_box(soil, bed_min_m, NULL, NULL), "max_m is null");
    CHECK_INVALID(bulletsoil_fill_box(soil, bed_max_m, bed_min_m, NULL), "min must be below max");
    CHECK_INVALID(bulletsoil_fill_box(soil, nan_m, bed_max_m, NULL), "box");
    CHECK_INVALID(bulletsoil_fill_box(soil, bed_min_m, bed_max_m, "cheese"), "'cheese'");
    CHECK_INVALID(bulletsoil_fill_cylinder(soil, NULL, 1, 1, NULL), "base_center_m is null");
    CHECK_INVALID(bulletsoil_fill_cylinder(soil, nan_m, 1, 1, NULL), "base_center_m");
    CHECK_INVALID(bulletsoil_fill_cylinder(soil, inside_m, -1, 1, NULL), "radius_m");
    CHECK_INVALID(bulletsoil_fill_cylinder(soil, inside_m, 1, NAN, NULL), "height_m");
    CHECK_INVALID(bulletsoil_fill_height_map(soil, 2, 2, NULL, NULL), "heights_m is null");
    CHECK_INVALID(bulletsoil_fill_height_map(soil, 1, 2, heights_m, NULL), "width is 1");
    CHECK_INVALID(bulletsoil_fill_height_map(soil, 2, -7, heights_m, NULL), "height is -7");
    CHECK_INVALID(bulletsoil_fill_height_map(soil, 2, 2147483647, heights_m, NULL), "height is 21");
    CHECK_INVALID(bulletsoil_fill_height_map(soil, 2, 2, nan_height_m, NULL), "heights_m");

    CHECK_INVALID(bulletsoil_set_body_ignored(soil, NULL, 1), "body is null");
    CHECK_INVALID(bulletsoil_set_body_surface(soil, NULL, 0.5, 0), "body is null");
    CHECK_INVALID(bulletsoil_set_body_surface(soil, ball, 2.5, 0), "friction is 2.5");
    CHECK_INVALID(bulletsoil_set_body_surface(soil, ball, NAN, 0), "friction");
    CHECK_INVALID(bulletsoil_set_body_surface(soil, ball, 0.5, 1e9), "adhesion_pa");
    CHECK_OK(bulletsoil_set_body_surface(soil, ball, 0.5, -1));
    CHECK_INVALID(bulletsoil_get_body_report(soil, NULL, &report), "body is null");
    CHECK_INVALID(bulletsoil_get_body_report(soil, ball, NULL), "report is null");

    CHECK_INVALID(bulletsoil_get_step_count(soil, NULL), "count is null");
    CHECK_INVALID(bulletsoil_get_material_count(soil, NULL), "count is null");
    CHECK_INVALID(bulletsoil_get_totals(soil, 0, &units, NULL), "capacity is 0");
    CHECK_INVALID(bulletsoil_get_checksum(soil, NULL), "checksum is null");
    CHECK_INVALID(bulletsoil_get_surface_height(soil, NULL, &height_m), "point_m is null");
    CHECK_INVALID(bulletsoil_get_surface_height(soil, inside_m, NULL), "height_m is null");
    CHECK_INVALID(bulletsoil_get_surface_height(soil, outside_m, &height_m), "point_m is (50");
    CHECK_INVALID(bulletsoil_get_status_text(soil, NULL, 4, NULL), "buffer is null");
    CHECK_INVALID(bulletsoil_get_condition_count(soil, NULL), "count is null");
    CHECK_INVALID(bulletsoil_get_condition(soil, 0, NULL), "condition is null");
    CHECK_INVALID(bulletsoil_save(soil, NULL), "path is null");
    CHECK_INVALID(bulletsoil_load(soil, NULL), "path is null");
    CHECK(checksum(soil) == before);

    CHECK_OK(bulletsoil_destroy(NULL));
    CHECK_OK(bulletsoil_destroy(soil));
#define CHECK_HANDLES(handle, word)                                                       \
    do {                                                                                  \
        CHECK_INVALID(bulletsoil_fill_box(handle, bed_min_m, bed_max_m, NULL), word);     \
        CHECK_INVALID(bulletsoil_fill_cylinder(handle, inside_m, 1, 1, NULL), word);      \
        CHECK_INVALID(bulletsoil_fill_height_map(handle, 2, 2, heights_m, NULL), word);   \
        CHECK_INVALID(bulletsoil_set_body_ignored(handle, ball, 1), word);                \
        CHECK_INVALID(bulletsoil_set_body_coverage_only(handle, ball, 1), word);          \
        CHECK_INVALID(bulletsoil_set_enabled(handle, 1), word);                           \
        CHECK_INVALID(bulletsoil_set_body_surface(handle, ball, 0.5, 0), word);           \
        CHECK_INVALID(bulletsoil_get_body_report(handle, ball, &report), word);           \
        CHECK_INVALID(bulletsoil_get_step_count(handle, &units), word);                   \
        CHECK_INVALID(bulletsoil_get_material_count(handle, &count), word);               \
        CHECK_INVALID(bulletsoil_get_totals(handle, 1, &units, NULL), word);              \
        CHECK_INVALID(bulletsoil_get_checksum(handle, (uint64_t*)&units), word);          \
        CHECK_INVALID(bulletsoil_get_surface_height(handle, inside_m, &height_m), word);  \
        CHECK_INVALID(bulletsoil_get_status_text(handle, text, sizeof text, NULL), word); \
        CHECK_INVALID(bulletsoil_clear_status(handle), word);                             \
        CHECK_INVALID(bulletsoil_save(handle, "x"), word);                                \
        CHECK_INVALID(bulletsoil_load(handle, "x"), word);                                \
    } while (0)
    CHECK_HANDLES(NULL, "soil is null");
    CHECK_HANDLES(soil, "soil is no living soil");
    CHECK_INVALID(bulletsoil_destroy(soil), "soil is no living soil");
    CHECK_INVALID(bulletsoil_get_step_count((bulletsoil_soil*)world, &units), "no living soil");
    test_world_destroy(world);
}

void another_gravity_than_the_worlds_is_refused(void) {
    void* world = test_world_create();
    bulletsoil_soil_def def;
    bulletsoil_soil* soil = NULL;
    CHECK_OK(bulletsoil_soil_def_init(&def, sizeof def));
    def.up = BULLETSOIL_UP_Z;
    CHECK_INVALID(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil), "up is z");
    def.up = BULLETSOIL_UP_Y;
    def.gravity_m_s2 = 3.7;
    CHECK_INVALID(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil),
                  "gravity_m_s2 is 3.7");
    test_world_destroy(world);
}
