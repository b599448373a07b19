/// The C interface on top of SoilAction: checks what C cannot, keeps exceptions in, says why.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "bsoil/version.h"
#include "c_calls.h"
#include "world_gravity.h"

namespace bsoil::bullet {
namespace {

/// Of the text of the last error; a longer one is cut.
constexpr size_t kErrorBytes = 1024;
/// A fixed buffer, so that saying that memory has run out needs none.
thread_local char last_error[kErrorBytes] = "";

/// The soils that exist: a handle is looked up before it is followed.
class LivingSoils {
  public:
    void add(const bulletsoil_soil* soil) {
        const std::lock_guard lock(mutex_);
        soils_.insert(soil);
    }
    bool contains(const bulletsoil_soil* soil) {
        const std::lock_guard lock(mutex_);
        return soils_.contains(soil);
    }
    bool remove(const bulletsoil_soil* soil) {
        const std::lock_guard lock(mutex_);
        return soils_.erase(soil) > 0;
    }

  private:
    std::mutex mutex_;
    std::set<const bulletsoil_soil*> soils_;
};

/// Never destroyed: objects of the host that live until the program has ended destroy soils, too.
LivingSoils& living_soils() {
    static auto& soils = *new LivingSoils;
    return soils;
}

btDiscreteDynamicsWorld& world_of(void* world) {
    required(static_cast<char*>(world), "world");
    // By the base of every world, until its kind is known.
    auto& out = *static_cast<btDynamicsWorld*>(world);
    const btDynamicsWorldType type = out.getWorldType();
    if (type != BT_DISCRETE_DYNAMICS_WORLD && type != BT_SOFT_RIGID_DYNAMICS_WORLD &&
        type != BT_SOFT_MULTIBODY_DYNAMICS_WORLD &&
        type != BT_DEFORMABLE_MULTIBODY_DYNAMICS_WORLD) {
        refuse("world has type " + std::to_string(type) +
               " and is no btDiscreteDynamicsWorld; make one, or a world that derives from it");
    }
    return static_cast<btDiscreteDynamicsWorld&>(out);
}

bsoil::SoilDef read_def(const bulletsoil_soil_def* def) {
    check_size("def", required(def, "def").struct_size, kSoilDefBytesMin, sizeof *def);
    return from_c(widened(*def, default_def()));
}

const btCollisionObject& body_of(const void* body) {
    required(static_cast<const char*>(body), "body");
    return *static_cast<const btCollisionObject*>(body);
}

template <typename Change>
void change_options(bulletsoil_soil* soil, const void* body, const Change& change) {
    SoilAction& action = action_of(soil);
    const btCollisionObject& object = body_of(body);
    BodyOptions options = action.options(object);
    change(options);
    check(action.set_options(object, options));
}

}  // namespace

bulletsoil_result fail(bulletsoil_result code, std::string_view text) {
    const size_t count = std::min(text.size(), kErrorBytes - 1);
    text.copy(last_error, count);
    last_error[count] = '\0';
    return code;
}

void check_handle(const bulletsoil_soil* soil) {
    required(soil, "soil");
    if (!living_soils().contains(soil)) {
        refuse(
            "soil is no living soil: it was destroyed, or never created; take what "
            "bulletsoil_create gave");
    }
}

}  // namespace bsoil::bullet

using namespace bsoil::bullet;

extern "C" {

const char* bulletsoil_version(void) { return bsoil::version(); }
int32_t bulletsoil_version_number(void) { return bsoil::version_number(); }
size_t bulletsoil_scalar_bytes(void) { return sizeof(btScalar); }
const char* bulletsoil_last_error(void) { return last_error; }

bulletsoil_result bulletsoil_material_init(bulletsoil_material* material, size_t struct_size,
                                           const char* built_in_name) {
    return guarded(__func__, [&] {
        required(material, "material");
        check_size("material", struct_size, kMaterialBytesMin, sizeof(bulletsoil_material));
        const std::string name = &required(built_in_name, "built_in_name");
        // Not materials::find: the name that is handed out has to last.
        for (const bsoil::MaterialDef& known : bsoil::materials::all()) {
            if (known.name == name) return narrow_into(*material, to_c(known), struct_size);
        }
        refuse(bsoil::materials::find(name).error());
    });
}

bulletsoil_result bulletsoil_soil_def_init(bulletsoil_soil_def* def, size_t struct_size) {
    return guarded(__func__, [&] {
        required(def, "def");
        check_size("def", struct_size, kSoilDefBytesMin, sizeof(bulletsoil_soil_def));
        narrow_into(*def, default_def(), struct_size);
    });
}

bulletsoil_result bulletsoil_contact_constants_init(bulletsoil_contact_constants* constants,
                                                    size_t struct_size) {
    return guarded(__func__, [&] {
        required(constants, "constants");
        check_size("constants", struct_size, kContactConstantsBytesMin,
                   sizeof(bulletsoil_contact_constants));
        narrow_into(*constants, default_contact_constants(), struct_size);
    });
}

bulletsoil_result bulletsoil_create(void* world, size_t scalar_bytes,
                                    const bulletsoil_soil_def* def, bulletsoil_soil** soil) {
    return guarded(__func__, [&] {
        required(soil, "soil") = nullptr;
        required(static_cast<char*>(world), "world");
        if (scalar_bytes != sizeof(btScalar)) {  // before the world is touched
            throw Failure{
                BULLETSOIL_WRONG_PRECISION,
                "btScalar has " + std::to_string(scalar_bytes) + " bytes in the program and " +
                    std::to_string(sizeof(btScalar)) + " in this library: link " +
                    (sizeof(btScalar) == 4 ? "bulletsoil_bullet_double" : "bulletsoil_bullet")};
        }
        const bsoil::SoilDef soil_def = read_def(def);
        check(soil_def.validate());
        btDiscreteDynamicsWorld& bullet_world = world_of(world);
        check(check_gravity(bullet_world, soil_def));
        auto action = SoilAction::create(bullet_world, soil_def);
        if (!action) throw Failure{BULLETSOIL_FAILED, action.error()};
        auto made = std::make_unique<bulletsoil_soil>();
        made->action = std::move(*action);
        living_soils().add(made.get());
        *soil = made.release();
    });
}

bulletsoil_result bulletsoil_change(bulletsoil_soil* soil, const bulletsoil_soil_def* def) {
    return guarded(__func__, [&] { check(action_of(soil).soil().change(read_def(def))); });
}

bulletsoil_result bulletsoil_destroy(bulletsoil_soil* soil) {
    return guarded(__func__, [&] {
        if (soil == nullptr) return;
        check_handle(soil);
        living_soils().remove(soil);
        delete soil;
    });
}

bulletsoil_result bulletsoil_fill_box(bulletsoil_soil* soil, const double min_m[3],
                                      const double max_m[3], const char* material) {
    return guarded(__func__, [&] {
        check(action_of(soil).fill(
            bsoil::BoxFill{{point(min_m, "min_m"), point(max_m, "max_m")}, text_of(material)}));
    });
}

bulletsoil_result bulletsoil_fill_cylinder(bulletsoil_soil* soil, const double base_center_m[3],
                                           double radius_m, double height_m, const char* material) {
    return guarded(__func__, [&] {
        check(action_of(soil).fill(bsoil::CylinderFill{point(base_center_m, "base_center_m"),
                                                       radius_m, height_m, text_of(material)}));
    });
}

bulletsoil_result bulletsoil_fill_height_map(bulletsoil_soil* soil, int32_t width, int32_t height,
                                             const float* heights_m, const char* material) {
    return guarded(__func__, [&] {
        using namespace bsoil::limits;
        SoilAction& action = action_of(soil);
        for (const auto& [name, value] : {std::pair{"width", width}, std::pair{"height", height}}) {
            if (value < kHeightMapSideMin || value > kHeightMapSideMax) {
                refuse(std::string(name) + " is " + std::to_string(value) + ", must be " +
                       std::to_string(kHeightMapSideMin) + ".." +
                       std::to_string(kHeightMapSideMax));
            }
        }
        required(heights_m, "heights_m");
        const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
        check(action.fill(bsoil::HeightMapFill{
            width, height, {heights_m, heights_m + count}, text_of(material)}));
    });
}

bulletsoil_result bulletsoil_settle(bulletsoil_soil* soil, int32_t steps_max,
                                    bulletsoil_settle_report* report) {
    return guarded(__func__, [&] {
        SoilAction& action = action_of(soil);
        const size_t struct_size = report ? report->struct_size : sizeof(bulletsoil_settle_report);
        check_size("report", struct_size, kSettleReportBytesMin, sizeof(bulletsoil_settle_report));
        const auto settled = action.settle(steps_max);
        if (!settled) {
            const bool is_lost = !action.soil().device_failure().empty();
            throw Failure{is_lost ? BULLETSOIL_FAILED : BULLETSOIL_INVALID_ARGUMENT,
                          settled.error()};
        }
        if (report == nullptr) return;
        bulletsoil_settle_report out{};
        out.is_at_rest = settled->is_at_rest ? 1 : 0;
        out.step_count = settled->step_count;
        out.block_active_count = settled->block_active_count;
        out.tile_awake_count = settled->tile_awake_count;
        narrow_into(*report, out, struct_size);
    });
}

bulletsoil_result bulletsoil_set_body_ignored(bulletsoil_soil* soil, const void* body,
                                              int32_t ignored) {
    return guarded(__func__, [&] {
        change_options(soil, body, [&](BodyOptions& options) { options.ignored = ignored != 0; });
    });
}

bulletsoil_result bulletsoil_set_body_coverage_only(bulletsoil_soil* soil, const void* body,
                                                    int32_t coverage_only) {
    return guarded(__func__, [&] {
        change_options(soil, body,
                       [&](BodyOptions& options) { options.coverage_only = coverage_only != 0; });
    });
}

bulletsoil_result bulletsoil_set_body_surface(bulletsoil_soil* soil, const void* body,
                                              double friction, double adhesion_pa) {
    return guarded(__func__, [&] {
        change_options(soil, body, [&](BodyOptions& options) {
            options.surface = {friction, adhesion_pa};
        });
    });
}

bulletsoil_result bulletsoil_set_enabled(bulletsoil_soil* soil, int32_t enabled) {
    return guarded(__func__, [&] { action_of(soil).set_enabled(enabled != 0); });
}

bulletsoil_result bulletsoil_get_body_report(const bulletsoil_soil* soil, const void* body,
                                             bulletsoil_body_report* report) {
    return guarded(__func__, [&] {
        const SoilAction& action = action_of(soil);
        const btCollisionObject& object = body_of(body);
        const size_t struct_size = required(report, "report").struct_size;
        check_size("report", struct_size, kBodyReportBytesMin, sizeof(bulletsoil_body_report));
        const BodyReport from = action.body_report(object);
        bulletsoil_body_report out{};
        copy(from.force_n, out.force_n);
        copy(from.torque_n_m, out.torque_n_m);
        out.peak_force_n = from.peak_force_n;
        out.contact_area_m2 = from.contact_area_m2;
        out.sinkage_m = from.sinkage_m;
        out.load_kg = from.load_kg;
        out.contact_patch_count = from.patch_count;
        out.is_in_contact = from.patch_count > 0 || from.load_kg > 0;
        copy(from.load_n, out.load_n);
        copy(from.through_load_n, out.through_load_n);
        narrow_into(*report, out, struct_size);
    });
}

bulletsoil_result bulletsoil_get_step_count(const bulletsoil_soil* soil, int64_t* count) {
    return guarded(__func__, [&] { required(count, "count") = action_of(soil).step_count(); });
}

bulletsoil_result bulletsoil_get_step_rate(const bulletsoil_soil* soil,
                                           bulletsoil_step_rate* rate) {
    return guarded(__func__, [&] {
        const SoilAction& action = action_of(soil);
        const size_t struct_size = required(rate, "rate").struct_size;
        check_size("rate", struct_size, kStepRateBytesMin, sizeof(bulletsoil_step_rate));
        const bsoil::StepRate from = action.soil().step_rate();
        bulletsoil_step_rate out{};
        out.due_count = from.due_count;
        out.begun_count = from.begun_count;
        out.held_count = from.held_count;
        out.call_count_most = from.call_count_most;
        out.share = from.share();
        out.call_most_ms = from.call_most_ms;
        narrow_into(*rate, out, struct_size);
    });
}

bulletsoil_result bulletsoil_get_material_count(const bulletsoil_soil* soil, size_t* count) {
    return guarded(__func__,
                   [&] { required(count, "count") = action_of(soil).soil().materials().size(); });
}

bulletsoil_result bulletsoil_get_totals(const bulletsoil_soil* soil, size_t capacity,
                                        int64_t* units, double* mass_kg) {
    return guarded(__func__, [&] {
        const bsoil::SoilTotals totals = action_of(soil).soil().totals();
        if (capacity < totals.units.size()) {
            refuse("capacity is " + std::to_string(capacity) + ", this soil has " +
                   std::to_string(totals.units.size()) + " materials; make room for them");
        }
        if (units != nullptr) std::copy(totals.units.begin(), totals.units.end(), units);
        if (mass_kg != nullptr) std::copy(totals.mass_kg.begin(), totals.mass_kg.end(), mass_kg);
    });
}

bulletsoil_result bulletsoil_get_checksum(const bulletsoil_soil* soil, uint64_t* checksum) {
    return guarded(__func__,
                   [&] { required(checksum, "checksum") = action_of(soil).soil().checksum(); });
}

bulletsoil_result bulletsoil_get_surface_height(const bulletsoil_soil* soil,
                                                const double point_m[3], double* height_m) {
    return guarded(__func__, [&] {
        const bsoil::Soil& ground = action_of(soil).soil();
        const bsoil::Vec3 where = point(point_m, "point_m");
        required(height_m, "height_m");
        const bsoil::GridFrame& frame = ground.frame();
        const bsoil::Vec3 at = frame.to_grid(where);
        if (!(at.x >= 0 && at.x < frame.size[0] && at.y >= 0 && at.y < frame.size[1])) {
            refuse("point_m is (" + std::to_string(where.x) + ", " + std::to_string(where.y) +
                   ", " + std::to_string(where.z) + "), must be above or below the soil's grid");
        }
        const double above_floor_m =
            ground.surface_height_m(static_cast<int>(at.x), static_cast<int>(at.y));
        const bsoil::Vec3 surface = frame.to_world({at.x, at.y, above_floor_m / frame.voxel_m});
        *height_m = ground.def().up == bsoil::UpAxis::y ? surface.y : surface.z;
    });
}

bulletsoil_result bulletsoil_get_status_text(const bulletsoil_soil* soil, char* buffer,
                                             size_t capacity, size_t* needed) {
    return guarded(__func__, [&] {
        const SoilAction& action = action_of(soil);
        if (capacity > 0) required(buffer, "buffer");
        std::string text;
        const auto add_line = [&text](const std::string& line) {
            if (!text.empty()) text += '\n';
            text += line;
        };
        for (const bsoil::Condition& condition : action.soil().conditions()) {
            add_line(bsoil::condition_text(condition));
        }
        for (const RefusedBody& body : action.refused()) add_line(body.reason);
        if (needed != nullptr) *needed = text.size() + 1;
        if (capacity == 0) return;
        buffer[text.copy(buffer, capacity - 1)] = '\0';
    });
}

bulletsoil_result bulletsoil_get_condition_count(const bulletsoil_soil* soil, size_t* count) {
    return guarded(__func__,
                   [&] { required(count, "count") = action_of(soil).soil().conditions().size(); });
}

bulletsoil_result bulletsoil_get_condition(const bulletsoil_soil* soil, size_t index,
                                           bulletsoil_condition* condition) {
    return guarded(__func__, [&] {
        const auto all = action_of(soil).conditions();
        const size_t struct_size = required(condition, "condition").struct_size;
        check_size("condition", struct_size, kConditionBytesMin, sizeof *condition);
        if (index >= all.size()) {
            refuse("index is " + std::to_string(index) + ", there are " +
                   std::to_string(all.size()) +
                   " conditions; ask bulletsoil_get_condition_count first");
        }
        const bsoil::Condition& known = all[index].condition;
        bulletsoil_condition out{};
        out.text = bsoil::text_of(known.bit);
        out.status_bit = static_cast<uint32_t>(known.bit);
        out.has_position = known.position_m ? 1 : 0;
        out.body = all[index].object;
        copy(known.position_m.value_or(bsoil::Vec3{}), out.position_m);
        out.first_step = known.first_step;
        out.first_time_s = known.first_time_s;
        out.last_step = known.last_step;
        out.step_count = known.step_count;
        narrow_into(*condition, out, struct_size);
    });
}

bulletsoil_result bulletsoil_clear_status(bulletsoil_soil* soil) {
    return guarded(__func__, [&] { action_of(soil).soil().clear_status(); });
}

bulletsoil_result bulletsoil_save(const bulletsoil_soil* soil, const char* path) {
    return guarded(__func__, [&] {
        check(action_of(soil).soil().save(&required(path, "path")), BULLETSOIL_FAILED);
    });
}

bulletsoil_result bulletsoil_load(bulletsoil_soil* soil, const char* path) {
    return guarded(__func__, [&] {
        check(action_of(soil).soil().load(&required(path, "path")), BULLETSOIL_FAILED);
    });
}

}  // extern "C"
