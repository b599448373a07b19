// Sources and sinks of a plan in its soils.
#include "built_world.h"

namespace bsoil::random_worlds {

void BuiltWorld::add_flows(int index) {
    Soil& soil = soils_[static_cast<size_t>(index)]->soil();
    const Pose& axes = soil.frame().grid_to_world;
    std::vector<int>& ids = flow_ids_.emplace_back();
    for (const FlowPlan& plan : plan_.soils[static_cast<size_t>(index)].flows) {
        ids.push_back(0);
        if (plan.dropped) continue;
        SourceDef source = plan.source;
        source.center_m = to_world(index, {source.center_m, Quat{}}).position;
        source.direction = rotate(axes.rotation, source.direction);
        SinkDef sink = plan.sink;
        sink.pose = axes * sink.pose;
        const Result<int> made = plan.is_source ? soil.add_source(source) : soil.add_sink(sink);
        if (made) {
            ids.back() = *made;
        } else if (made.error().find("no voxel") == std::string::npos) {  // smaller than a voxel
            error_ = "flow: " + made.error();
        }
    }
}

void BuiltWorld::change_flows(int step) {
    for (size_t i = 0; i < soils_.size(); ++i) {
        Soil& soil = soils_[i]->soil();
        const std::vector<FlowPlan>& flows = plan_.soils[i].flows;
        for (size_t k = 0; k < flows.size(); ++k) {
            const FlowPlan& plan = flows[k];
            const int id = flow_ids_[i][k];
            const bool has_ended = plan.ends_step >= 0 && plan.ends_step < step;
            if (id == 0 || has_ended) continue;
            const Pose to =
                to_world(static_cast<int>(i), {plan.moved_to_m, plan.sink.pose.rotation});
            Status done = Done{};
            if (plan.moves_step == step) {
                const Vec3 way = rotate(soil.frame().grid_to_world.rotation, plan.source.direction);
                done = plan.is_source ? soil.move_source(id, to.position, way)
                                      : soil.move_sink(id, to);
            }
            if (plan.ends_step == step) done = soil.remove_flow(id);
            if (!done && done.error().find("no voxel") == std::string::npos) {
                error_ = "flow: " + done.error();
            }
        }
    }
}

}  // namespace bsoil::random_worlds
