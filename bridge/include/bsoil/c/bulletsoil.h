/**
 * The C interface: deformable soil in a Bullet world, for programs and languages that cannot
 * include C++.
 *
 * The same header serves both libraries, bulletsoil_bullet (Bullet in float) and
 * bulletsoil_bullet_double. The world and its bodies are passed as `void*`: a world is a
 * btDiscreteDynamicsWorld* or one of a class derived from it, a body a btCollisionObject* or a
 * derived one, each converted to `void*` from exactly these pointer types.
 *
 * Errors. Every function that can fail returns a bulletsoil_result; a failure changes nothing, and
 * its text, which names the argument, its value and its range, is what bulletsoil_last_error()
 * returns. Null pointers, handles that are not of a living soil, numbers out of range, structs of
 * an unknown size are errors. Pointers to worlds, bodies, arrays and texts are trusted once they
 * are not null. No C++ exception leaves these functions.
 *
 * ABI. Functions and struct members are only ever added, members at the end. `struct_size` tells
 * the library how much of a struct its caller knows; what it does not know gets its default. A
 * struct larger than the library's own is refused: then the program was compiled for a newer
 * library than it runs with.
 *
 * Threads. One soil and its world: one thread at a time. Different worlds: any threads.
 *
 * Units are SI, angles radians, axes the world's.
 *
 * Soil, water and air that come and go: bulletsoil_flow.h, which this header includes.
 */
#ifndef BSOIL_C_BULLETSOIL_H
#define BSOIL_C_BULLETSOIL_H

#include <stddef.h>
#include <stdint.h>

#include "bsoil/c/bulletsoil_flow.h"
#include "bsoil/c/bulletsoil_result.h"

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

/* -------- versions and errors -------- */

/** Version of the library that runs, as "0.1.0". Never null. */
const char* bulletsoil_version(void);
/** The same as major * 10000 + minor * 100 + patch. */
int32_t bulletsoil_version_number(void);
/** sizeof(btScalar) of the library that runs: 4 or 8. */
size_t bulletsoil_scalar_bytes(void);
/**
 * Text of the last failure in this thread, in at most 1023 bytes; "" before the first. Never null;
 * valid until the next failure in this thread.
 */
const char* bulletsoil_last_error(void);

/* -------- definitions -------- */

/** A granular material; see MaterialDef in <bsoil/material.h>. */
typedef struct bulletsoil_material {
    size_t struct_size;   /**< set by bulletsoil_material_init */
    const char* name;     /**< unique within a soil; read while the soil is created */
    double density_kg_m3; /**< bulk density as placed, 200..4000 */
    /** bulk density once it has been dug and dropped, 0..4000; 0 here and in the next: the density
     * does not change */
    double loose_density_kg_m3;
    double compacted_density_kg_m3; /**< bulk density compacted by 1 MPa, 0..4000 */
    /** angle of internal friction phi, 0..1.2; of the critical state */
    double friction_angle_rad;
    double cohesion_pa; /**< cohesion c, 0..200e3 */
    /** share of the cohesion that soil keeps once it has been moved, 0..1 */
    double loose_cohesion_fraction;
    double tool_friction; /**< Coulomb friction with bodies, 0..2 */
    /** shear stress between soil and bodies without pressure, 0..200e3 */
    double tool_adhesion_pa;
    /** Janosi and Hanamoto's K of soil as placed, 0..0.2; 0: the shear stress is there at once */
    double shear_displacement_m;
    float color[3];    /**< linear RGB, 0..1 */
    uint32_t reserved; /**< 0 */
    /** slope above tan phi at which soil still stands, 0..40; by place between half of it and all
     * of it */
    double roughness;
    /** share of the slides that do not take place, 0..1; 0: as sand does, 1: nothing slides */
    double viscosity;
    /** speed at which its grains fall in air in the end, 0..100; 0: as in a vacuum, and no wind
     * moves it */
    double fall_speed_m_s;
    /** water that its pores hold, as a share of the soil's mass, 0..1; 0: it takes none */
    double pore_water_fraction;
    double placed_saturation; /**< share of the pores that water fills as placed, 0..1 */
    /** cohesion that water gives where it fills half of the pores, 0..200e3 */
    double moist_cohesion_pa;
    double conductivity_m_s;    /**< of water down through full pores, 0..1 */
    double residual_saturation; /**< share of the pores that does not drain, 0..0.95 */
    /** cohesion of moved soil over the pressure that compacted it, 0..0.5; 0: compaction gives it
     * none. Needs the densities */
    double compaction_cohesion_ratio;
    /** peak angle of friction over the critical one per unit of dilatancy index, 0..0.1; 0: density
     * does not count. Needs the densities */
    double dilatancy_angle_rad;
} bulletsoil_material;

/**
 * Sets `material`, of `struct_size` = sizeof *material bytes, to the built-in material of this
 * name: dry_sand, moist_sand, sandy_loam, loam, clay, gravel, fine_sand (which takes water).
 */
bulletsoil_result bulletsoil_material_init(bulletsoil_material* material, size_t struct_size,
                                           const char* built_in_name);

enum { BULLETSOIL_UP_Y = 0, BULLETSOIL_UP_Z = 1 };
enum { BULLETSOIL_BACKEND_AUTOMATIC = 0, BULLETSOIL_BACKEND_CPU = 1, BULLETSOIL_BACKEND_GL = 2 };

enum {
    BULLETSOIL_OVERFLOW_EVEN = 0,     /**< into all neighbours evenly */
    BULLETSOIL_OVERFLOW_UP = 1,       /**< one voxel up */
    BULLETSOIL_OVERFLOW_UP_SPREAD = 2 /**< into the nine voxels above, the middle one most */
};

enum {
    /** none: soil comes to rest at its angle of friction, as if let down slowly */
    BULLETSOIL_SLIDES_SETTLE = 0,
    BULLETSOIL_SLIDES_RUN_OUT = 1 /**< it goes on along the ground until friction has taken it */
};

enum {
    /** by the stress at each element of a body's surface */
    BULLETSOIL_CONTACT_GRANULAR = 0,
    /** by Bekker's pressure and Janosi's shear; each material needs its parameters */
    BULLETSOIL_CONTACT_BEKKER = 1,
    /** by resistive force theory alone */
    BULLETSOIL_CONTACT_PLAIN = 2,
    /** by the work of moving what a face displaces to the free surface */
    BULLETSOIL_CONTACT_WORK = 3
};

/** A bit for each side of the grid's box along the world's axes, before it is turned by yaw_rad. */
enum {
    BULLETSOIL_OPEN_LOW_X = 1,
    BULLETSOIL_OPEN_HIGH_X = 2,
    BULLETSOIL_OPEN_LOW_Y = 4,
    BULLETSOIL_OPEN_HIGH_Y = 8,
    BULLETSOIL_OPEN_LOW_Z = 16,
    BULLETSOIL_OPEN_HIGH_Z = 32
};

/** Constants of the contact law; see ContactLawDef in <bsoil/contact/contact_law_def.h>, which says
 * where each value is from and what changes with it. */
typedef struct bulletsoil_contact_constants {
    size_t struct_size; /**< set by bulletsoil_contact_constants_init */
    /** a wall meets no more than its passive wedge, 0..1; that of a log spiral; where this is
     * off, the granular law has Coulomb's wedge and the plain law none */
    int32_t passive_wedge;
    /** soil between the teeth of a row (lugs, grousers) goes with them, 0..1; as far as the
     * passive wedge before each reaches; with faces by shape */
    int32_t trapped_soil;
    /** an element that moves less than this share of its body's motion counts as resting,
     * 0.001..0.2 */
    double creep;
    /** how many times as stiffly soil unloads as it was loaded, 1..1000 */
    double unloading_stiffness;
    /** the most that a face goes into the soil while it slips along it, as a share of its slip,
     * 0.001..1 */
    double slip_band_slope;
    /** gap across which soil that the grid holds in the next voxel loses touch, 0.01..2 */
    double open_gap_voxels;
    double dense_shear_share; /**< K of compacted soil over that of loose soil, 0.01..1 */
    /** sinkage over which a sole's bearing develops in loose soil, in widths, 0.01..1 */
    double mobilization_widths;
    /** how much less it is in compacted soil, in widths, 0..0.99; less than 0.99 of that in loose
     * soil */
    double mobilization_fall_widths;
    /** length of the wedge before a wall over its depth, 0..5; 0: Rankine's tan(45 deg + phi /
     * 2) with each material's own phi, else at least 0.5 */
    double wedge_length;
    /** how many widths around a sole's middle soil counts, 0.5..5 */
    double sole_surroundings_widths;
    /** share of the hollow under a sole that counts with the rim around it, 0..1 */
    double hollow_share;
    /** area, place and direction of an element come from the body's shapes, 0..1; else from the
     * coverage field */
    int32_t faces_by_shape;
    /** excess below this share of a voxel is in transit and is no compression, 0..0.5 */
    double under_way_share;
    /** sine of the angle from which a gradient beside a face is of an edge, 0.1..0.9 */
    double edge_sine;
    /** faces round an edge whose normals are further apart than this cosine are different ones,
     * 0..1 */
    double edge_face_cosine;
    int32_t sole_gap_voxels; /**< parts of a sole no further apart than this are one, 0..8 */
    /** two voxels are the same soil if they are closer than this across the direction in which
     * the soil moved, 0.1..4 */
    double same_across_voxels;
    /** two voxels are the same soil if they are closer than this along that direction, 0.1..4 */
    double same_along_voxels;
    double memory_reach_voxels; /**< soil further off than this is not looked at, 0.1..4 */
    /** another body's face is the same contact where its normal is no further off than this
     * cosine, 0..1 */
    double same_contact_cosine;
    /** the soil under a face that looks down by this cosine at least goes down with it, 0..1 */
    double looks_down_cosine;
} bulletsoil_contact_constants;

/** Sets `constants`, of `struct_size` = sizeof *constants bytes, to the defaults. */
bulletsoil_result bulletsoil_contact_constants_init(bulletsoil_contact_constants* constants,
                                                    size_t struct_size);

/** Bekker's, Mohr and Coulomb's and Janosi's parameters of a material, for
 * BULLETSOIL_CONTACT_BEKKER; see BekkerSoil in <bsoil/contact/bekker_soil.h>. Without a
 * struct_size: it gets no more members. */
typedef struct bulletsoil_bekker {
    double kphi_pa_m_n;          /**< frictional modulus kphi [N/m^(n+2)], 0..1e9 */
    double kc_pa_m_n1;           /**< cohesive modulus kc [N/m^(n+1)], -1e8..1e8 */
    double n;                    /**< exponent of sinkage, 0..2.5 */
    double cohesion_pa;          /**< Mohr cohesion c, 0..200e3 */
    double friction_angle_rad;   /**< Mohr friction angle phi, 0..1.2 */
    double shear_displacement_m; /**< Janosi's K, 0..0.2; 0: shear stress is there at once */
} bulletsoil_bekker;

/** How a soil is made; see SoilDef in <bsoil/soil_def.h>. */
typedef struct bulletsoil_soil_def {
    size_t struct_size; /**< set by bulletsoil_soil_def_init */
    /** 1..8 materials in an array, each with the same struct_size; null: dry_sand alone */
    const bulletsoil_material* materials;
    size_t material_count;
    double size_m[3];         /**< box of the grid along the world's axes */
    double floor_center_m[3]; /**< centre of the box's bottom face, -1e7..1e7 */
    double yaw_rad;           /**< rotation of the grid about the up axis, -7..7 */
    double voxel_m;           /**< edge of a voxel, 0.001..1 */
    double gravity_m_s2;      /**< gravity along -up, 0..30 */
    double step_s;            /**< the soil's own step, 1/2000..1/20 */
    int32_t up;               /**< world axis that points up: BULLETSOIL_UP_... */
    int32_t backend;          /**< where the kernels run: BULLETSOIL_BACKEND_... */
    /** threads of the CPU backend, 0..1024; 0: all cores. Results do not depend on it */
    int32_t thread_count;
    int32_t substeps_max; /**< sub-steps a fast step may be cut into, 1..32 */
    /** tiles of 8 x 8 columns awake at the same time, 0..4194304; 0: all that fit into 1 GiB */
    int32_t tile_capacity;
    /** alpha of the thesis: iterations of force propagation a step, 0..64 */
    int32_t propagation_iterations;
    int32_t overflow; /**< how soil that does not fit leaves its voxel: BULLETSOIL_OVERFLOW_... */
    int32_t overflow_passes; /**< passes that spread soil which does not fit, 0..64 */
    int32_t contact_law;     /**< what soil does to bodies: BULLETSOIL_CONTACT_... */
    uint32_t reserved;       /**< 0 */
    /** sides of the grid, OpenSide bits, over whose edge soil falls out of it, 0..63:
     * BULLETSOIL_OPEN_... added up */
    int32_t open_sides;
    int32_t slides;            /**< what becomes of the momentum of slides: BULLETSOIL_SLIDES_... */
    double rain_m_s;           /**< water that falls on soil that takes some, 0..1e-3 */
    double drying_m_s;         /**< water that dries off the ground's surface, 0..1e-3 */
    double floor_drainage_m_s; /**< water that the grid's floor lets through, 0..1 */
    double wind_m_s[3];        /**< velocity of the air, along the world's axes, -50..50 */
    /** share by which gusts raise and lower the wind, 0..1; they drift with it */
    double gust;
    double gust_size_m; /**< from one gust to the next, 0.01..1000; at most 1024 voxels */
    /** so far behind what bars it there is no wind, 0..100; at most 128 voxels */
    double shelter_m;
    /** with BULLETSOIL_CONTACT_BEKKER: an array, one for each material in their order; else null */
    const bulletsoil_bekker* bekker;
    size_t bekker_count;
    /** of the contact law; null: the defaults */
    const bulletsoil_contact_constants* contact_constants;
    /** groundwater up to this height over the grid's floor, 0..1000; 0: none. Soil below is full of
     * water */
    double water_table_m;
    /** time that a call of step() may take, 0..1000; 0: as long as it takes. A step that needs more
     * goes on in the next calls, and the soil's time slows down. With it, results depend on the
     * machine */
    double step_budget_ms;
    /** calls over which a budget may spread a step, 2..1000; the last one finishes it */
    int32_t step_spread_max;
    uint32_t reserved_2; /**< 0 */
} bulletsoil_soil_def;

/** Sets `def`, of `struct_size` = sizeof *def bytes, to the defaults: 12 x 2 x 12 m, voxels of 5
 * cm, y up, dry sand. */
bulletsoil_result bulletsoil_soil_def_init(bulletsoil_soil_def* def, size_t struct_size);

/* -------- a soil's life -------- */

/**
 * Creates a soil and couples it with `world`, which from then on steps it in stepSimulation. `up`
 * and `gravity_m_s2` have to be the world's gravity, to a twentieth, unless the world has none yet.
 * `scalar_bytes` is sizeof(btScalar) where the world was made: BULLETSOIL_WRONG_PRECISION where it
 * is not the library's. On success *soil is the new handle, else null.
 */
bulletsoil_result bulletsoil_create(void* world, size_t scalar_bytes,
                                    const bulletsoil_soil_def* def, bulletsoil_soil** soil);
/**
 * Another definition while the soil runs, from the next step on. May differ: the materials' numbers
 * but densities and pore water, their colours, rain, drying, drainage, groundwater, wind, gusts and
 * shelter, the counts of iterations, passes and sub-steps, and the budget. Soil that is there takes
 * on what its material is now. BULLETSOIL_INVALID_ARGUMENT where anything else differs; then
 * nothing changes.
 */
bulletsoil_result bulletsoil_change(bulletsoil_soil* soil, const bulletsoil_soil_def* def);
/** Takes the soil out of its world, which may have been destroyed before, and frees it. Null is
 * accepted. May be called as late as from atexit() and the destructors of static objects. */
bulletsoil_result bulletsoil_destroy(bulletsoil_soil* soil);

/* -------- putting soil in; `material` is a name out of the definition, null: its first -------- */

/** A box along the world's axes. */
bulletsoil_result bulletsoil_fill_box(bulletsoil_soil* soil, const double min_m[3],
                                      const double max_m[3], const char* material);
/** A cylinder about the up axis, upwards from the centre of its base; radius and height 1e-6..1e6.
 */
bulletsoil_result bulletsoil_fill_cylinder(bulletsoil_soil* soil, const double base_center_m[3],
                                           double radius_m, double height_m, const char* material);
/** Ground under an image of width x height heights above the grid's floor [m], row by row, width
 * and height 2..32768; stretched over it. A row runs along the world's x, and rows follow each
 * other along z (y where z is up), before yaw_rad turns the grid. */
bulletsoil_result bulletsoil_fill_height_map(bulletsoil_soil* soil, int32_t width, int32_t height,
                                             const float* heights_m, const char* material);

/** What bulletsoil_settle did, and what it left. */
typedef struct bulletsoil_settle_report {
    size_t struct_size;         /**< to be set by the caller to sizeof(bulletsoil_settle_report) */
    int32_t is_at_rest;         /**< 1: nothing moves, nothing may start to; else 0 */
    int32_t step_count;         /**< steps it made */
    int32_t block_active_count; /**< blocks of 8 x 8 x 8 voxels that still move or may move */
    int32_t tile_awake_count;   /**< tiles of 8 x 8 columns that are awake */
} bulletsoil_settle_report;

/**
 * Behind a loading screen, with all soil and bodies in place and between calls of stepSimulation:
 * looks at what was filled for slopes that may not stand, which the first step would do, then makes
 * up to `steps_max` (0..100000) soil steps until nothing moves. The world's bodies stand still and
 * feel nothing; no time passes in the world. `report` may be null. BULLETSOIL_INVALID_ARGUMENT also
 * where the soil is switched off, or its world is gone.
 */
bulletsoil_result bulletsoil_settle(bulletsoil_soil* soil, int32_t steps_max,
                                    bulletsoil_settle_report* report);

/* -------- bodies -------- */

/* Options of a body count from the next soil step on and end when it leaves the world. Those of a
 * body that is not in the world yet wait for it. Set them back before such a body is deleted
 * without ever having been in the world: a new one at its address would get them. */

/** Not 0: the soil does not see this body, and it does not feel the soil. */
bulletsoil_result bulletsoil_set_body_ignored(bulletsoil_soil* soil, const void* body,
                                              int32_t ignored);
/** Not 0: the soil gives way to this body, and it feels nothing. */
bulletsoil_result bulletsoil_set_body_coverage_only(bulletsoil_soil* soil, const void* body,
                                                    int32_t coverage_only);
/**
 * Friction (0..2) and adhesion (0..200e3 Pa) between the soil and this body; a negative value: as
 * the material says.
 */
bulletsoil_result bulletsoil_set_body_surface(bulletsoil_soil* soil, const void* body,
                                              double friction, double adhesion_pa);
/** 0: the soil is frozen and carries nothing; not 0 again: it goes on with the bodies where they
 * are then. On at first. */
bulletsoil_result bulletsoil_set_enabled(bulletsoil_soil* soil, int32_t enabled);

/** What the soil does to a body; see BodyReport in <bsoil/bullet/soil_action.h>. */
typedef struct bulletsoil_body_report {
    size_t struct_size;   /**< to be set by the caller to sizeof(bulletsoil_body_report) */
    double force_n[3];    /**< of the soil on the body, in Bullet's last substep */
    double torque_n_m[3]; /**< about its centre of mass */
    double peak_force_n;  /**< largest force so far */
    double contact_area_m2;
    double sinkage_m; /**< of its lowest point below the surface of the soil beside it */
    double load_kg;   /**< soil it carries */
    int32_t contact_patch_count;
    int32_t is_in_contact; /**< 1: patches or a load; else 0 */
    /** of the soil it carries and of soil that falls on it, besides force_n: weight, and the push
     * of soil whose velocity the body has changed; see BodyReport */
    double load_n[3];
    /** of bodies that stand on the soil it carries, besides force_n and load_n; see BodyReport */
    double through_load_n[3];
} bulletsoil_body_report;

/** All zero for a body that does not touch the soil, or is none of the world's. */
bulletsoil_result bulletsoil_get_body_report(const bulletsoil_soil* soil, const void* body,
                                             bulletsoil_body_report* report);

/* -------- the soil's state -------- */

/** Soil steps made so far. */
bulletsoil_result bulletsoil_get_step_count(const bulletsoil_soil* soil, int64_t* count);

/** How a soil keeps up with its world; see bulletsoil_soil_def.step_budget_ms. */
typedef struct bulletsoil_step_rate {
    size_t struct_size; /**< to be set by the caller to sizeof(bulletsoil_step_rate) */
    int64_t due_count;  /**< steps that were due since the soil was created */
    /** that began when they were due; the soil has dropped the time of the others */
    int64_t begun_count;
    int64_t held_count;      /**< times that a step was finished beyond the budget */
    int64_t call_count_most; /**< due steps over which one was spread, at most */
    double share;            /**< begun_count / due_count, 0..1 */
    double call_most_ms;     /**< longest that one has held its caller; 0 without a budget */
} bulletsoil_step_rate;

/** With or without a budget. */
bulletsoil_result bulletsoil_get_step_rate(const bulletsoil_soil* soil, bulletsoil_step_rate* rate);
/** Materials of this soil, in the order of its definition. */
bulletsoil_result bulletsoil_get_material_count(const bulletsoil_soil* soil, size_t* count);
/**
 * Amount of each material: integer units, which only fills, sources and sinks
 * change, and mass. Either array may be
 * null; both have room for `capacity` entries, at least as many as there are materials. Costs a
 * pass over everything.
 */
bulletsoil_result bulletsoil_get_totals(const bulletsoil_soil* soil, size_t capacity,
                                        int64_t* units, double* mass_kg);
/** Of amounts, motion and terrain: the same on every backend with any number of threads. */
bulletsoil_result bulletsoil_get_checksum(const bulletsoil_soil* soil, uint64_t* checksum);
/** World coordinate along up of the soil's (or terrain's) surface in the column of `point_m`, which
 * lies in the grid. */
bulletsoil_result bulletsoil_get_surface_height(const bulletsoil_soil* soil,
                                                const double point_m[3], double* height_m);
/**
 * Conditions the soil has run into, a line each with its cure, and the bodies that touch it and are
 * refused, with the reason; "" where there are none. Writes at most `capacity` bytes with the final
 * zero; `buffer` may be null where `capacity` is 0. *needed (which may be null) is the capacity for
 * all of it.
 */
bulletsoil_result bulletsoil_get_status_text(const bulletsoil_soil* soil, char* buffer,
                                             size_t capacity, size_t* needed);
/** Number of conditions the soil has run into since they were cleared; one for each kind and body.
 */
bulletsoil_result bulletsoil_get_condition_count(const bulletsoil_soil* soil, size_t* count);

/** A condition; see Condition in <bsoil/condition.h>. */
typedef struct bulletsoil_condition {
    size_t struct_size;   /**< to be set by the caller to sizeof(bulletsoil_condition) */
    const char* text;     /**< "body_teleported: a body jumped; ..." and the cure; lasts for ever */
    uint32_t status_bit;  /**< its value in docs/questions/status_bits.md */
    int32_t has_position; /**< 1: position_m is set; else 0 */
    const void* body;     /**< whose it is; compare only, it may be gone. Null: no single body's */
    double position_m[3]; /**< where it was first met */
    int64_t first_step;   /**< soil step in which it was first met; the first of all is 1 */
    double first_time_s;  /**< the end of that step */
    int64_t last_step;    /**< in which it was last met */
    int64_t step_count;   /**< steps in which it was met */
} bulletsoil_condition;

/** Condition number `index`, below the count; the oldest is 0. */
bulletsoil_result bulletsoil_get_condition(const bulletsoil_soil* soil, size_t index,
                                           bulletsoil_condition* condition);
/** Conditions stay until they are cleared. */
bulletsoil_result bulletsoil_clear_status(bulletsoil_soil* soil);

/** Writes the whole soil to a file. */
bulletsoil_result bulletsoil_save(const bulletsoil_soil* soil, const char* path);
/** Replaces the soil's state by a file's, which must be of the same grid and materials. */
bulletsoil_result bulletsoil_load(bulletsoil_soil* soil, const char* path);

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif

#endif
