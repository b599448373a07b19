#include "flows.h"

#include <math.h>
#include <stddef.h>

#include "checks.h"
#include "test_world.h"

void soil_is_poured_and_taken_to_the_unit(void) {
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
    sink.water_kg_s = 0.1;
    CHECK_INVALID(bulletsoil_add_sink(soil, &sink, NULL), "pore_water_fraction is 0");
    sink.water_kg_s = 0;
    sink.rotation[3] = 0;
    CHECK_INVALID(bulletsoil_add_sink(soil, &sink, NULL), "unit quaternion");
    sink.rotation[3] = 1;
    sink.shape = 5;
    CHECK_INVALID(bulletsoil_add_sink(soil, &sink, NULL), "sink.shape is 5");
    sink.struct_size = 5;
    CHECK_INVALID(bulletsoil_add_sink(soil, &sink, NULL), "sink.struct_size is 5");
    CHECK_OK(bulletsoil_destroy(soil));
    def.open_sides = 4;
    CHECK_INVALID(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil), "open_sides");
    test_world_destroy(world);
}

/* Steps of 1/60 s, 2 of these seconds at each place: 20 kg/s make two heaps of 40 kg. */
void sources_and_sinks_move(void) {
    const double here_m[3] = {-0.5, 0.8, 0}, there_m[3] = {0.5, 0.8, 0}, down[3] = {0, 0, 0};
    const double nan_m[3] = {0, NAN, 0}, away_m[3] = {50, 0, 0};
    const double unturned[4] = {0, 0, 0, 1}, no_rotation[4] = {0, 0, 0, 0};
    void* world = test_world_create();
    bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil = create(world, &def);
    bulletsoil_source source;
    bulletsoil_sink sink;
    bulletsoil_flow_state state;
    int32_t source_id = 0, sink_id = 0;
    double in_kg = -1, out_kg = -1;

    CHECK_OK(bulletsoil_source_init(&source, sizeof source));
    source.center_m[0] = here_m[0];
    source.center_m[1] = here_m[1];
    source.rate_kg_s = 20;
    CHECK_OK(bulletsoil_add_source(soil, &source, &source_id));
    CHECK_OK(bulletsoil_settle(soil, 120, NULL));
    CHECK(surface_height_m(soil, -0.5, 0) > 0.1);
    CHECK(surface_height_m(soil, 0.5, 0) < 0.01);
    CHECK_OK(bulletsoil_move_source(soil, source_id, there_m, down));
    CHECK_OK(bulletsoil_settle(soil, 120, NULL));
    CHECK(surface_height_m(soil, 0.5, 0) > 0.1);
    state.struct_size = sizeof state;
    CHECK_OK(bulletsoil_get_flow_state(soil, source_id, &state));
    CHECK(fabs(state.mass_kg - 80) < 0.7); /* a step's part may wait */
    CHECK(state.units > 0 && state.missed_units == 0 && state.missed_kg == 0);
    CHECK_INVALID(bulletsoil_move_source(soil, 77, there_m, down), "source");
    CHECK_INVALID(bulletsoil_move_source(soil, source_id, away_m, down), "grid");
    CHECK_INVALID(bulletsoil_move_source(soil, source_id, nan_m, down), "center_m");
    CHECK_INVALID(bulletsoil_move_source(soil, source_id, NULL, down), "center_m is null");
    CHECK_INVALID(bulletsoil_move_source(soil, source_id, there_m, NULL), "direction is null");
    CHECK_OK(bulletsoil_remove_flow(soil, source_id));

    /* It takes one heap, then the other. What falls still is taken, too: a sink of a metre. */
    CHECK_OK(bulletsoil_sink_init(&sink, sizeof sink));
    sink.center_m[0] = here_m[0];
    sink.center_m[1] = 0.5;
    sink.size_m[2] = 2;
    CHECK_OK(bulletsoil_add_sink(soil, &sink, &sink_id));
    CHECK_OK(bulletsoil_settle(soil, 2, NULL));
    CHECK(surface_height_m(soil, -0.5, 0) == 0 && surface_height_m(soil, 0.5, 0) > 0.1);
    CHECK_OK(bulletsoil_move_sink(soil, sink_id, there_m, unturned));
    CHECK_INVALID(bulletsoil_move_sink(soil, source_id, there_m, unturned), "sink");
    CHECK_INVALID(bulletsoil_move_sink(soil, sink_id, there_m, no_rotation), "unit quaternion");
    CHECK_INVALID(bulletsoil_move_sink(soil, sink_id, there_m, NULL), "rotation is null");
    CHECK_INVALID(bulletsoil_move_sink(soil, sink_id, NULL, unturned), "center_m is null");
    CHECK_INVALID(bulletsoil_move_sink(NULL, sink_id, there_m, unturned), "soil is null");
    CHECK_OK(bulletsoil_remove_flow(soil, sink_id)); /* the box at y = 0.3 would leave the rest */
    CHECK_OK(bulletsoil_get_moved_mass(soil, &in_kg, &out_kg));
    CHECK(fabs(in_kg - 80) < 0.7);
    CHECK(out_kg > 35 && out_kg < 45);
    CHECK_OK(bulletsoil_get_moved_mass(soil, NULL, NULL));
    state.struct_size = 3;
    CHECK_INVALID(bulletsoil_get_flow_state(soil, 1, &state), "state.struct_size is 3");
    CHECK_INVALID(bulletsoil_get_flow_state(soil, 1, NULL), "state is null");
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

/* What each form takes out of a bed at once: its volume below the bed's surface, of 1600 kg/m3.
 * Forms of 0.8 m on the bed's floor, in voxels of 5 cm whose centres count: 10 %. */
void sinks_have_the_forms_of_bodies(void) {
    const double pi = 3.14159265358979, radius_m = 0.4;
    const double volume_m3[5] = {0.8 * 0.4 * 0.8, 0, 0, pi * radius_m * radius_m * 0.4,
                                 pi * radius_m * radius_m * 0.4 / 3};
    const int32_t shapes[3] = {BULLETSOIL_SINK_BOX, BULLETSOIL_SINK_CYLINDER, BULLETSOIL_SINK_CONE};
    const double upright[4] = {-0.70710678, 0, 0, 0.70710678}; /* z to y */
    int i, k;
    for (i = 0; i < 3; ++i) {
        void* world = test_world_create();
        bulletsoil_soil* soil = create_bed(world);
        bulletsoil_sink sink;
        double out_kg = -1;
        CHECK_OK(bulletsoil_sink_init(&sink, sizeof sink));
        sink.shape = shapes[i];
        sink.center_m[1] = 0.2;
        sink.size_m[0] = 0.8;
        sink.size_m[1] = shapes[i] == BULLETSOIL_SINK_BOX ? 0.4 : 0;
        sink.size_m[2] = 0.8;
        sink.radius_m = radius_m;
        sink.height_m = 0.4;
        if (shapes[i] != BULLETSOIL_SINK_BOX) {
            for (k = 0; k < 4; ++k) sink.rotation[k] = upright[k];
        }
        CHECK_OK(bulletsoil_add_sink(soil, &sink, NULL));
        CHECK_OK(bulletsoil_settle(soil, 1, NULL));
        CHECK_OK(bulletsoil_get_moved_mass(soil, NULL, &out_kg));
        CHECK(fabs(out_kg - 1600 * volume_m3[shapes[i]]) < 0.1 * out_kg);
        CHECK_OK(bulletsoil_destroy(soil));
        test_world_destroy(world);
    }
}

/* A bed of 2 x 0.5 x 2 m that takes 0.25 of its mass of water, a half of that as placed. */
static bulletsoil_soil* create_moist_bed(void* world, bulletsoil_soil_def def) {
    bulletsoil_material moist;
    bulletsoil_soil* soil;
    CHECK_OK(bulletsoil_material_init(&moist, sizeof moist, "dry_sand"));
    moist.loose_density_kg_m3 = moist.compacted_density_kg_m3 = 0;
    moist.pore_water_fraction = 0.25;
    moist.placed_saturation = 0.5;
    def.materials = &moist;
    def.material_count = 1;
    soil = create(world, &def);
    CHECK_OK(bulletsoil_fill_box(soil, bed_min_m, bed_max_m, NULL));
    return soil;
}

/* Rain of 0.1 mm/s on 4 m2 brings 0.4 kg in each second; a water step may be due still. */
void water_is_counted_to_the_unit(void) {
    const double inside_m[3] = {0.1, 0.2, 0.1}, above_m[3] = {0, 0.9, 0}, outside_m[3] = {0, 5, 0};
    void* world = test_world_create();
    bulletsoil_soil_def def = small_def();
    bulletsoil_soil* soil;
    int64_t units = 0, before = -1, now = -1, in = -1, out = -1;
    double mass_kg = 0, saturation = -1, water_kg;

    def.rain_m_s = 1e-4;
    soil = create_moist_bed(world, def);
    CHECK_OK(bulletsoil_get_totals(soil, 1, &units, &mass_kg));
    CHECK_OK(bulletsoil_get_water_totals(soil, &before, &in, &out));
    CHECK(in == 0 && out == 0);
    water_kg = (double)before / 16 * mass_kg / (double)units;
    CHECK(fabs(water_kg - 0.5 * 0.25 * mass_kg) < 1e-3 * water_kg);
    CHECK_OK(bulletsoil_get_saturation(soil, inside_m, &saturation));
    CHECK(fabs(saturation - 0.5) < 1e-3);
    CHECK_OK(bulletsoil_get_saturation(soil, above_m, &saturation));
    CHECK(saturation == 0);
    test_world_step(world, 5 * 60);
    CHECK_OK(bulletsoil_get_water_totals(soil, &now, &in, &out));
    CHECK(now == before + in - out);
    water_kg = (double)in / 16 * mass_kg / (double)units;
    CHECK(water_kg > 0.4 * 4 * 0.99 && water_kg < 0.4 * 5 * 1.01);
    CHECK_OK(bulletsoil_get_water_totals(soil, NULL, NULL, NULL));
    CHECK_INVALID(bulletsoil_get_water_totals(NULL, &now, NULL, NULL), "soil is null");
    CHECK_INVALID(bulletsoil_get_saturation(soil, outside_m, &saturation), "point_m is (0");
    CHECK_INVALID(bulletsoil_get_saturation(soil, NULL, &saturation), "point_m is null");
    CHECK_INVALID(bulletsoil_get_saturation(soil, inside_m, NULL), "saturation is null");
    CHECK_OK(bulletsoil_destroy(soil));

    soil = create_bed(world); /* its sand takes none */
    CHECK_OK(bulletsoil_get_water_totals(soil, &now, &in, &out));
    CHECK(now == 0 && in == 0 && out == 0);
    CHECK_OK(bulletsoil_get_saturation(soil, inside_m, &saturation));
    CHECK(saturation == 0);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

/* 0.5 kg/s out of a box of 1 m; its water steps are a second apart. */
void wells_say_what_they_have_moved(void) {
    void* world = test_world_create();
    bulletsoil_soil* soil = create_moist_bed(world, small_def());
    bulletsoil_sink well;
    bulletsoil_flow_state state;
    int64_t before = -1, now = -1, in = -1, out = -1;
    int32_t id = 0;
    CHECK_OK(bulletsoil_sink_init(&well, sizeof well));
    well.water_kg_s = 0.5;
    CHECK_OK(bulletsoil_add_sink(soil, &well, &id));
    CHECK_OK(bulletsoil_get_water_totals(soil, &before, NULL, NULL));
    test_world_step(world, 5 * 60);
    CHECK_OK(bulletsoil_get_water_totals(soil, &now, &in, &out));
    state.struct_size = sizeof state;
    CHECK_OK(bulletsoil_get_flow_state(soil, id, &state));
    CHECK(in == 0 && out > 0 && now == before - out);
    CHECK(state.units == out);
    CHECK(state.mass_kg > 0.5 * 4 * 0.99 && state.mass_kg < 0.5 * 5 * 1.01);
    CHECK_OK(bulletsoil_destroy(soil));
    test_world_destroy(world);
}

/* Grains of 1 m/s fall speed, dropped from 0.8 m, are 0.9 s in the air and take up the wind's
 * speed within 0.1 s: a wind of 0.5 m/s carries them by 0.4 m. */
void wind_carries_what_falls(void) {
    double wind_m_s;
    for (wind_m_s = -0.5; wind_m_s < 1; wind_m_s += 0.5) {
        void* world = test_world_create();
        bulletsoil_soil_def def = small_def();
        bulletsoil_material snow;
        bulletsoil_source source;
        bulletsoil_soil* soil;
        double middle_m, low_m, high_m;
        CHECK_OK(bulletsoil_material_init(&snow, sizeof snow, "dry_sand"));
        snow.loose_density_kg_m3 = snow.compacted_density_kg_m3 = 0;
        snow.fall_speed_m_s = 1;
        def.materials = &snow;
        def.material_count = 1;
        def.wind_m_s[0] = wind_m_s;
        soil = create(world, &def);
        CHECK_OK(bulletsoil_source_init(&source, sizeof source));
        source.center_m[1] = 0.85;
        source.rate_kg_s = 10;
        CHECK_OK(bulletsoil_add_source(soil, &source, NULL));
        CHECK_OK(bulletsoil_settle(soil, 300, NULL));
        low_m = surface_height_m(soil, -0.4, 0);
        middle_m = surface_height_m(soil, 0, 0);
        high_m = surface_height_m(soil, 0.4, 0);
        if (wind_m_s < 0) CHECK(low_m > 0.1 && low_m > middle_m && low_m > high_m + 0.1);
        if (wind_m_s == 0) CHECK(middle_m > low_m + 0.1 && middle_m > high_m + 0.1);
        if (wind_m_s > 0) CHECK(high_m > 0.1 && high_m > middle_m && high_m > low_m + 0.1);
        CHECK_OK(bulletsoil_destroy(soil));
        def.wind_m_s[0] = 51;
        CHECK_INVALID(bulletsoil_create(world, test_world_scalar_bytes(), &def, &soil), "wind_m_s");
        test_world_destroy(world);
    }
}
