#include "soil/condition_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace bsoil {
namespace {

struct StatusText {
    StatusBit bit;
    const char* text;  ///< the name, a colon, what happened; what to do
};
constexpr StatusText kTexts[] = {
    {StatusBit::tile_table_full,
     "tile_table_full: soil there stood still; raise SoilDef::tile_capacity, or use larger voxels "
     "where memory is short"},
    {StatusBit::speed_clamped,
     "speed_clamped: moved slower than it should; raise SoilDef::substeps_max or shorten step_s"},
    {StatusBit::body_teleported,
     "body_teleported: a body jumped; it was placed, not swept. If it was not meant: raise "
     "SoilDef::substeps_max or shorten step_s"},
    {StatusBit::body_outside_grid,
     "body_outside_grid: a body left the grid; enlarge SoilDef::size_m, or keep the body inside"},
    {StatusBit::pose_not_finite,
     "pose_not_finite: a body with NaN or infinite pose or velocity, or with a rotation that is "
     "none, was ignored; look for what made the simulation blow up (masses, joints, time step)"},
    {StatusBit::contact_list_full,
     "contact_list_full: bodies touched soil in too many voxels, and none bore them in that step; "
     "use larger voxels, or smaller or fewer bodies in the soil"},
    {StatusBit::amount_headroom,
     "amount_headroom: a voxel holds over 16 times its room, or more momentum than that of one "
     "full "
     "of soil at 16 voxels a step; raise SoilDef::overflow_passes, leave pressed soil a way out, "
     "or "
     "shorten step_s"},
    {StatusBit::shape_refused,
     "shape_refused: a shape without size or with too many faces was ignored, or a body too many; "
     "give it a size and at most 256 faces, and a soil at most 4096 bodies"},
    {StatusBit::span_list_full,
     "span_list_full: a column has more height spans than are kept, its lowest ones do not slip; "
     "use larger voxels, or fewer layers above one another"},
    {StatusBit::gravity_differs,
     "gravity_differs: soil and bodies weigh by different ones; give the world the gravity of "
     "SoilDef::gravity_m_s2 along -SoilDef::up"},
    {StatusBit::rate_lowered,
     "rate_lowered: the soil's time went slower than the world's; raise SoilDef::step_budget_ms, "
     "or make steps cheaper (larger voxels)"},
    {StatusBit::budget_exceeded,
     "budget_exceeded: the soil took longer than its budget; raise SoilDef::step_budget_ms or "
     "step_spread_max, or make steps cheaper (larger voxels)"},
    {StatusBit::device_lost,
     "device_lost: the GPU failed, or there was no memory for a step, and the soil with it; make a "
     "new one, from a snapshot if there is one, or with the CPU's backend. BULLETSOIL_GL=checked "
     "in "
     "the environment tells more"},
};
constexpr int kBitCount = static_cast<int>(std::size(kTexts));

}  // namespace

const char* text_of(StatusBit bit) {
    for (const StatusText& entry : kTexts) {
        if (entry.bit == bit) return entry.text;
    }
    return "";
}

std::string name_of(StatusBit bit) {
    const std::string text = text_of(bit);
    return text.substr(0, text.find(':'));
}

std::vector<std::string> status_texts(uint32_t bits) {
    std::vector<std::string> texts;
    for (const StatusText& entry : kTexts) {
        if (bits & static_cast<uint32_t>(entry.bit)) texts.emplace_back(entry.text);
    }
    return texts;
}

std::string condition_text(const Condition& condition, const std::string& body_name) {
    std::string where;
    if (!body_name.empty()) {
        where = body_name + ", ";
    } else if (condition.body >= 0) {
        where = fmt::format("body {}, ", condition.body);
    }
    if (const auto& at = condition.position_m) {
        where += fmt::format("at ({:.2f}, {:.2f}, {:.2f}) m, ", at->x, at->y, at->z);
    }
    where += fmt::format("step {}, {:.3f} s", condition.first_step, condition.first_time_s);
    if (condition.step_count > 1) {
        where +=
            fmt::format("; in {} steps, the last {}", condition.step_count, condition.last_step);
    }
    return fmt::format("{} [{}]", text_of(condition.bit), where);
}

ConditionLog::ConditionLog() { list_.reserve(limits::kConditionCapacity + kBitCount); }

void ConditionLog::begin_step(int64_t step, double step_s) {
    step_ = step;
    step_s_ = step_s;
}

int ConditionLog::take_new_count() {
    const auto count = static_cast<int>(list_.size() - told_count_);
    told_count_ = list_.size();
    return count;
}

void ConditionLog::note(StatusBit bit, int body, std::optional<Vec3> position_m) {
    bits_ |= static_cast<uint32_t>(bit);
    met_bits_ |= bits_;
    const auto find = [&](int wanted) {
        return std::find_if(list_.begin(), list_.end(),
                            [&](const Condition& c) { return c.bit == bit && c.body == wanted; });
    };
    auto known = find(body);
    if (known == list_.end() && body >= 0 &&
        list_.size() >= static_cast<size_t>(limits::kConditionCapacity)) {
        body = -1;
        position_m.reset();
        known = find(body);
    }
    if (known == list_.end()) {
        Condition& made = list_.emplace_back();
        made.bit = bit;
        made.body = body;
        made.first_step = step_;
        made.first_time_s = static_cast<double>(step_) * step_s_;
        known = std::prev(list_.end());
    }
    if (!known->position_m) known->position_m = position_m;
    if (known->last_step != step_ || known->step_count == 0) {
        known->last_step = step_;
        ++known->step_count;
    }
}

void ConditionLog::clear() {
    list_.clear();
    bits_ = 0;
    told_count_ = 0;
}

Status ConditionLog::check(std::span<const Condition> list, int64_t step) {
    if (list.size() > static_cast<size_t>(limits::kConditionCapacity + kBitCount)) {
        return Error{fmt::format("has {} conditions, must have at most {}", list.size(),
                                 limits::kConditionCapacity + kBitCount)};
    }
    for (const Condition& c : list) {
        if (*text_of(c.bit) == '\0') {
            return Error{fmt::format("status bit {} of a condition must be one that there is",
                                     static_cast<uint32_t>(c.bit))};
        }
        if (c.body < -1 || c.first_step < 0 || c.first_step > c.last_step || c.last_step > step ||
            c.step_count < 1 || c.first_time_s < 0) {
            return Error{fmt::format("a condition of body {} in steps {} to {} must lie within {}",
                                     c.body, c.first_step, c.last_step, step)};
        }
    }
    return Done{};
}

void ConditionLog::replace(std::span<const Condition> list) {
    clear();
    list_.assign(list.begin(), list.end());
    for (const Condition& condition : list) bits_ |= static_cast<uint32_t>(condition.bit);
    met_bits_ |= bits_;
    told_count_ = list_.size();
}

void list(StateStream& stream, Condition& condition) {
    auto bit = static_cast<uint32_t>(condition.bit);
    bool has_position = condition.position_m.has_value();
    Vec3 position_m = condition.position_m.value_or(Vec3{});
    stream(bit, condition.body, has_position, position_m, condition.first_step,
           condition.first_time_s, condition.last_step, condition.step_count);
    if (stream.reads()) {
        condition.bit = static_cast<StatusBit>(bit);
        condition.position_m = has_position ? std::optional(position_m) : std::nullopt;
    }
}

}  // namespace bsoil
