#include "checks.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "test_world.h"

void check(int condition, const char* what, const char* where) {
    if (condition) return;
    fprintf(stderr, "%s: %s\nlast error: %s\n", where, what, bulletsoil_last_error());
    exit(1);
}

void check_error(bulletsoil_result found, bulletsoil_result expected, const char* word,
                 const char* what, const char* where) {
    check(found == expected, what, where);
    check(test_says_what_to_do(bulletsoil_last_error()), "the error says what to do", where);
    if (strstr(bulletsoil_last_error(), word) != NULL) return;
    fprintf(stderr, "'%s' is not in the text of the error\n", word);
    check(0, what, where);
}

bulletsoil_soil_def small_def(void) {
    bulletsoil_soil_def def;
    CHECK_OK(bulletsoil_soil_def_init(&def, sizeof def));
    def.size_m[0] = 2;
    def.size_m[1] = 1;
    def.size_m[2] = 2;
    def.backend = BULLETSOIL_BACKEND_CPU;
    return def;
}

bulletsoil_soil* create(void* world, const bulletsoil_soil_def* def) {
    bulletsoil_soil* soil = NULL;
    CHECK_OK(bulletsoil_create(world, test_world_scalar_bytes(), def, &soil));
    CHECK(soil != NULL);
    return soil;
}

const double bed_min_m[3] = {-1, 0, -1}, bed_max_m[3] = {1, 0.5, 1};

bulletsoil_soil* create_bed(void* world) {
    const bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil = create(world, &def);
    CHECK_OK(bulletsoil_fill_box(soil, bed_min_m, bed_max_m, "dry_sand"));
    return soil;
}

uint64_t checksum(const bulletsoil_soil* soil) {
    uint64_t out = 0;
    CHECK_OK(bulletsoil_get_checksum(soil, &out));
    return out;
}

double surface_height_m(const bulletsoil_soil* soil, double x_m, double z_m) {
    const double point_m[3] = {x_m, 0, z_m};
    double out = -1;
    CHECK_OK(bulletsoil_get_surface_height(soil, point_m, &out));
    return out;
}
