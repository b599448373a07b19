/* The C interface, from C: c_api_test CASE runs one of the functions named at the end. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "checks.h"
#include "flows.h"
#include "refusals.h"
#include "test_world.h"

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
    bulletsoil_body_report report = {sizeof report, {0}, {0}, 0, 0, 0, 0, 0, 0, {0}, {0}};

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
    CHECK(report.through_load_n[1] == 0); /* nothing stands on it */
    CHECK(report.peak_force_n > report.force_n[1]); /* it fell */
    CHECK(report.sinkage_m > 0 && report.sinkage_m < 0.3);
    CHECK(surface_height_m(soil, 0, 0) < 0.5);
    CHECK_OK(bulletsoil_get_totals(soil, 1, &units_after, NULL));
    CHECK(units_after == units_before);
    CHECK_OK(bulletsoil_destroy(soil));

    test_world_step(world, 30); /* nothing is left of the soil: the ball falls on */
    test_world_destroy(world);
}

/* The same ball on sand that answers by Bekker's parameters; then by stiffer ones. */
static double sinkage_by_law(int32_t law, double kphi_pa_m_n) {
    const bulletsoil_bekker sand = {kphi_pa_m_n, 990, 1.1, 1040, 0.4887, 0.01};
    void* world = test_world_create();
    bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil;
    void* ball = test_world_add_ball(world, 100, 0.85);
    bulletsoil_body_report report = {sizeof report, {0}, {0}, 0, 0, 0, 0, 0, 0, {0}, {0}};
    def.contact_law = law;
    def.bekker = &sand;
    def.bekker_count = 1;
    soil = create(world, &def);
    CHECK_OK(bulletsoil_fill_box(soil, bed_min_m, bed_max_m, "dry_sand"));
    test_world_step(world, 150);
    CHECK_OK(bulletsoil_get_body_report(soil, ball, &report));
    /* it rocks a little still */
    CHECK(fabs(report.force_n[1] - 981) < 0.05 * 981);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
    return report.sinkage_m;
}

static void a_soil_by_bekkers_parameters(void) {
    const double soft_m = sinkage_by_law(BULLETSOIL_CONTACT_BEKKER, 300e3);
    const double stiff_m = sinkage_by_law(BULLETSOIL_CONTACT_BEKKER, 3000e3);
    CHECK(soft_m > 0 && stiff_m > 0);
    CHECK(stiff_m < 0.7 * soft_m);
}

static void a_soil_by_the_work_of_propagation(void) {
    const double sinkage_m = sinkage_by_law(BULLETSOIL_CONTACT_WORK, 300e3);
    CHECK(sinkage_m > 0 && sinkage_m < 0.3);
}

static void constants_of_the_contact_law(void) {
    void* world = test_world_create();
    bulletsoil_contact_constants constants;
    bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil = NULL;
    CHECK_OK(bulletsoil_contact_constants_init(&constants, sizeof constants));
    CHECK(constants.struct_size == sizeof constants);
    CHECK(constants.creep == 0.01 && constants.sole_gap_voxels == 2);
    CHECK(constants.faces_by_shape == 1 && constants.looks_down_cosine == 0.2);
    def.contact_constants = &constants;
    constants.creep = 0.02;
    CHECK_OK(bulletsoil_destroy(create(world, &def)));
    constants.creep = 0.5;
    CHECK_INVALID(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil),
                  "contact_law.creep is 0.5, must be 0.001 to 0.2");
    constants.struct_size = 8;
    CHECK_INVALID(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil),
                  "def.contact_constants.struct_size is 8");
    CHECK_INVALID(bulletsoil_contact_constants_init(NULL, sizeof constants), "constants is null");
    test_world_destroy(world);
}

static void an_ignored_ball_falls_through(void) {
    void* world = test_world_create();
    bulletsoil_soil* soil = create_bed(world);
    void* ball = test_world_add_ball(world, 100, 0.85);
    bulletsoil_body_report report = {sizeof report, {0}, {0}, 0, 0, 0, 0, 0, 0, {0}, {0}};
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

/* A heap of sand runs out when its friction is taken from it. */
static void a_definition_changes_while_the_soil_runs(void) {
    void* world = test_world_create();
    bulletsoil_soil_def def = small_def();
    bulletsoil_material sand;
    bulletsoil_soil* soil = NULL;
    double heap_m;
    CHECK_OK(bulletsoil_material_init(&sand, sizeof sand, "dry_sand"));
    def.materials = &sand;
    def.material_count = 1;
    soil = create(world, &def);
    CHECK_OK(bulletsoil_fill_box(soil, bed_min_m, bed_max_m, NULL));
    {
        const double low_m[3] = {-0.4, 0.5, -0.4}, high_m[3] = {0.4, 0.9, 0.4};
        CHECK_OK(bulletsoil_fill_box(soil, low_m, high_m, NULL));
    }
    test_world_step(world, 240);
    heap_m = surface_height_m(soil, 0, 0);
    CHECK(heap_m > 0.7);
    def.materials = NULL; /* dry sand as it is by itself, too: nothing changes */
    def.material_count = 0;
    CHECK_OK(bulletsoil_change(soil, &def));
    test_world_step(world, 60);
    CHECK(surface_height_m(soil, 0, 0) == heap_m);
    def.materials = &sand;
    def.material_count = 1;
    sand.friction_angle_rad = 0.1;
    CHECK_OK(bulletsoil_change(soil, &def));
    test_world_step(world, 240);
    CHECK(surface_height_m(soil, 0, 0) < heap_m - 0.1);

    sand.density_kg_m3 += 10;
    CHECK_INVALID(bulletsoil_change(soil, &def), "density_kg_m3 of material 'dry_sand'");
    sand.density_kg_m3 -= 10;
    def.voxel_m *= 2;
    CHECK_INVALID(bulletsoil_change(soil, &def), "voxel_m is");
    CHECK_INVALID(bulletsoil_change(soil, NULL), "def is null");
    CHECK_INVALID(bulletsoil_change(NULL, &def), "soil is null");
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

/* A budget that no step keeps: of three calls the last one makes most of a step. */
static void a_budget_lowers_the_rate(void) {
    void* world = test_world_create();
    bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil = NULL;
    bulletsoil_step_rate rate = {sizeof rate, 0, 0, 0, 0, 0, 0};
    const double min_m[3] = {-0.3, 0, -0.3}, max_m[3] = {0.3, 0.6, 0.3};

    def.step_budget_ms = 1e-6;
    def.step_spread_max = 3;
    CHECK_OK(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil));
    CHECK_OK(bulletsoil_fill_box(soil, min_m, max_m, NULL));
    CHECK_OK(bulletsoil_get_step_rate(soil, &rate));
    CHECK(rate.due_count == 0 && rate.share == 1);
    test_world_step(world, 31);
    CHECK_OK(bulletsoil_get_step_rate(soil, &rate));
    CHECK(rate.due_count == 31 && rate.begun_count == 11 && rate.held_count == 10);
    CHECK(rate.call_count_most == 3 && fabs(rate.share - 11.0 / 31) < 1e-9);
    CHECK(rate.call_most_ms > 0 && rate.struct_size == sizeof rate);
    def.step_budget_ms = 0;
    CHECK_OK(bulletsoil_change(soil, &def));
    test_world_step(world, 10);
    CHECK_OK(bulletsoil_get_step_rate(soil, &rate));
    CHECK(rate.due_count == 41 && rate.begun_count == 21);
    CHECK_INVALID(bulletsoil_get_step_rate(soil, NULL), "rate is null");
    rate.struct_size = 4;
    CHECK_INVALID(bulletsoil_get_step_rate(soil, &rate), "rate.struct_size is 4");
    CHECK_OK(bulletsoil_destroy(soil));
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

static bulletsoil_soil* kept;
static void destroy_kept(void) {
    if (bulletsoil_destroy(kept) == BULLETSOIL_OK) return;
    fprintf(stderr, "%s\n", bulletsoil_last_error());
    _Exit(1);
}

/* What is registered first is called last: after all that the library has made meanwhile is gone.
 */
static void a_soil_may_live_until_the_program_ends(void) {
    CHECK(atexit(destroy_kept) == 0);
    kept = create_bed(test_world_create());
}

static const struct {
    const char* name;
    void (*run)(void);
} cases[] = {
    {"versions", versions},
    {"a_ball_rests_on_sand", a_ball_rests_on_sand},
    {"a_soil_by_bekkers_parameters", a_soil_by_bekkers_parameters},
    {"a_soil_by_the_work_of_propagation", a_soil_by_the_work_of_propagation},
    {"constants_of_the_contact_law", constants_of_the_contact_law},
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
    {"a_soil_may_live_until_the_program_ends", a_soil_may_live_until_the_program_ends},
    {"a_budget_lowers_the_rate", a_budget_lowers_the_rate},
    {"a_definition_changes_while_the_soil_runs", a_definition_changes_while_the_soil_runs},
    {"settling_brings_a_heap_to_rest", settling_brings_a_heap_to_rest},
    {"soil_is_poured_and_taken_to_the_unit", soil_is_poured_and_taken_to_the_unit},
    {"sources_and_sinks_move", sources_and_sinks_move},
    {"sinks_have_the_forms_of_bodies", sinks_have_the_forms_of_bodies},
    {"water_is_counted_to_the_unit", water_is_counted_to_the_unit},
    {"wells_say_what_they_have_moved", wells_say_what_they_have_moved},
    {"wind_carries_what_falls", wind_carries_what_falls},
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
