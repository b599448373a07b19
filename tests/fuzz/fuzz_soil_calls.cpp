#include <cmath>

#include "bsoil/distance_lattice.h"
#include "bsoil/soil.h"
#include "bsoil/surface_mesh.h"
#include "targets.h"

namespace bsoil::fuzz {
namespace {

Vec3 soil_vector(Choices& c, double reach) {
    const double x = c.number(-reach, reach), y = c.number(-reach, reach),
                 z = c.number(-reach, reach);
    return {x, y, z};
}

Pose pose(Choices& c, double reach) {
    Pose p{soil_vector(c, reach), {}};
    if (c.flag()) {
        const Vec3 v = soil_vector(c, 1);
        p.rotation = {v.x, v.y, v.z, c.number(-1, 1)};
        const double n = std::sqrt(dot(v, v) + p.rotation.w * p.rotation.w);
        if (!c.flag() && n > 1e-9 && std::isfinite(n)) {
            p.rotation = {v.x / n, v.y / n, v.z / n, p.rotation.w / n};
        }
    }
    return p;
}

ConvexShape shape(Choices& c) {
    ConvexShape s;
    s.kind = static_cast<ConvexShape::Kind>(c.below(7));
    s.local = pose(c, 0.3);
    s.half_extents_m = {c.number(-0.1, 0.5), c.number(-0.1, 0.5), c.number(-0.1, 0.5)};
    s.radius_m = c.number(-0.05, 0.5);
    s.half_height_m = c.number(-0.05, 0.5);
    s.rounding_m = c.number(-0.02, 0.1);
    if (s.kind == ConvexShape::Kind::hull) {
        const int count = c.below(12);
        for (int i = 0; i < count; ++i) {
            const Vec3 n = soil_vector(c, 1);
            const double l = length(n);
            s.planes.push_back({c.flag() && l > 1e-9 ? n * (1 / l) : n, c.number(-0.1, 0.5)});
        }
        s.bound_m = c.number(-0.1, 1);
    }
    if (s.kind == ConvexShape::Kind::lattice && c.flag()) {
        TriangleMesh mesh;
        for (int i = 0; i < 4 + c.below(6); ++i) mesh.vertices.push_back(soil_vector(c, 0.5));
        for (int i = 0; i < 4 + c.below(8); ++i) {
            mesh.triangles.push_back({c.below(8) - 1, c.below(8), c.below(8)});
        }
        const auto made = DistanceLattice::from_mesh(mesh, {.voxel_m = 0.1});
        if (made) s.lattice = *made;
    }
    return s;
}

/// A soil and the bodies that calls have given it.
class SoilCaller {
  public:
    explicit SoilCaller(Choices& choices) : c_(choices) {
        SoilDef def;
        def.backend = Backend::cpu;
        def.thread_count = 1;
        def.voxel_m = 0.1;
        def.up = c_.flag() ? UpAxis::y : UpAxis::z;
        def.size_m = {0.1 * (1 + c_.below(20)), 0.1 * (1 + c_.below(20)), 0.1 * (1 + c_.below(20))};
        def.yaw_rad = c_.flag() ? c_.number(-7, 7) : 0;
        if (c_.flag()) def.materials = {materials::dry_sand(), materials::clay()};
        if (c_.flag()) def.tile_capacity = 1 + c_.below(4);
        if (c_.flag()) {
            def.gravity_m_s2 = c_.number(0, 30);
            def.step_s = c_.number(1.0 / 2000, 1.0 / 20);
            def.substeps_max = c_.below(34);
            def.propagation_iterations = c_.below(10);
            def.overflow_passes = c_.below(10);
            def.overflow = static_cast<OverflowHeuristic>(c_.below(4));
            def.floor_center_m = soil_vector(c_, 10);
            def.material.density_kg_m3 = c_.number(200, 4000);
            def.material.friction_angle_rad = c_.number(0, 1.2);
            def.material.cohesion_pa = c_.number(0, 2e5);
            // A piece a call, the same on every machine. It takes no byte of its own, so that
            // seeds stay what they were.
            if (def.propagation_iterations % 4 == 3) def.step_budget_ms = 1e-6;
        }
        auto made = Soil::create(def);
        if (made) soil_ = std::move(*made);
    }

    void run() {
        for (int i = 0; soil_ && i < 24 && !c_.at_end(); ++i) call();
    }

  private:
    std::string material() { return c_.below(4) == 0 ? "clay" : c_.below(8) == 0 ? "?" : ""; }

    /// Only a fill that succeeds adds soil; nothing takes any away.
    void after(const Status* fill = nullptr) {
        const std::vector<int64_t> units = soil_->totals().units;
        if (units_.empty()) units_.assign(units.size(), 0);
        bool grew = false;
        for (size_t m = 0; m < units.size(); ++m) {
            require(units[m] >= units_[m], "soil is lost");
            grew |= units[m] > units_[m];
        }
        require(fill ? grew == fill->ok() : !grew, "soil appears, or a fill without soil succeeds");
        units_ = units;
    }

    void call() {
        const Vec3 at = soil_->def().floor_center_m;
        switch (c_.below(12)) {
            case 0: {
                const Vec3 a = soil_vector(c_, 2) + at, b = soil_vector(c_, 2) + at;
                const Status filled = soil_->fill(BoxFill{{a, b}, material()});
                return after(&filled);
            }
            case 1: {
                const Vec3 base = soil_vector(c_, 2) + at;
                const Status filled =
                    soil_->fill(CylinderFill{base, c_.number(0, 2), c_.number(0, 2), material()});
                return after(&filled);
            }
            case 2: {
                NoiseFill fill;
                fill.base_m = c_.number(0, 2);
                fill.amplitude_m = c_.number(0, 2);
                fill.wavelength_m = c_.number(0.1, 10);
                fill.octaves = c_.below(14);
                fill.persistence = c_.number(0, 1);
                fill.material = material();
                const Status filled = soil_->fill(fill);
                return after(&filled);
            }
            case 3: {
                HeightMapFill fill;
                fill.width = c_.below(6);
                fill.height = c_.below(6);
                for (int i = 0; i < fill.width * fill.height; ++i) {
                    fill.heights_m.push_back(static_cast<float>(c_.number(-1, 2)));
                }
                if (c_.below(8) == 0) fill.heights_m.push_back(1);
                const Status filled = soil_->fill(fill);
                return after(&filled);
            }
            case 4: {
                const Vec3 n = soil_vector(c_, 1);
                const double level = c_.number(-1, 1);
                static_cast<void>(
                    soil_->add_terrain([=](Vec3 p) { return level - dot(n, p - at); }));
                return after();
            }
            case 5: {
                TriangleMesh mesh;
                const Vec3 low = soil_vector(c_, 2) + at, high = soil_vector(c_, 2) + at;
                for (int i = 0; i < 8; ++i) {
                    mesh.vertices.push_back(
                        {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
                }
                mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                  {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
                if (c_.below(8) == 0) mesh.triangles.pop_back();
                if (c_.below(8) == 0) mesh.triangles[0][0] = c_.below(200) - 100;
                static_cast<void>(soil_->add_terrain(mesh));
                return after();
            }
            case 6:
                return save_and_load();
            case 7:
                return look();
            case 8:
                return bodies_.size() < 4 ? add_body() : change();
            default:
                return step();
        }
    }

    void change() {
        SoilDef def = soil_->def();
        MaterialDef& material = def.materials.empty() ? def.material : def.materials.back();
        material.friction_angle_rad = c_.number(0, 1.2);
        material.cohesion_pa = c_.number(0, 2e5);
        material.roughness = c_.flag() ? c_.number(0, 40) : 0;
        material.viscosity = c_.flag() ? c_.number(0, 1) : 0;
        material.fall_speed_m_s = c_.flag() ? c_.number(0, 100) : 0;
        if (c_.flag()) {
            def.wind_m_s = soil_vector(c_, 50);
            def.substeps_max = c_.below(34);
            def.propagation_iterations = c_.below(10);
        }
        if (c_.below(8) == 0) material.density_kg_m3 = c_.number(200, 4000);
        const double density = soil_->materials().back().density_kg_m3;
        if (soil_->change(def)) {
            require(soil_->materials().back().density_kg_m3 == density, "a density has changed");
        }
        after();
    }

    void add_body() {
        Body& b = bodies_.emplace_back();
        for (int i = 0; i < 1 + c_.below(3); ++i) b.shapes.push_back(shape(c_));
        b.body.id = c_.below(8) == 0 ? c_.below(70'000) - 10 : static_cast<int>(bodies_.size());
        b.body.pose = pose(c_, 1.5);
        b.body.is_static = c_.below(4) == 0;
        b.body.surface = {c_.number(-1, 2), c_.number(-1, 1e5)};
    }

    void step() {
        std::vector<SoilBody> input;
        for (Body& b : bodies_) {
            if (c_.below(8) == 0) continue;
            SoilBody& body = b.body;
            if (c_.flag()) body.pose = pose(c_, 1.5);
            body.pose.position += soil_vector(c_, 0.2);
            body.center_of_mass_m = body.pose.position;
            body.linear_velocity_m_s = soil_vector(c_, c_.flag() ? 3 : 300);
            body.angular_velocity_rad_s = soil_vector(c_, 10);
            body.contact_pressure_pa = c_.number(0, 1e6);
            body.contact_width_m = c_.number(0, 1);
            if (c_.below(16) == 0) ++body.shape_revision;
            body.shapes = &b.shapes;
            input.push_back(body);
        }
        if (c_.below(16) == 0 && !input.empty()) input.push_back(input.front());
        const StepReport report = soil_->step(input);
        for (const ContactVoxel& contact : report.contacts) {
            require(is_finite(contact.position_m) && is_finite(contact.normal) &&
                        std::isfinite(contact.area_m2) && std::isfinite(contact.depth_m) &&
                        std::isfinite(contact.gap_m) && std::isfinite(contact.compression_m),
                    "a contact is not finite");
        }
        for (const BodyLoad& load : report.loads) {
            require(load.mass_kg >= 0 && is_finite(load.center_m), "a load is not finite");
        }
        after();
    }

    void save_and_load() {
        const auto saved = soil_->checked_state();
        if (!saved) {  // more is in a voxel than goes on from a snapshot, and it was said
            if (saved.error().find("amount_headroom") == std::string::npos) fail(saved.error());
            return;
        }
        const std::vector<uint8_t>& state = *saved;
        const uint64_t checksum = soil_->checksum();
        auto other = Soil::create(soil_->def());
        require(other.ok(), "the same soil cannot be made again");
        const auto put = (*other)->prepare(state);
        if (!put) fail("a soil's own state is refused: " + put.error());
        (*put)();
        require((*other)->checksum() == checksum, "a state comes back as another");
        soil_ = std::move(*other);
        after();
    }

    void look() {
        const int x = c_.below(40) - 10, y = c_.below(40) - 10, z = c_.below(40) - 10;
        soil_->sample(x, y, z);
        soil_->surface_height_m(x, y);
        require(soil_->mass_inside_kg(shape(c_), pose(c_, 1)) >= 0, "a mass is negative");
        soil_->memory_use();
        if (c_.flag()) soil_->clear_status();
        status_texts(soil_->status_bits());
        const SoilTiles tiles(*soil_);
        SurfaceMesher mesher(tiles);
        mesher.update();
    }

    struct Body {
        std::vector<ConvexShape> shapes;
        SoilBody body;
    };

    Choices& c_;
    std::unique_ptr<Soil> soil_;
    std::vector<Body> bodies_;
    std::vector<int64_t> units_;
};

}  // namespace

void fuzz_soil_calls(Bytes bytes) { run_calls<SoilCaller>(bytes); }

}  // namespace bsoil::fuzz
