#include "coupling_snapshot.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bsoil/limits.h"
#include "bullet_stream.h"
#include "load_bounds.h"
#include "patch_stream.h"
#include "wheel_stream.h"

namespace bsoil::bullet {
namespace {

using bullet::list;  // beside those below

/// Looks at a world, which are counted: some million years of them.
constexpr unsigned long long kScansMost = 1ull << 53;

/// Names an object by its place, and finds it there.
void list_object(StateStream& stream, const btDiscreteDynamicsWorld& world,
                 btCollisionObject*& object) {
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    int32_t index = stream.reads() ? 0 : objects.findLinearSearch(object);
    stream(index);
    if (index < 0 || index >= objects.size()) return stream.refuse();
    object = objects[index];
}

/// Whether an object can play a role: the coupling casts by it.
bool can_be(const btDiscreteDynamicsWorld& world, btCollisionObject& object, BodyRole role) {
    if (role == BodyRole::rigid) return btRigidBody::upcast(&object) != nullptr;
    if (role == BodyRole::link) {
        return btMultiBodyLinkCollider::upcast(&object) &&
               dynamic_cast<const btMultiBodyDynamicsWorld*>(&world);
    }
    return true;
}

void list(StateStream& stream, const btDiscreteDynamicsWorld& world, BodyState& body) {
    stream(body.id);
    stream.choice(body.role, BodyRole::wheel);
    if (body.role != BodyRole::wheel) list_object(stream, world, body.object);
    list(stream, body.motion);
    stream(body.is_asleep, body.weight_n, body.surface.friction, body.surface.adhesion_pa);
    if (body.id < 0 || body.id > limits::kBodyIdMost ||
        (stream.good() && body.object && !can_be(world, *body.object, body.role))) {
        stream.refuse();
    }
}

void list(StateStream& stream, BodyReport& report) {
    stream(report.force_n, report.torque_n_m, report.peak_force_n, report.contact_area_m2,
           report.sinkage_m, report.compression_m, report.load_kg, report.patch_count);
}

}  // namespace

struct CouplingSnapshot::Memory {
    struct Body {
        btCollisionObject* object = nullptr;
        BodyCollector::Tracked tracked;
    };
    int last_id = -1;
    unsigned long long scan = 0;
    std::vector<Body> bodies;
    std::vector<CoupledBody> coupled;
    std::vector<CarriedLoads::Loaded> loaded;
    std::vector<std::pair<int, Vec3>> felt_n;  ///< of loads, for reports
    std::vector<std::pair<int, SleepingLoads::Sleeper>> sleepers;
    std::vector<std::pair<int, FirstContacts::Falling>> falling;
    std::vector<VehicleMemory> vehicles;
    std::vector<GroundSurface::MetTile> surface;

    void list_body(StateStream& stream, const btDiscreteDynamicsWorld& world, Body& body);
    static bool are_carriers_sound(const CoupledBody& coupled);
    static void list_coupled(StateStream& stream, const btDiscreteDynamicsWorld& world,
                             CoupledBody& coupled);
    static void list_falling(StateStream& stream, std::pair<int, FirstContacts::Falling>& entry);
    static void list_loaded(StateStream& stream, const btDiscreteDynamicsWorld& world,
                            CarriedLoads::Loaded& loaded);
    static void list_surface(StateStream& stream, GroundSurface::MetTile& tile);
    bool is_sound() const;
};

void CouplingSnapshot::Memory::list_body(StateStream& stream, const btDiscreteDynamicsWorld& world,
                                         Body& body) {
    BodyCollector::Tracked& t = body.tracked;
    list_object(stream, world, body.object);
    stream(t.id, t.key.fingerprint, t.shape_revision, t.has_no_shapes, t.has_pose, t.last_pose,
           t.was_in_grid);
    if (t.id < -1 || t.id > limits::kBodyIdMost) stream.refuse();
}

/// By id, the ground first, each with its motion, and of every patch.
bool CouplingSnapshot::Memory::are_carriers_sound(const CoupledBody& coupled) {
    const auto& carriers = coupled.carriers;
    if (coupled.motions.size() != carriers.size()) return false;
    if (!coupled.patches.empty() && carriers.empty()) return false;
    for (size_t i = 0; i < carriers.size(); ++i) {
        if (i == 0 ? carriers[i].id != -1 : carriers[i].id <= carriers[i - 1].id) return false;
        if (coupled.motions[i].carrier != carriers[i].id) return false;
        if (carriers[i].body.object && carriers[i].body.id != carriers[i].id) return false;
    }
    return std::all_of(coupled.patches.begin(), coupled.patches.end(), [&](const auto& p) {
        return std::any_of(carriers.begin(), carriers.end(),
                           [&](const auto& carrier) { return carrier.id == p.patch.carrier; });
    });
}

void CouplingSnapshot::Memory::list_coupled(StateStream& stream,
                                            const btDiscreteDynamicsWorld& world,
                                            CoupledBody& coupled) {
    list(stream, world, coupled.body);
    stream.list(coupled.patches, 256, [&](CoupledPatch& p) {
        list(stream, p.patch);
        stream(p.offset_m, p.shear_offset_m, p.carrier_offset_m, p.carrier_shear_offset_m,
               p.friction_normal_n, p.applied_force_n, p.preload_n, p.drift_m);
    });
    stream.list(coupled.carriers, 4, [&](Carrier& carrier) {
        stream(carrier.id);
        bool is_object = carrier.body.object != nullptr;
        stream(is_object);
        if (is_object) {
            list(stream, world, carrier.body);
        } else {
            list(stream, carrier.body.motion);
        }
        carrier.left.list(stream);
    });
    stream.list(coupled.motions, 200, [&](ContactMotion& motion) {
        stream(motion.carrier, motion.linear_m_s, motion.angular_rad_s);
        list(stream, motion.motion);
        list(stream, motion.direction);
    });
    if (stream.good() && !are_carriers_sound(coupled)) stream.refuse();
    stream.list(coupled.wheel_patches, 80, [&](ContactPatch& p) { list(stream, p); });
    const bool is_wheel = coupled.body.role == BodyRole::wheel;
    const size_t most = kPatchCapacity * std::max<size_t>(1, coupled.carriers.size());
    if (coupled.patches.size() > (is_wheel ? 0 : most) ||
        coupled.wheel_patches.size() > (is_wheel ? most : 0)) {
        stream.refuse();
    }
    coupled.left.list(stream);
    stream.list(coupled.elements, 52, [&](PatchElement& element) { list(stream, element); });
    const size_t patch_count = is_wheel ? coupled.wheel_patches.size() : coupled.patches.size();
    if (!are_elements_sound(coupled.elements, patch_count)) stream.refuse();
    bool has_met = coupled.met_motion.has_value();
    stream(has_met);
    if (has_met && !coupled.met_motion) coupled.met_motion.emplace();
    if (has_met) list(stream, *coupled.met_motion);
    stream(coupled.asleep_step_count);
    if (coupled.asleep_step_count < 0) stream.refuse();
    for (double& limit_n : coupled.mean_limits_n) stream(limit_n);
    for (double& limit_n : coupled.limits_at_sleep_n) stream(limit_n);
    list(stream, coupled.report);
    stream.list(coupled.pressed, 28, [&](PressedBody& body) { stream(body.id, body.force_n); });
    std::vector<PressedSoil> pressed(coupled.memory.soil().begin(), coupled.memory.soil().end());
    stream.list(pressed, 80, [&](PressedSoil& soil) {
        stream(soil.center_m, soil.normal, soil.slid_m, soil.retreat_m);
    });
    coupled.memory.set_soil(pressed);
}

void CouplingSnapshot::Memory::list_loaded(StateStream& stream,
                                           const btDiscreteDynamicsWorld& world,
                                           CarriedLoads::Loaded& loaded) {
    list(stream, world, loaded.body);
    stream(loaded.load.body, loaded.load.mass_kg, loaded.load.center_m, loaded.load.impulse_n_s,
           loaded.load.held_kg, loaded.load.held_kg_m);
    stream(loaded.debt_n_s, loaded.debt_n_m_s, loaded.push_n, loaded.push_n_m, loaded.left_m,
           loaded.left_m_s, loaded.left_rad_s, loaded.own_mass_kg);
    list(stream, loaded.own_inertia);
    list(stream, loaded.force_n);
    list(stream, loaded.torque_n_m);
    const bool bears = loaded.body.role == BodyRole::rigid || loaded.body.role == BodyRole::link;
    if (!bears || loaded.load.body != loaded.body.id || loaded.load.mass_kg < 0 ||
        loaded.own_mass_kg < 0) {
        stream.refuse();
    }
}

void CouplingSnapshot::Memory::list_surface(StateStream& stream, GroundSurface::MetTile& tile) {
    stream(tile.tile, tile.heights.changed);
    for (auto* heights_m : {&tile.heights.settled_m, &tile.heights.before_m}) {
        for (float& height_m : *heights_m) {
            stream(height_m);
            if (!std::isfinite(height_m)) stream.refuse();
        }
    }
}

void CouplingSnapshot::Memory::list_falling(StateStream& stream,
                                            std::pair<int, FirstContacts::Falling>& entry) {
    FirstContacts::Falling& falling = entry.second;
    SurfaceSoil& surface = falling.surface;
    stream(entry.first, surface.plane.position_m, surface.plane.normal, surface.material,
           surface.relative_density, surface.saturation, surface.undisturbed, falling.lead_m_s,
           falling.speed_m_s, falling.age_s);
    const bool is_direction = std::abs(length(surface.plane.normal) - 1) < 1e-6;
    const bool is_soil = surface.material >= 0 && surface.relative_density >= -1 &&
                         surface.relative_density <= 1 && surface.saturation >= 0 &&
                         surface.saturation <= 1 && surface.undisturbed >= 0 &&
                         surface.undisturbed <= 1;
    if (entry.first < 0 || entry.first > limits::kBodyIdMost || !is_direction || !is_soil ||
        falling.speed_m_s < 0 || falling.age_s < 0) {
        stream.refuse();
    }
}

/// Ids and objects stand for themselves once.
bool CouplingSnapshot::Memory::is_sound() const {
    if (last_id < -1 || last_id > limits::kBodyIdMost) return false;
    if (scan < 1 || scan > kScansMost) return false;
    std::vector<int> ids, coupled_ids, loaded_ids, falling_ids;
    std::vector<const void*> objects;
    for (const Body& body : bodies) {
        if (body.tracked.id >= 0) ids.push_back(body.tracked.id);
        objects.push_back(body.object);
    }
    for (const VehicleMemory& vehicle : vehicles) {
        for (const WheelMemory& wheel : vehicle.wheels) ids.push_back(wheel.id);
    }
    for (const auto& c : coupled) coupled_ids.push_back(c.body.id);
    for (const auto& l : loaded) loaded_ids.push_back(l.body.id);
    for (const auto& [id, falls] : falling) falling_ids.push_back(id);
    const auto once = [](auto& values) {
        std::sort(values.begin(), values.end());
        return std::adjacent_find(values.begin(), values.end()) == values.end();
    };
    return once(ids) && once(objects) && once(coupled_ids) && once(loaded_ids) && once(falling_ids);
}

CouplingSnapshot::CouplingSnapshot() : memory_(std::make_unique<Memory>()) {}
CouplingSnapshot::CouplingSnapshot(CouplingSnapshot&&) noexcept = default;
CouplingSnapshot::~CouplingSnapshot() = default;

CouplingSnapshot CouplingSnapshot::of(const Parts& parts) {
    CouplingSnapshot out;
    Memory& m = *out.memory_;
    m.last_id = parts.collector.last_id_;
    m.scan = parts.collector.scan_;
    const btCollisionObjectArray& objects = parts.world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        const auto found = parts.collector.tracked_.find(objects[i]);
        // One that is gone, or another at its address, is met anew.
        if (found == parts.collector.tracked_.end() ||
            found->second.proxy_id != proxy_id_of(*objects[i])) {
            continue;
        }
        m.bodies.push_back({objects[i], found->second});
    }
    for (const auto& [id, coupled] : parts.coupling.coupled_) {
        if (coupled.body.role != BodyRole::wheel && !is_in_world(parts.world, coupled.body)) {
            continue;
        }
        CoupledBody& copy = m.coupled.emplace_back();
        copy.body = coupled.body;
        copy.patches = coupled.patches;
        copy.wheel_patches = coupled.wheel_patches;
        copy.left = coupled.left;
        copy.elements = coupled.elements;
        copy.met_motion = coupled.met_motion;
        copy.asleep_step_count = coupled.asleep_step_count;
        copy.mean_limits_n = coupled.mean_limits_n;
        copy.limits_at_sleep_n = coupled.limits_at_sleep_n;
        copy.report = coupled.report;
        copy.pressed = coupled.pressed;
        copy.memory = coupled.memory;
        copy.motions = coupled.motions;
        for (const Carrier& carrier : coupled.carriers) {
            Carrier& own = copy.carriers.emplace_back();
            own.id = carrier.id;
            if (carrier.body.object && is_in_world(parts.world, carrier.body)) {
                own.body = carrier.body;
                own.left = carrier.left;
            } else if (!carrier.feels()) {
                own.body.motion = carrier.body.motion;
            }
        }
    }
    for (const auto& [id, loaded] : parts.carried.loaded_) {
        if (is_in_world(parts.world, loaded.body)) m.loaded.push_back(loaded);
    }
    m.felt_n.assign(parts.carried.felt_n_.begin(), parts.carried.felt_n_.end());
    m.sleepers.assign(parts.sleeping.sleepers_.begin(), parts.sleeping.sleepers_.end());
    m.falling.assign(parts.first_contacts.bodies_.begin(), parts.first_contacts.bodies_.end());
    for (const VehicleOnSoil* wheels : parts.vehicles.attached()) {
        m.vehicles.push_back(wheels->memory());
    }
    m.surface = parts.surface.met_tiles();
    return out;
}

void CouplingSnapshot::serialize(StateStream& stream, const btDiscreteDynamicsWorld& world) {
    Memory& m = *memory_;
    stream(m.last_id, m.scan);
    stream.list(m.bodies, 70, [&](Memory::Body& body) { m.list_body(stream, world, body); });
    stream.list(m.coupled, 400,
                [&](CoupledBody& coupled) { Memory::list_coupled(stream, world, coupled); });
    stream.list(m.loaded, 200,
                [&](CarriedLoads::Loaded& loaded) { Memory::list_loaded(stream, world, loaded); });
    stream.list(m.felt_n, 28, [&](auto& felt) {
        stream(felt.first, felt.second);
        if (felt.first < 0 || felt.first > limits::kBodyIdMost) stream.refuse();
    });
    stream.list(m.sleepers, 56, [&](auto& entry) {
        auto& [id, sleeper] = entry;
        stream(id, sleeper.step_count, sleeper.mean_n, sleeper.at_sleep_n);
        if (id < 0 || id > limits::kBodyIdMost || sleeper.step_count < 0) stream.refuse();
    });
    stream.list(m.falling, 88, [&](auto& entry) { Memory::list_falling(stream, entry); });
    stream.list(m.vehicles, 300, [&](VehicleMemory& vehicle) { list(stream, vehicle); });
    stream.list(m.surface, 528,
                [&](GroundSurface::MetTile& tile) { Memory::list_surface(stream, tile); });
    if (stream.reads() && stream.good() && !m.is_sound()) stream.refuse();
}

Status CouplingSnapshot::check_same_vehicles(const SoilVehicles& here) const {
    const std::vector<VehicleOnSoil*> attached = here.attached();
    const std::vector<VehicleMemory>& saved = memory_->vehicles;
    const auto counts = [](const std::string& what, size_t in_snapshot, size_t found) {
        return Error{"is of another world: " + std::to_string(in_snapshot) + " " + what +
                     " in the snapshot, " + std::to_string(found) + " here; attach as many"};
    };
    if (saved.size() != attached.size()) {
        return counts("vehicles attached to a SoilRaycaster", saved.size(), attached.size());
    }
    for (size_t i = 0; i < saved.size(); ++i) {
        const VehicleMemory vehicle = attached[i]->memory();
        const std::string name = "vehicle " + std::to_string(i);
        if (saved[i].wheels.size() != vehicle.wheels.size()) {
            return counts("wheels of " + name, saved[i].wheels.size(), vehicle.wheels.size());
        }
        for (size_t k = 0; k < vehicle.wheels.size(); ++k) {
            const std::string differs = difference(saved[i].wheels[k], vehicle.wheels[k]);
            if (!differs.empty()) {
                return Error{"is of another world: wheel " + std::to_string(k) + " of " + name +
                             " has here " + differs + "; build it as it was"};
            }
        }
    }
    return Done{};
}

// A debt becomes a force on its body, a load a mass: any that is finite would throw a body out of
// the world, or out of float.
Status CouplingSnapshot::check_loads(const Soil& soil) const {
    const LoadBounds most(soil);
    for (const CarriedLoads::Loaded& loaded : memory_->loaded) {
        // What bears soil touches the grid, and so its centre is no farther from any soil.
        btVector3 middle;
        btScalar radius = 0;
        loaded.body.object->getCollisionShape()->getBoundingSphere(middle, radius);
        const double arm_m = most.diagonal_m + 2 * static_cast<double>(middle.length() + radius);
        const Vec3 arm = loaded.load.center_m - loaded.body.motion.center_of_mass_m;
        const struct {
            const char *what, *unit;
            double is, most;
        } amounts[] = {
            {"carries", "kg", loaded.load.mass_kg, most.mass_kg},
            {"carries soil at a distance of", "m", length(arm), arm_m},
            {"is held up by walls or holds up", "kg", std::abs(loaded.load.held_kg), most.mass_kg},
            {"is held up or holds up", "kg m",
             length(loaded.load.held_kg_m -
                    loaded.load.held_kg * loaded.body.motion.center_of_mass_m),
             most.mass_kg * arm_m},
            {"gave soil", "N s", length(loaded.load.impulse_n_s), most.impulse_n_s},
            {"owes", "N s", length(loaded.debt_n_s), most.impulse_n_s},
            {"owes", "N m s", length(loaded.debt_n_m_s), most.impulse_n_s * arm_m},
            {"had moved with", "N s", loaded.load.mass_kg * length(loaded.left_m_s),
             most.impulse_n_s},
            {"had turned with", "N s",
             loaded.load.mass_kg * length(arm) * length(loaded.left_rad_s), most.impulse_n_s},
            {"is pushed by", "N", length(loaded.push_n), most.impulse_n_s / most.step_s},
            {"is pushed by", "N m", length(loaded.push_n_m),
             most.impulse_n_s * arm_m / most.step_s},
        };
        for (const auto& amount : amounts) {
            if (amount.is <= amount.most) continue;
            char text[300];
            std::snprintf(text, sizeof text,
                          "is damaged: body %d %s %.3g %s for its load, and all soil that the grid "
                          "can hold allows %.3g%s",
                          loaded.body.id, amount.what, amount.is, amount.unit, amount.most,
                          kTakeAnotherCopy);
            return Error{text};
        }
    }
    return Done{};
}

void CouplingSnapshot::put_into(const Parts& parts) {
    Memory& m = *memory_;
    BodyCollector& collector = parts.collector;
    collector.last_id_ = m.last_id;
    collector.scan_ = m.scan;
    collector.tracked_.clear();
    collector.bodies_.clear();
    collector.refused_.clear();
    std::fill(collector.id_taken_.begin(), collector.id_taken_.end(), false);
    for (Memory::Body& body : m.bodies) {
        // Its shapes are converted again when it is next seen.
        body.tracked.key.shape = body.object->getCollisionShape();
        body.tracked.proxy_id = proxy_id_of(*body.object);
        body.tracked.seen_in_scan = m.scan;
        if (body.tracked.id >= 0) collector.id_taken_[static_cast<size_t>(body.tracked.id)] = true;
        collector.tracked_[body.object] = std::move(body.tracked);
    }
    for (const VehicleMemory& vehicle : m.vehicles) {
        for (const WheelMemory& wheel : vehicle.wheels) {
            collector.id_taken_[static_cast<size_t>(wheel.id)] = true;
        }
    }
    // The world may have given its objects other ids.
    const btCollisionObjectArray& objects = parts.world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        const auto options = collector.options_.find(objects[i]);
        if (options == collector.options_.end()) continue;
        options->second.proxy_id = proxy_id_of(*objects[i]);
        options->second.seen_in_scan = m.scan;
    }
    parts.coupling.take_rows_out();
    parts.coupling.set_bodies({});
    parts.coupling.coupled_.clear();
    for (CoupledBody& coupled : m.coupled) {
        if (coupled.body.object) remember_identity(coupled.body);
        for (Carrier& carrier : coupled.carriers) {
            if (carrier.body.object) remember_identity(carrier.body);
        }
        const int id = coupled.body.id;
        parts.coupling.coupled_.emplace(id, std::move(coupled));
    }
    parts.carried.close_substep(0);
    parts.carried.loaded_.clear();
    for (CarriedLoads::Loaded& loaded : m.loaded) {
        remember_identity(loaded.body);
        parts.carried.loaded_[loaded.body.id] = loaded;
    }
    parts.carried.felt_n_ = {m.felt_n.begin(), m.felt_n.end()};
    parts.sleeping.sleepers_ = {m.sleepers.begin(), m.sleepers.end()};
    parts.first_contacts.bodies_ = {m.falling.begin(), m.falling.end()};
    const std::vector<VehicleOnSoil*> attached = parts.vehicles.attached();
    for (size_t i = 0; i < attached.size(); ++i) attached[i]->set_memory(m.vehicles[i]);
    parts.surface.set_met_tiles(m.surface);
}

}  // namespace bsoil::bullet
