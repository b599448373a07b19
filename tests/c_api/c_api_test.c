/* The C interface, from C: c_api_test CASE runs one of the functions named at the end. */
#include <bsoil/c/bulletsoil.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "test_world.h"

/* Fails the program; `what` is the condition's text. */
static void check(int condition, const char* what, int line) {
    if (condition) return;
    fprintf(stderr, "line %d: %s\nlast error: %s\n", line, what, bulletsoil_last_error());
    exit(1);
}
#define CHECK(condition) check((condition) != 0, #condition, __LINE__)
#define CHECK_OK(call) check((call) == BULLETSOIL_OK, #call, __LINE__)

/* A failure with a text that has `word` in it. */
static void check_error(bulletsoil_result found, bulletsoil_result expected, const char* word,
                        const char* what, int line) {
    check(found == expected, what, line);
    if (strstr(bulletsoil_last_error(), word) != NULL) return;
    fprintf(stderr, "'%s' is not in the text of the error\n", word);
    check(0, what, line);
}
#define CHECK_ERROR(call, code, word) check_error((call), (code), (word), #call, __LINE__)
#define CHECK_INVALID(call, word) CHECK_ERROR(call, BULLETSOIL_INVALID_ARGUMENT, word)

static bulletsoil_soil_def small_def(void) {
    bulletsoil_soil_def def;
    CHECK_OK(bulletsoil_soil_def_init(&def, sizeof def));
    def.size_m[0] = 2;
    def.size_m[1] = 1;
    def.size_m[2] = 2;
    def.backend = BULLETSOIL_BACKEND_CPU;
    return def;
}

static bulletsoil_soil* create(void* world, const bulletsoil_soil_def* def) {
    bulletsoil_soil* soil = NULL;
    CHECK_OK(bulletsoil_create(world, test_world_scalar_bytes(), def, &soil));
    CHECK(soil != NULL);
    return soil;
}

static const double bed_min_m[3] = {-1, 0, -1}, bed_max_m[3] = {1, 0.5, 1};

/* A bed of sand of 2 x 0.5 x 2 m under a world. */
static bulletsoil_soil* create_bed(void* world) {
    const bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil = create(world, &def);
    CHECK_OK(bulletsoil_fill_box(soil, bed_min_m, bed_max_m, "dry_sand"));
    return soil;
}

static uint64_t checksum(const bulletsoil_soil* soil) {
    uint64_t out = 0;
    CHECK_OK(bulletsoil_get_checksum(soil, &out));
    return out;
}

static double surface_height_m(const bulletsoil_soil* soil, double x_m, double z_m) {
    const double point_m[3] = {x_m, 0, z_m};
    double out = -1;
    CHECK_OK(bulletsoil_get_surface_height(soil, point_m, &out));
    return out;
}

static void versions(void) {
    int major, minor, patch;
    CHECK(sscanf(bulletsoil_version(), "%d.%d.%d", &major, &minor, &patch) == 3);
    CHECK(bulletsoil_version_number() == major * 10000 + minor * 100 + patch);
    CHECK(bulletsoil_scalar_bytes() == test_world_scalar_bytes());
    CHECK(strcmp(bulletsoil_last_error(), "") == 0);
}

/* 100 kg of ball lie on the sand: what Newton says the sand has to bear. */
static void a_ball_rests_on_sand(void) {
    const double mass_kg = 100, weight_n = mass_kg * 9.81;
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    void* ball = test_world_add_ball(world, mass_kg, 0.85);
    int64_t steps = -1, units_before = 0, units_after = 0;
    double mass_before_kg = 0;
    bulletsoil_body_report report = {sizeof report, {0}, {0}, 0, 0, 0, 0, 0, 0};

    CHECK_OK(bulletsoil_get_totals(soil, 1, &units_before, &mass_before_kg));
    CHECK(fabs(mass_before_kg - 2 * 0.5 * 2 * 1600) < 1);
    CHECK(fabs(surface_height_m(soil, 0, 0) - 0.5) < 0.01);
    CHECK_OK(bulletsoil_get_body_report(soil, ball, &report));
    CHECK(!report.is_in_contact && report.force_n[1] == 0);

    test_world_step(world, 150);
    CHECK_OK(bulletsoil_get_step_count(soil, &steps));
    CHECK(steps == 150);
    CHECK_OK(bulletsoil_get_body_report(soil, ball, &report));
    CHECK(report.is_in_contact && report.contact_patch_count > 0);
    CHECK(fabs(report.force_n[1] - weight_n) < 0.02 * weight_n);
    CHECK(report.peak_force_n > report.force_n[1]); /* it fell */
    CHECK(report.sinkage_m > 0 && report.sinkage_m < 0.3);
    CHECK(surface_height_m(soil, 0, 0) < 0.5);
    CHECK_OK(bulletsoil_get_totals(soil, 1, &units_after, NULL));
    CHECK(units_after == units_before);
    CHECK_OK(bulletsoil_destroy(soil));

    test_world_step(world, 30); /* nothing is left of the soil: the ball falls on */
    test_world_destroy(world);
}

static void an_ignored_ball_falls_through(void) {
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    void* ball = test_world_add_ball(world, 100, 0.85);
    bulletsoil_body_report report = {sizeof report, {0}, {0}, 0, 0, 0, 0, 0, 0};
    const uint64_t before = checksum(soil);
    CHECK_OK(bulletsoil_set_body_ignored(soil, ball, 1));
    test_world_step(world, 30);
    CHECK_OK(bulletsoil_get_body_report(soil, ball, &report));
    CHECK(!report.is_in_contact);
    CHECK(checksum(soil) == before);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

static void a_body_that_only_covers_feels_nothing(void) {
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    void* ball = test_world_add_ball(world, 100, 0.85);
    const uint64_t before = checksum(soil);
    CHECK_OK(bulletsoil_set_body_coverage_only(soil, ball, 1));
    CHECK_OK(bulletsoil_set_enabled(soil, 0));
    test_world_step(world, 10);
    CHECK(checksum(soil) == before); /* frozen */
    CHECK_OK(bulletsoil_set_enabled(soil, 1));
    test_world_step(world, 20);
    CHECK(checksum(soil) != before); /* it gave way */
    CHECK(test_world_ball_y(ball) <
          0.85 - 0.9 * 0.5 * 9.81 * 0.5 * 0.5); /* half a second of fall */
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

static void fills_hold_what_they_should(void) {
    const double pi = 3.14159265358979;
    const double base_m[3] = {0.5, 0, 0.5};
    const float slope_m[4] = {0.2f, 0.4f, 0.2f, 0.4f}; /* rises along one side by 0.2 m */
    bulletsoil_material two[2];
    bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil;
    void* world = test_world_create();
    double mass_kg[2] = {0};
    size_t count = 0;

    CHECK_OK(bulletsoil_material_init(&two[0], sizeof two[0], "clay"));
    CHECK_OK(bulletsoil_material_init(&two[1], sizeof two[1], "dry_sand"));
    two[1].name = "my_sand";
    two[1].density_kg_m3 = 1500;
    two[1].loose_density_kg_m3 = two[1].compacted_density_kg_m3 = 0;
    def.materials = two;
    def.material_count = 2;
    soil = create(world, &def);
    CHECK_OK(bulletsoil_get_material_count(soil, &count));
    CHECK(count == 2);
    CHECK_OK(bulletsoil_fill_cylinder(soil, base_m, 0.3, 0.4, "my_sand"));
    CHECK_OK(bulletsoil_get_totals(soil, 2, NULL, mass_kg));
    /* sub-cells of a third of a voxel along the rim: within 2 % of the area */
    CHECK(fabs(mass_kg[1] - pi * 0.3 * 0.3 * 0.4 * 1500) < 0.02 * mass_kg[1]);
    CHECK(mass_kg[0] == 0);
    CHECK(fabs(surface_height_m(soil, 0.5, 0.5) - 0.4) < 0.01);
    CHECK_OK(bulletsoil_destroy(soil));

    def.materials = NULL;
    def.material_count = 0;
    soil = create(world, &def);
    CHECK_OK(bulletsoil_fill_height_map(soil, 2, 2, slope_m, NULL)); /* null: the first material */
    CHECK_OK(bulletsoil_get_totals(soil, 1, NULL, mass_kg));
    CHECK(fabs(mass_kg[0] - 2 * 2 * 0.3 * 1600) < 0.02 * mass_kg[0]);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

static void a_snapshot_brings_the_soil_back(void) {
    static const char path[] = "c_api_test.snapshot";
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    uint64_t before, after;
    test_world_add_ball(world, 100, 0.85);
    before = checksum(soil);
    CHECK_OK(bulletsoil_save(soil, path));
    test_world_step(world, 60);
    after = checksum(soil);
    CHECK(after != before);
    CHECK_OK(bulletsoil_load(soil, path));
    CHECK(checksum(soil) == before);
    CHECK(remove(path) == 0);
    CHECK_ERROR(bulletsoil_load(soil, path), BULLETSOIL_FAILED, path);
    CHECK_ERROR(bulletsoil_save(soil, "no/such/folder/x"), BULLETSOIL_FAILED, "no/such/folder/x");
    CHECK(checksum(soil) == before);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

static void status_names_refused_bodies(void) {
    char text[512], little[8];
    size_t needed = 0;
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    CHECK_OK(bulletsoil_get_status_text(soil, text, sizeof text, &needed));
    CHECK(strcmp(text, "") == 0 && needed == 1);
    test_world_add_empty(world);
    test_world_step(world, 2);
    CHECK_OK(bulletsoil_get_status_text(soil, NULL, 0, &needed));
    CHECK(needed > sizeof little && needed < sizeof text);
    CHECK_OK(bulletsoil_get_status_text(soil, text, sizeof text, NULL));
    CHECK(strlen(text) + 1 == needed && strstr(text, "Empty") != NULL);
    CHECK_OK(bulletsoil_get_status_text(soil, little, sizeof little, NULL));
    CHECK(strlen(little) == sizeof little - 1 && strncmp(little, text, sizeof little - 1) == 0);
    CHECK_OK(bulletsoil_clear_status(soil));
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

static void conditions_name_body_place_and_step(void) {
    char text[512];
    size_t count = 99;
    bulletsoil_condition condition;
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    void* ball;
    CHECK_OK(bulletsoil_get_condition_count(soil, &count));
    CHECK(count == 0);
    condition.struct_size = sizeof condition;
    CHECK_INVALID(bulletsoil_get_condition(soil, 0, &condition), "index is 0, there are 0");
    ball = test_world_add_ball(world, 10, 0.8);
    test_world_step(world, 2);
    test_world_move_ball(ball, 0.6, 0.0); /* 12 voxels: more than substeps_max */
    test_world_step(world, 1);
    CHECK_OK(bulletsoil_get_condition_count(soil, &count));
    CHECK(count == 1);
    CHECK_OK(bulletsoil_get_condition(soil, 0, &condition));
    CHECK(condition.struct_size == sizeof condition);
    CHECK(condition.body == ball && condition.status_bit == 4 && condition.has_position == 1);
    CHECK(condition.position_m[0] > 0.59 && condition.position_m[0] < 0.61);
    CHECK(condition.first_step == 3 && condition.last_step == 3 && condition.step_count == 1);
    CHECK(strncmp(condition.text, "body_teleported: ", 17) == 0);
    CHECK_OK(bulletsoil_get_status_text(soil, text, sizeof text, NULL));
    CHECK(strstr(text, "step 3") != NULL);
    condition.struct_size = 4;
    CHECK_INVALID(bulletsoil_get_condition(soil, 0, &condition), "struct_size is 4");
    CHECK_OK(bulletsoil_clear_status(soil));
    CHECK_OK(bulletsoil_get_condition_count(soil, &count));
    CHECK(count == 0);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

static void the_other_precision_is_refused(void) {
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

static void bad_definitions_are_refused(void) {
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
    CHECK_MEMBER(contact_law, BULLETSOIL_CONTACT_PLAIN + 1,
                 "contact_law.kind is 3, must be 0 to 2");
    CHECK_MEMBER(reserved, 1, "def.reserved is 1");
    CHECK_MEMBER(material_count, 1, "def.materials is null");

    CHECK_OK(bulletsoil_material_init(&materials[0], sizeof *materials, "clay"));
    CHECK_OK(bulletsoil_material_init(&materials[1], sizeof *materials, "loam"));
    def = small_def();
    def.materials = materials;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "material_count is 0");
    def.material_count = 9;
    CHECK_INVALID(bulletsoil_create(world, bytes, &def, &soil), "material_count is 9");
    def.material_count = 2;
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
static void sizes_of_structs_are_kept(void) {
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
static void shorter_definitions_get_defaults(void) {
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

static void bad_arguments_are_refused(void) {
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
    bulletsoil_body_report report = {sizeof report, {0}, {0}, 0, 0, 0, 0, 0, 0};

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

static void settling_brings_a_heap_to_rest(void) {
    const double heap_min_m[3] = {-0.2, 0.5, -0.2}, heap_max_m[3] = {0.2, 0.8, 0.2};
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    bulletsoil_settle_report report = {sizeof report, -1, -1, -1, -1};
    int64_t steps = -1, units_before = 0, units_after = 0;

    CHECK_OK(bulletsoil_fill_box(soil, heap_min_m, heap_max_m, NULL));
    CHECK_OK(bulletsoil_get_totals(soil, 1, &units_before, NULL));
    CHECK_OK(bulletsoil_settle(soil, 0, &report));
    CHECK(!report.is_at_rest && report.step_count == 0 && report.block_active_count > 0);
    CHECK_OK(bulletsoil_settle(soil, 3000, NULL));
    CHECK_OK(bulletsoil_settle(soil, 1, &report));
    CHECK(report.is_at_rest && report.step_count == 0 && report.block_active_count == 0);
    CHECK(report.tile_awake_count == 0);
    CHECK_OK(bulletsoil_get_step_count(soil, &steps));
    CHECK(steps > 10);
    CHECK_OK(bulletsoil_get_totals(soil, 1, &units_after, NULL));
    CHECK(units_after == units_before);
    CHECK_INVALID(bulletsoil_settle(NULL, 0, NULL), "soil is null");
    CHECK_INVALID(bulletsoil_settle(soil, -1, NULL), "steps_max is -1");
    report.struct_size = 3;
    CHECK_INVALID(bulletsoil_settle(soil, 1, &report), "report.struct_size is 3");
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

static void soil_is_poured_and_taken_to_the_unit(void) {
    void* world = test_world_create();
    bulletsoil_soil_def def = small_def();
    bulletsoil_source source;
    bulletsoil_sink sink;
    bulletsoil_soil* soil;
    int64_t units = -1, in = -1, out = -1;
    int32_t source_id = 0, sink_id = 0;
    double mass_kg = -1;
    def.open_sides = 1;
    soil = create(world, &def);
    CHECK_OK(bulletsoil_source_init(&source, sizeof source));
    CHECK_INVALID(bulletsoil_add_source(soil, &source, NULL), "one of them must be above 0");
    source.center_m[1] = 1;
    source.radius_m = 0.2;
    source.rate_kg_s = 40;
    CHECK_OK(bulletsoil_add_source(soil, &source, &source_id));
    CHECK_OK(bulletsoil_sink_init(&sink, sizeof sink));
    sink.size_m[1] = 0.2;
    CHECK_OK(bulletsoil_add_sink(soil, &sink, &sink_id));
    CHECK(source_id > 0 && sink_id > source_id);
    CHECK_OK(bulletsoil_settle(soil, 60, NULL));
    CHECK_OK(bulletsoil_get_totals(soil, 1, &units, NULL));
    CHECK_OK(bulletsoil_get_flow_totals(soil, 1, &in, &out));
    CHECK(in > 0 && out > 0 && units == in - out);
    CHECK_OK(bulletsoil_get_flow_mass(soil, source_id, &mass_kg));
    CHECK(fabs(mass_kg - 40) < 0.7); /* a step's part may wait */
    CHECK_OK(bulletsoil_remove_flow(soil, source_id));
    CHECK_INVALID(bulletsoil_remove_flow(soil, source_id), "there is no source or sink");
    CHECK_INVALID(bulletsoil_get_flow_mass(soil, 77, &mass_kg), "there is no source or sink 77");
    CHECK_INVALID(bulletsoil_get_flow_totals(soil, 0, &in, &out), "capacity is 0");
    CHECK_INVALID(bulletsoil_add_source(soil, NULL, NULL), "source is null");
    sink.rotation[3] = 0;
    CHECK_INVALID(bulletsoil_add_sink(soil, &sink, NULL), "unit quaternion");
    sink.rotation[3] = 1;
    sink.shape = 2;
    CHECK_INVALID(bulletsoil_add_sink(soil, &sink, NULL), "sink.shape is 2");
    sink.struct_size = 5;
    CHECK_INVALID(bulletsoil_add_sink(soil, &sink, NULL), "sink.struct_size is 5");
    CHECK_OK(bulletsoil_destroy(soil));
    def.open_sides = 4;
    CHECK_INVALID(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil), "open_sides");
    test_world_destroy(world);
}

static void another_gravity_than_the_worlds_is_refused(void) {
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

static void the_world_may_go_first(void) {
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    const uint64_t before = checksum(soil);
    test_world_destroy(world);
    CHECK(checksum(soil) == before);
    CHECK_OK(bulletsoil_destroy(soil));
}

static const struct {
    const char* name;
    void (*run)(void);
} cases[] = {
    {"versions", versions},
    {"a_ball_rests_on_sand", a_ball_rests_on_sand},
    {"an_ignored_ball_falls_through", an_ignored_ball_falls_through},
    {"a_body_that_only_covers_feels_nothing", a_body_that_only_covers_feels_nothing},
    {"fills_hold_what_they_should", fills_hold_what_they_should},
    {"a_snapshot_brings_the_soil_back", a_snapshot_brings_the_soil_back},
    {"status_names_refused_bodies", status_names_refused_bodies},
    {"conditions_name_body_place_and_step", conditions_name_body_place_and_step},
    {"the_other_precision_is_refused", the_other_precision_is_refused},
    {"bad_definitions_are_refused", bad_definitions_are_refused},
    {"sizes_of_structs_are_kept", sizes_of_structs_are_kept},
    {"shorter_definitions_get_defaults", shorter_definitions_get_defaults},
    {"bad_arguments_are_refused", bad_arguments_are_refused},
    {"the_world_may_go_first", the_world_may_go_first},
    {"settling_brings_a_heap_to_rest", settling_brings_a_heap_to_rest},
    {"soil_is_poured_and_taken_to_the_unit", soil_is_poured_and_taken_to_the_unit},
    {"another_gravity_than_the_worlds_is_refused", another_gravity_than_the_worlds_is_refused},
};

int main(int argument_count, char** arguments) {
    size_t i;
    for (i = 0; i < sizeof cases / sizeof *cases; ++i) {
        if (argument_count == 2 && strcmp(arguments[1], cases[i].name) == 0) {
            cases[i].run();
            return 0;
        }
    }
    fprintf(stderr, "usage: %s CASE\n", arguments[0]);
    return 2;
}
