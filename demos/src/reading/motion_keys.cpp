#include "motion_keys.h"

#include <fmt/format.h>

namespace bsoil::scene {

std::vector<SchemaError> motion_key_errors(const MotionItem& motion, const JointItem* joint) {
    std::vector<SchemaError> errors;
    const auto error = [&errors](SourcePosition at, std::string text) {
        errors.push_back({at, std::move(text)});
    };
    if (motion.motion_keys.empty()) {
        error(motion.at, "a [[motion]] needs a [[motion.key]]");
        return errors;
    }
    const MotionKey& first = motion.motion_keys.front();
    for (size_t i = 0; i < motion.motion_keys.size(); ++i) {
        const MotionKey& key = motion.motion_keys[i];
        if (i > 0 && key.t_s <= motion.motion_keys[i - 1].t_s) {
            error(key.where("t_s"), "`t_s` must rise from key to key");
        }
        const int given = key.position_rad.has_value() + key.offset_m.has_value() +
                          key.velocity_rad_s.has_value() + key.velocity_m_s.has_value() +
                          (key.position_m.has_value() || key.rotation.has_value());
        if (given != 1) error(key.at, "a [[motion.key]] must give exactly one quantity");
        if (key.position_rad.has_value() != first.position_rad.has_value() ||
            key.offset_m.has_value() != first.offset_m.has_value() ||
            key.velocity_rad_s.has_value() != first.velocity_rad_s.has_value() ||
            key.velocity_m_s.has_value() != first.velocity_m_s.has_value() ||
            key.position_m.has_value() != first.position_m.has_value() ||
            key.rotation.has_value() != first.rotation.has_value()) {
            error(key.at, "all keys of a motion must give the same quantity");
        }
        const bool of_body = key.position_m || key.rotation;
        if (of_body != !motion.body.empty()) {
            error(key.at, of_body ? "`position_m` and rotations move bodies; give joints "
                                    "`position_deg`, `offset_m` or a velocity"
                                  : "a body must be moved by `position_m` and a rotation");
        }
        if (joint) {
            const bool slides = key.offset_m || key.velocity_m_s;
            if (slides != (joint->kind == "slider")) {
                error(key.at, fmt::format("joint \"{}\" is a {}: {}", joint->name, joint->kind,
                                          slides ? "give `position_deg` or `velocity_deg_s`"
                                                 : "give `offset_m` or `velocity_m_s`"));
            }
        }
    }
    if (motion.repeat_count > 1 && motion.period_s <= 0) {
        error(motion.where("period_s"), "keys that are repeated must have a `period_s`");
    } else if (motion.repeat_count > 1 && motion.period_s < motion.motion_keys.back().t_s) {
        error(motion.where("period_s"), "`period_s` must not be shorter than the keys");
    }
    return errors;
}

}  // namespace bsoil::scene
