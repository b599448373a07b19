// Sources and sinks of the C interface.
#include <cmath>

#include "c_structs.h"

namespace bsoil::bullet {

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
    if (sink.shape != BULLETSOIL_SINK_BOX && sink.shape != BULLETSOIL_SINK_SPHERE &&
        sink.shape != BULLETSOIL_SINK_CYLINDER) {
        refuse("sink.shape is " + std::to_string(sink.shape) +
               ", must be one of BULLETSOIL_SINK_...");
    }
    SinkDef out;
    out.region.kind = static_cast<ConvexShape::Kind>(sink.shape);
    out.region.half_extents_m = 0.5 * point(sink.size_m, "sink.size_m");
    out.region.radius_m = sink.radius_m;
    out.region.half_height_m = sink.height_m / 2;
    out.pose.position = point(sink.center_m, "sink.center_m");
    const double* q = sink.rotation;
    const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(size > 0.99 && size < 1.01)) refuse("sink.rotation is no unit quaternion");
    out.pose.rotation = {q[0] / size, q[1] / size, q[2] / size, q[3] / size};
    out.rate_kg_s = sink.rate_kg_s;
    out.water_kg_s = sink.water_kg_s;
    out.start_s = sink.start_s;
    out.end_s = sink.end_s;
    return out;
}

}  // namespace bsoil::bullet
