// Sources and sinks of the C interface.
#include <algorithm>
#include <cmath>

#include "c_calls.h"

namespace bsoil::bullet {
namespace {

Pose pose_of(const double* center_m, const double* rotation, const char* center_name,
             const std::string& rotation_name) {
    Pose out;
    out.position = point(center_m, center_name);
    const double* q = &required(rotation, rotation_name.c_str());
    const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(size > 0.99 && size < 1.01)) refuse(rotation_name + " must be a unit quaternion");
    out.rotation = {q[0] / size, q[1] / size, q[2] / size, q[3] / size};
    return out;
}

}  // namespace

bulletsoil_source default_source() {
    const SourceDef from;
    bulletsoil_source out{};
    out.struct_size = sizeof out;
    out.radius_m = from.radius_m;
    out.length_m = from.length_m;
    out.width_m = from.width_m;
    out.end_s = from.end_s;
    return out;
}

bulletsoil_sink default_sink() {
    bulletsoil_sink out{};
    out.struct_size = sizeof out;
    out.rotation[3] = 1;
    out.size_m[0] = out.size_m[1] = out.size_m[2] = 1;
    out.radius_m = 0.5;
    out.height_m = 1;
    out.end_s = kFlowForever;
    return out;
}

SourceDef from_c(const bulletsoil_source& source) {
    if (source.reserved != 0) {
        refuse("source.reserved is " + std::to_string(source.reserved) + ", must be 0");
    }
    SourceDef out;
    out.shape = static_cast<SourceDef::Shape>(source.shape);
    out.center_m = point(source.center_m, "source.center_m");
    out.direction = point(source.direction, "source.direction");
    out.radius_m = source.radius_m;
    out.length_m = source.length_m;
    out.width_m = source.width_m;
    out.turn_rad = source.turn_rad;
    out.speed_m_s = source.speed_m_s;
    out.spread_rad = source.spread_rad;
    out.rate_kg_s = source.rate_kg_s;
    out.rate_m3_s = source.rate_m3_s;
    out.start_s = source.start_s;
    out.end_s = source.end_s;
    out.material = text_of(source.material);
    return out;
}

SinkDef from_c(const bulletsoil_sink& sink) {
    if (sink.reserved != 0) {
        refuse("sink.reserved is " + std::to_string(sink.reserved) + ", must be 0");
    }
    if (sink.shape < BULLETSOIL_SINK_BOX || sink.shape > BULLETSOIL_SINK_CONE) {
        refuse("sink.shape is " + std::to_string(sink.shape) +
               ", must be one of BULLETSOIL_SINK_...");
    }
    SinkDef out;
    out.region.kind = static_cast<ConvexShape::Kind>(sink.shape);
    out.region.half_extents_m = 0.5 * point(sink.size_m, "sink.size_m");
    out.region.radius_m = sink.radius_m;
    out.region.half_height_m = sink.height_m / 2;
    out.pose = pose_of(sink.center_m, sink.rotation, "sink.center_m", "sink.rotation");
    out.rate_kg_s = sink.rate_kg_s;
    out.water_kg_s = sink.water_kg_s;
    out.start_s = sink.start_s;
    out.end_s = sink.end_s;
    return out;
}

}  // namespace bsoil::bullet

using namespace bsoil::bullet;

extern "C" {

bulletsoil_result bulletsoil_source_init(bulletsoil_source* source, size_t struct_size) {
    return guarded(__func__, [&] {
        required(source, "source");
        check_size("source", struct_size, kSourceBytesMin, sizeof(bulletsoil_source));
        narrow_into(*source, default_source(), struct_size);
    });
}

bulletsoil_result bulletsoil_sink_init(bulletsoil_sink* sink, size_t struct_size) {
    return guarded(__func__, [&] {
        required(sink, "sink");
        check_size("sink", struct_size, kSinkBytesMin, sizeof(bulletsoil_sink));
        narrow_into(*sink, default_sink(), struct_size);
    });
}

bulletsoil_result bulletsoil_add_source(bulletsoil_soil* soil, const bulletsoil_source* source,
                                        int32_t* id) {
    return guarded(__func__, [&] {
        SoilAction& action = action_of(soil);
        required(source, "source");
        check_size("source", source->struct_size, kSourceBytesMin, sizeof(bulletsoil_source));
        const auto added = action.soil().add_source(from_c(widened(*source, default_source())));
        if (!added) refuse(added.error());
        if (id != nullptr) *id = *added;
    });
}

bulletsoil_result bulletsoil_add_sink(bulletsoil_soil* soil, const bulletsoil_sink* sink,
                                      int32_t* id) {
    return guarded(__func__, [&] {
        SoilAction& action = action_of(soil);
        required(sink, "sink");
        check_size("sink", sink->struct_size, kSinkBytesMin, sizeof(bulletsoil_sink));
        const auto added = action.soil().add_sink(from_c(widened(*sink, default_sink())));
        if (!added) refuse(added.error());
        if (id != nullptr) *id = *added;
    });
}

bulletsoil_result bulletsoil_move_source(bulletsoil_soil* soil, int32_t id,
                                         const double center_m[3], const double direction[3]) {
    return guarded(__func__, [&] {
        check(action_of(soil).soil().move_source(id, point(center_m, "center_m"),
                                                 point(direction, "direction")));
    });
}

bulletsoil_result bulletsoil_move_sink(bulletsoil_soil* soil, int32_t id, const double center_m[3],
                                       const double rotation[4]) {
    return guarded(__func__, [&] {
        check(action_of(soil).soil().move_sink(
            id, pose_of(center_m, rotation, "center_m", "rotation")));
    });
}

bulletsoil_result bulletsoil_remove_flow(bulletsoil_soil* soil, int32_t id) {
    return guarded(__func__, [&] { check(action_of(soil).soil().remove_flow(id)); });
}

bulletsoil_result bulletsoil_get_flow_mass(const bulletsoil_soil* soil, int32_t id,
                                           double* mass_kg) {
    return guarded(__func__, [&] {
        const auto state = action_of(soil).soil().flow_state(id);
        if (!state) refuse(state.error());
        required(mass_kg, "mass_kg") = state->mass_kg;
    });
}

bulletsoil_result bulletsoil_get_flow_state(const bulletsoil_soil* soil, int32_t id,
                                            bulletsoil_flow_state* state) {
    return guarded(__func__, [&] {
        const bsoil::Soil& flowing = action_of(soil).soil();
        const size_t struct_size = required(state, "state").struct_size;
        check_size("state", struct_size, kFlowStateBytesMin, sizeof *state);
        const auto known = flowing.flow_state(id);
        if (!known) refuse(known.error());
        bulletsoil_flow_state out{};
        out.units = known->units;
        out.missed_units = known->missed_units;
        out.mass_kg = known->mass_kg;
        out.missed_kg = known->missed_kg;
        narrow_into(*state, out, struct_size);
    });
}

bulletsoil_result bulletsoil_get_moved_mass(const bulletsoil_soil* soil, double* in_kg,
                                            double* out_kg) {
    return guarded(__func__, [&] {
        const bsoil::Soil& flowing = action_of(soil).soil();
        if (in_kg != nullptr) *in_kg = flowing.moved_kg(bsoil::FlowWay::in);
        if (out_kg != nullptr) *out_kg = flowing.moved_kg(bsoil::FlowWay::out);
    });
}

bulletsoil_result bulletsoil_get_flow_totals(const bulletsoil_soil* soil, size_t capacity,
                                             int64_t* units_in, int64_t* units_out) {
    return guarded(__func__, [&] {
        const bsoil::SoilTotals totals = action_of(soil).soil().totals();
        if (capacity < totals.units.size()) {
            refuse("capacity is " + std::to_string(capacity) + ", this soil has " +
                   std::to_string(totals.units.size()) + " materials; make room for them");
        }
        if (units_in != nullptr) {
            std::copy(totals.units_in.begin(), totals.units_in.end(), units_in);
        }
        if (units_out != nullptr) {
            std::copy(totals.units_out.begin(), totals.units_out.end(), units_out);
        }
    });
}

bulletsoil_result bulletsoil_get_water_totals(const bulletsoil_soil* soil, int64_t* units,
                                              int64_t* units_in, int64_t* units_out) {
    return guarded(__func__, [&] {
        const bsoil::SoilTotals totals = action_of(soil).soil().totals();
        if (units != nullptr) *units = totals.water_units;
        if (units_in != nullptr) *units_in = totals.water_units_in;
        if (units_out != nullptr) *units_out = totals.water_units_out;
    });
}

bulletsoil_result bulletsoil_get_saturation(const bulletsoil_soil* soil, const double point_m[3],
                                            double* saturation) {
    return guarded(__func__, [&] {
        const bsoil::Soil& ground = action_of(soil).soil();
        const bsoil::Vec3 where = point(point_m, "point_m");
        required(saturation, "saturation");
        const bsoil::GridFrame& frame = ground.frame();
        const bsoil::Vec3 at = frame.to_grid(where);
        if (!(at.x >= 0 && at.x < frame.size[0] && at.y >= 0 && at.y < frame.size[1] && at.z >= 0 &&
              at.z < frame.size[2])) {
            refuse("point_m is (" + std::to_string(where.x) + ", " + std::to_string(where.y) +
                   ", " + std::to_string(where.z) + "), must be in the soil's grid");
        }
        *saturation =
            ground.sample(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z))
                .saturation;
    });
}

}  // extern "C"
