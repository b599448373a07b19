/**
 * The C interface: sources out of which soil comes, sinks that take it away, water that comes and
 * goes. bulletsoil.h includes it, and says what holds for all of it. Wind, rain, groundwater and
 * open sides are members of bulletsoil_soil_def.
 */
#ifndef BSOIL_C_BULLETSOIL_FLOW_H
#define BSOIL_C_BULLETSOIL_FLOW_H

#include <stddef.h>
#include <stdint.h>

#include "bsoil/c/bulletsoil_result.h"

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

enum { BULLETSOIL_SOURCE_DISC = 0, BULLETSOIL_SOURCE_RECTANGLE = 1 };

/** A region out of which soil comes; see SourceDef in <bsoil/soil_flow.h>. */
typedef struct bulletsoil_source {
    size_t struct_size;   /**< set by bulletsoil_source_init */
    double center_m[3];   /**< world, -1e7..1e7 */
    double direction[3];  /**< the soil leaves along it, square to the region; zero: down */
    double radius_m;      /**< of a disc, 1e-4..1e4 */
    double length_m;      /**< of a rectangle, 1e-4..1e4 */
    double width_m;       /**< across its length, 1e-4..1e4 */
    double turn_rad;      /**< of the rectangle about its direction, -7..7 */
    double speed_m_s;     /**< with which the soil leaves, 0..100; at most 8 voxels a step */
    double spread_rad;    /**< half the angle of a jet's cone, 0..1 */
    double rate_kg_s;     /**< 0..1e9; one of the two rates is above 0 */
    double rate_m3_s;     /**< of loose soil, 0..1e6 */
    double start_s;       /**< simulated time of the soil, 0..1e9 */
    double end_s;         /**< likewise; 1e9 by default */
    const char* material; /**< a name out of the definition; null: its first */
    int32_t shape;        /**< BULLETSOIL_SOURCE_... */
    uint32_t reserved;    /**< 0 */
} bulletsoil_source;

enum {
    BULLETSOIL_SINK_BOX = 0,
    BULLETSOIL_SINK_SPHERE = 1,
    BULLETSOIL_SINK_CAPSULE = 2,
    BULLETSOIL_SINK_CYLINDER = 3,
    BULLETSOIL_SINK_CONE = 4 /**< its tip at the end of its z */
};

/** A region that takes soil away; see SinkDef in <bsoil/soil_flow.h>. */
typedef struct bulletsoil_sink {
    size_t struct_size; /**< set by bulletsoil_sink_init */
    double center_m[3]; /**< world */
    double rotation[4]; /**< unit quaternion x, y, z, w; the region's frame -> world */
    double size_m[3];   /**< full edge lengths of a box */
    double radius_m;    /**< of a sphere, capsule or cylinder, of a cone's base */
    double height_m;    /**< of a cylinder or cone along its z; of a capsule, between its ends'
                             centres */
    double rate_kg_s; /**< what it takes, as far as there is soil, 0..1e9; 0: all, in every step */
    double start_s, end_s; /**< simulated time of the soil, 0..1e9 */
    int32_t shape;         /**< BULLETSOIL_SINK_... */
    uint32_t reserved;     /**< 0 */
    /** not 0: a well, which moves water instead of soil: out of the region's pores, below 0 into
     * them, -1e9..1e9 */
    double water_kg_s;
} bulletsoil_sink;

/** Sets `source`, of `struct_size` = sizeof *source bytes, to a disc that pours nothing yet. */
bulletsoil_result bulletsoil_source_init(bulletsoil_source* source, size_t struct_size);
/** Sets `sink`, of `struct_size` = sizeof *sink bytes, to a box of 1 m that takes all. */
bulletsoil_result bulletsoil_sink_init(bulletsoil_sink* sink, size_t struct_size);
/** Works from the next soil step on. *id, which may be null, names it in the calls below. */
bulletsoil_result bulletsoil_add_source(bulletsoil_soil* soil, const bulletsoil_source* source,
                                        int32_t* id);
/** As bulletsoil_add_source. */
bulletsoil_result bulletsoil_add_sink(bulletsoil_soil* soil, const bulletsoil_sink* sink,
                                      int32_t* id);
/** Puts a source somewhere else; its rate goes on. `direction` as in bulletsoil_source. */
bulletsoil_result bulletsoil_move_source(bulletsoil_soil* soil, int32_t id,
                                         const double center_m[3], const double direction[3]);
/** Puts a sink somewhere else; its rate goes on. `rotation` as in bulletsoil_sink. */
bulletsoil_result bulletsoil_move_sink(bulletsoil_soil* soil, int32_t id, const double center_m[3],
                                       const double rotation[4]);
/** Ends a source or sink. */
bulletsoil_result bulletsoil_remove_flow(bulletsoil_soil* soil, int32_t id);
/** Mass that it has moved so far. */
bulletsoil_result bulletsoil_get_flow_mass(const bulletsoil_soil* soil, int32_t id,
                                           double* mass_kg);

/** What a source or sink has done; see FlowState in <bsoil/soil_flow.h>. */
typedef struct bulletsoil_flow_state {
    size_t struct_size;   /**< to be set by the caller to sizeof(bulletsoil_flow_state) */
    int64_t units;        /**< of mass, moved so far; a well's as bulletsoil_get_water_totals */
    int64_t missed_units; /**< were due and will never come: no room, no soil */
    double mass_kg;       /**< of `units` */
    double missed_kg;     /**< of `missed_units` */
} bulletsoil_flow_state;

/** What a source or sink has done so far. */
bulletsoil_result bulletsoil_get_flow_state(const bulletsoil_soil* soil, int32_t id,
                                            bulletsoil_flow_state* state);
/** Mass that all sources have poured in, and that all sinks and open sides have taken out. Either
 * may be null. Costs nothing. */
bulletsoil_result bulletsoil_get_moved_mass(const bulletsoil_soil* soil, double* in_kg,
                                            double* out_kg);
/**
 * Integer units of each material that sources have poured in, and that sinks and open sides have
 * taken out. Either array may be null; both have room for `capacity` entries, at least as many as
 * there are materials. Costs a pass over everything.
 */
bulletsoil_result bulletsoil_get_flow_totals(const bulletsoil_soil* soil, size_t capacity,
                                             int64_t* units_in, int64_t* units_out);

/**
 * Water in the soil, in sixteenths of the units of bulletsoil_get_totals, and since the soil was
 * created: what rain, sources, wells and groundwater have brought, and what has dried, drained,
 * been pumped or gone with taken soil. Each may be null. Costs a pass over everything.
 */
bulletsoil_result bulletsoil_get_water_totals(const bulletsoil_soil* soil, int64_t* units,
                                              int64_t* units_in, int64_t* units_out);
/** Share of the pores that water fills, 0..1, in the voxel at `point_m`, which lies in the grid; 0
 * where there is no soil, or none that takes water. */
bulletsoil_result bulletsoil_get_saturation(const bulletsoil_soil* soil, const double point_m[3],
                                            double* saturation);

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif

#endif
