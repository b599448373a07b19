#include "stage_bench.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <tuple>

namespace bsoil {

using namespace layout;

namespace {

constexpr double kUnit = 1.0 / kVoxelFull;
constexpr int kBodyCount = 3;

}  // namespace

StageBench::StageBench(const SoilDef& def)
    : soil_(make_soil(def)), impl_(&SoilProbe::impl(*soil_)) {
    Soil::Impl& s = *impl_;
    s.step_index = 1;
    s.params.step_stamp = 2;
    for (size_t index = 0; index < s.tiles.size(); ++index) s.tiles.wake(static_cast<int>(index));
    s.lists.mark_all();
    s.tiles.upload();
    std::vector<int> ids;
    for (int i = 0; i < kBodyCount; ++i) {
        ids.push_back(i);
        tracks_.emplace_back().index = i;
    }
    s.bodies.restart({}, ids);
    write(empty_planes());
}

int StageBench::slot_of(int x, int y) const {
    return impl_->tiles[impl_->tile_index(x / 8, y / 8)]->slot;
}

StatePlanes StageBench::empty_planes() const {
    StatePlanes planes{impl_->frame.size[0],
                       impl_->frame.size[1],
                       impl_->height,
                       kTransportFirst + impl_->params.transport_count,
                       {}};
    planes.words.assign(static_cast<size_t>(planes.nx) * planes.ny * planes.nz * planes.plane_count,
                        0);
    return planes;
}

void StageBench::write(const StatePlanes& planes) {
    const SoilParams& p = impl_->params;
    std::vector<int32_t> words(static_cast<size_t>(p.tile_voxels));
    for (int slot = 0; slot < impl_->tiles.slot_count(); ++slot) {
        const int tile = impl_->tiles.slot_tiles()[slot];
        if (tile < 0) continue;
        for (int plane = 0; plane < planes.plane_count; ++plane) {
            for (int v = 0; v < p.tile_voxels; ++v) {
                words[v] = planes.at(plane, tile % impl_->tiles_x * 8 + v % 8,
                                     tile / impl_->tiles_x * 8 + v / 8 % 8, v / 64);
            }
            impl_->device->write(Buffer::state,
                                 int64_t{plane} * p.plane_stride + int64_t{slot} * p.tile_voxels,
                                 words);
        }
    }
    impl_->device->fill_zero(Buffer::block_flags, 0,
                             int64_t{kFlagArrays} * impl_->tiles.block_count());
    impl_->params.pass_stamp = impl_->params.chance = 1;
    impl_->tiles.forget_stamps();
    for (int slot = 0; slot < impl_->tiles.slot_count(); ++slot) {
        impl_->tiles.note_stale(slot, true);
        impl_->tiles.stamp_columns(slot);
    }
    for (const auto& tile : impl_->tiles) tile->top = planes.nz;
    impl_->lists.build();
    place({});
    write_speeds(
        std::vector<int32_t>(static_cast<size_t>(planes.nx) * planes.ny * kSpanCapacity, 0));
}

StatePlanes StageBench::read() const {
    StatePlanes planes = empty_planes();
    const SoilParams& p = impl_->params;
    std::vector<int32_t> words(static_cast<size_t>(p.tile_voxels));
    for (int slot = 0; slot < impl_->tiles.slot_count(); ++slot) {
        const int tile = impl_->tiles.slot_tiles()[slot];
        if (tile < 0) continue;
        for (int plane = 0; plane < planes.plane_count; ++plane) {
            impl_->device->read(Buffer::state,
                                int64_t{plane} * p.plane_stride + int64_t{slot} * p.tile_voxels,
                                words);
            for (int v = 0; v < p.tile_voxels; ++v) {
                planes.at(plane, tile % impl_->tiles_x * 8 + v % 8,
                          tile / impl_->tiles_x * 8 + v / 8 % 8, v / 64) = words[v];
            }
        }
    }
    return planes;
}

// Looks at every column, whatever was looked at before.
void StageBench::run(Kernel kernel, const ListedWork& work) {
    SoilParams& p = impl_->params;
    p.support_stamp = p.spans_stamp = p.slip_stamp = p.slide_stamp = -1;
    impl_->passes.run(kernel, work);
}

// As if every column of every block were in these masks.
void StageBench::fill_masks(std::initializer_list<int> masks) {
    const int64_t blocks = impl_->tiles.block_count();
    const int32_t all[2] = {-1, -1};
    for (int64_t block = 0; block < blocks; ++block) {
        for (int mask : masks) {
            impl_->device->write(Buffer::block_flags,
                                 kFlagArrays * blocks + block * kMaskWords + mask, all);
        }
    }
}

void StageBench::place(const std::vector<Mover>& movers) {
    std::vector<StepBody> step_bodies;
    for (size_t i = 0; i < movers.size(); ++i) {
        const Pose pose = impl_->world_to_grid * movers[i].body.pose;
        step_bodies.push_back({&movers[i].body, &tracks_[i], pose, pose, true});
    }
    impl_->params.push_speed = kOneQ16;  // some of what they push could go faster
    impl_->shapes.upload(step_bodies, impl_->bodies.ids(), 1);
    impl_->lists.build_pairs(impl_->shapes);
    run(Kernel::clear_coverage, impl_->lists.rebuild());
    run(Kernel::voxelize_shapes, impl_->lists.pairs());
}

void StageBench::find_support() { run(Kernel::find_support, impl_->lists.tiles()); }

void StageBench::apply_force() {
    impl_->stamps.begin_pass();
    run(Kernel::apply_force, impl_->lists.listed());
}

void StageBench::propagate_force() {
    impl_->stamps.begin_pass();
    run(Kernel::propagate_force, impl_->lists.listed());
    run(Kernel::apply_flow, impl_->lists.listed());
}

void StageBench::advect(int substeps, int substep) {
    impl_->params.substep_count = substeps;
    impl_->params.substep = substep;
    impl_->stamps.begin_pass();
    run(Kernel::advect_soil, impl_->lists.listed());
    run(Kernel::apply_flow, impl_->lists.listed());
    impl_->params.substep_count = 1;
}

void StageBench::resolve_overflow(OverflowHeuristic heuristic) {
    fill_masks({kMaskExcess, kMaskOverflow});
    impl_->params.overflow_heuristic = static_cast<int>(heuristic);
    impl_->stamps.begin_pass();
    run(Kernel::resolve_overflow, impl_->lists.listed());
    run(Kernel::apply_flow, impl_->lists.listed());
}

void StageBench::build_spans() {
    impl_->device->fill_zero(Buffer::result, 0, kResultHeader);
    run(Kernel::build_spans, impl_->lists.tiles());
}

void StageBench::find_failures() {
    impl_->stamps.begin_pass();
    run(Kernel::find_failures, impl_->lists.tiles());
    run(Kernel::break_bonds, impl_->lists.tiles());
}

void StageBench::find_failures_again() {
    impl_->params.fails_near = 1;
    find_failures();
    impl_->params.fails_near = 0;
}

int64_t StageBench::cut_word_at(int x, int y) const {
    return impl_->tiles.column_array_offset(kColumnFailing, slot_of(x, y)) + y % 8 * 8 + x % 8;
}

std::vector<double> StageBench::read_cuts() const {
    std::vector<double> heights;
    for (int y = 0; y < impl_->frame.size[1]; ++y) {
        for (int x = 0; x < impl_->frame.size[0]; ++x) {
            int32_t word = 0;
            impl_->device->read(Buffer::spans, cut_word_at(x, y), {&word, 1});
            heights.push_back(word == 0 ? std::numeric_limits<double>::infinity()
                                        : (kCutNone - word) * kUnit);
        }
    }
    return heights;
}

void StageBench::write_cuts(const std::vector<double>& heights) {
    size_t next = 0;
    for (int y = 0; y < impl_->frame.size[1]; ++y) {
        for (int x = 0; x < impl_->frame.size[0]; ++x, ++next) {
            const int32_t word =
                std::isinf(heights[next])
                    ? 0
                    : kCutNone - static_cast<int32_t>(std::lround(heights[next] * kVoxelFull));
            impl_->device->write(Buffer::spans, cut_word_at(x, y), {&word, 1});
        }
    }
    const std::vector<int32_t> steps(static_cast<size_t>(impl_->tiles.slot_count()),
                                     impl_->params.step_stamp);
    impl_->device->write(Buffer::spans, impl_->tiles.tile_array_offset(kTileCut, 0), steps);
}

void StageBench::slip(int substeps, int stride) {
    impl_->params.substep_count = substeps;
    impl_->params.slip_stride = stride;
    impl_->stamps.begin_pass();
    run(Kernel::slip_soil, impl_->lists.tiles());
    run(Kernel::apply_flow, impl_->lists.listed());
    impl_->params.substep_count = 1;
}

void StageBench::move_water() {
    impl_->stamps.begin_pass();
    run(Kernel::move_water, impl_->lists.tiles());
    run(Kernel::apply_flow, impl_->lists.listed());
}

void StageBench::slide(int passes) {
    impl_->params.slide_count = passes;
    impl_->stamps.begin_pass();
    run(Kernel::slow_slides, impl_->lists.tiles());
    run(Kernel::slide_soil, impl_->lists.tiles());
    run(Kernel::apply_flow, impl_->lists.listed());
}

std::vector<std::array<int32_t, kContactWords>> StageBench::collect_contacts() {
    impl_->device->fill_zero(Buffer::result, 0, impl_->params.contact_offset);
    run(Kernel::collect_contacts, impl_->lists.contacts());
    int32_t header[kResultHeader];
    impl_->device->read(Buffer::result, 0, header);
    std::vector<std::array<int32_t, kContactWords>> contacts(
        static_cast<size_t>(header[kResultContacts]));
    for (size_t i = 0; i < contacts.size(); ++i) {
        impl_->device->read(Buffer::result,
                            impl_->params.contact_offset + static_cast<int64_t>(i) * kContactWords,
                            contacts[i]);
    }
    std::sort(contacts.begin(), contacts.end(), [](const auto& a, const auto& b) {
        constexpr int kAt = kContactAt;
        return std::tie(a[kAt + 2], a[kAt + 1], a[kAt]) < std::tie(b[kAt + 2], b[kAt + 1], b[kAt]);
    });
    return contacts;
}

int64_t StageBench::column_words_at(int x, int y) const {
    return (int64_t{slot_of(x, y)} * kTileColumns + y % 8 * 8 + x % 8) * kColumnWords;
}

std::vector<int32_t> StageBench::read_column(int x, int y) const {
    std::vector<int32_t> words(kColumnWords);
    impl_->device->read(Buffer::spans, column_words_at(x, y), words);
    return words;
}

int32_t StageBench::read_surface(int x, int y) const {
    int32_t word = 0;
    impl_->device->read(
        Buffer::spans,
        impl_->tiles.column_array_offset(kColumnSurface, slot_of(x, y)) + y % 8 * 8 + x % 8,
        {&word, 1});
    return word;
}

void StageBench::write_speeds(const std::vector<int32_t>& speeds) {
    impl_->params.slip_turn = 0;
    for (int slot = 0; slot < impl_->tiles.slot_count(); ++slot) {
        impl_->tiles.write_columns(slot, kColumnSlides, 1);
    }
    size_t next = 0;
    for (int y = 0; y < impl_->frame.size[1]; ++y) {
        for (int x = 0; x < impl_->frame.size[0]; ++x, next += kSpanCapacity) {
            impl_->device->write(Buffer::spans, column_words_at(x, y) + kColumnSpeed,
                                 std::span(speeds).subspan(next, kSpanCapacity));
        }
    }
}

std::vector<int32_t> StageBench::read_speeds() const {
    std::vector<int32_t> speeds;
    for (int y = 0; y < impl_->frame.size[1]; ++y) {
        for (int x = 0; x < impl_->frame.size[0]; ++x) {
            const std::vector<int32_t> column = read_column(x, y);
            const auto first = column.begin() + kColumnSpeed + kSpanCapacity;
            speeds.insert(speeds.end(), first, first + kSpanCapacity);
        }
    }
    return speeds;
}

uint32_t StageBench::result_status() const {
    int32_t word = 0;
    impl_->device->read(Buffer::result, kResultStatus, {&word, 1});
    return static_cast<uint32_t>(word);
}

oracle::Field StageBench::to_field(const StatePlanes& planes) const {
    oracle::Field field(planes.nx, planes.ny, planes.nz);
    field.for_each([&](int x, int y, int z) {
        oracle::Voxel& voxel = field.at(x, y, z);
        const auto word = [&](int plane) { return planes.at(plane, x, y, z); };
        voxel.soil = word(kPlaneVolume) * kUnit;
        voxel.bond = word(kPlaneBond) * kUnit;
        voxel.terrain = word(kPlaneTerrain) * kUnit;
        voxel.bodies = word(kPlaneCoverage) * kUnit;
        voxel.owner = (word(kPlaneOwner) & 0xffff) - 1;
        constexpr double kMomentumUnit = kUnit / kVelocityOne;
        voxel.momentum =
            Vec3{word(kPlaneMomentumX) * kMomentumUnit, word(kPlaneMomentumY) * kMomentumUnit,
                 word(kPlaneMomentumZ) * kMomentumUnit};
        voxel.force = {static_cast<double>(word(kPlaneForceX)),
                       static_cast<double>(word(kPlaneForceY)),
                       static_cast<double>(word(kPlaneForceZ))};
        for (int m = 0; m < impl_->params.material_count; ++m) {
            voxel.mass[static_cast<size_t>(m)] = word(kPlaneMaterial + m) * kUnit;
        }
        if (const int plane = impl_->params.water_plane; plane > 0) {
            voxel.water = word(plane) * kUnit / kWaterParts;
        }
        const int support = word(kPlaneSupport);
        using Kind = oracle::Support::Kind;
        voxel.support = support >= kSupportBody
                            ? oracle::Support{Kind::body, support - kSupportBody}
                        : support == kSupportGround ? oracle::Support{Kind::ground, -1}
                                                    : oracle::Support{};
    });
    return field;
}

oracle::Model StageBench::model(int substeps) const {
    oracle::Model model{.solid_coverage = kSolidCoverage * kUnit,
                        .support_slack = kSupportSlack * kUnit,
                        .carry_slack = kCarrySlack * kUnit,
                        .elastic_excess = kElasticExcess * kUnit,
                        .excess_tolerance = kExcessTolerance * kUnit,
                        .push_room = kPushRoom * kUnit,
                        .pushed_most = kPushedMost * kUnit,
                        .crowded_least = kCrowdedLeast * kUnit,
                        .still_speed = impl_->params.still_speed * kUnit,
                        .push_speed = impl_->params.push_speed * kUnit,
                        .push_least = impl_->params.arch_speed * kUnit,
                        .body_substeps = impl_->params.body_substep_count,
                        .follow_most = kFollowMost * kUnit,
                        .held_reach = kHeldReach,
                        .arch_reach = impl_->params.arch_reach,
                        .arch_least = kArchLeast * kUnit,
                        .arch_shortest = kArchShortest,
                        .speck = kShareLeast * kUnit,
                        .mass_speck = impl_->params.material_count * kUnit,
                        .thin = kPacingLeast * kUnit,
                        .crumb = kWholeMost * kUnit,
                        .slip_tolerance = kSlipTolerance * kUnit,
                        .span_capacity = kSpanCapacity,
                        .gravity = impl_->params.gravity_q16 * kUnit,
                        .substeps = substeps,
                        .friction_angle_rad = {},
                        .friction_speed = {},
                        .loose_volume = {},
                        .compacted_volume = {},
                        .placed_volume = {},
                        .critical_density = {},
                        .roughness = {},
                        .viscosity = {},
                        .air = {},
                        .wind = {}};
    model.slides = impl_->params.slides != 0;
    model.regains = impl_->params.regains_cohesion != 0;
    model.dilates = impl_->params.dilates != 0;
    const SoilParams& p = impl_->params;
    model.wind = kUnit * Vec3{1.0 * p.wind_x, 1.0 * p.wind_y, 1.0 * p.wind_z};
    model.gust = p.gust * kUnit;
    model.gust_cell = p.gust_cell;
    model.gust_x = p.gust_x / 256.0;
    model.gust_y = p.gust_y / 256.0;
    model.shelter = p.shelter;
    model.step_s = impl_->def.step_s;
    model.pass = static_cast<uint32_t>(p.chance);  // of the last pass
    model.slide_kick = impl_->params.slide_kick * kUnit / kOneQ8;
    model.slide_count = impl_->params.slide_count;
    for (const MaterialDef& material : impl_->materials) {
        if (p.bank_strength > 0) {
            const double weight = material.density_kg_m3 * impl_->def.gravity_m_s2;
            model.cohesion_height.push_back(material.cohesion_pa / weight / impl_->def.voxel_m);
        }
        model.friction_angle_rad.push_back(material.friction_angle_rad);
        // As coarse as the kernels' words are.
        const double speed = material.tool_friction * model.gravity * kOneQ16;
        model.friction_speed.push_back(std::round(speed) / kOneQ16);
        const auto volume = [&](double density) {
            return material.has_density_range() ? kReferenceDensity / density : 0;
        };
        model.loose_volume.push_back(volume(material.loose_density_kg_m3));
        model.compacted_volume.push_back(volume(material.compacted_density_kg_m3));
        model.placed_volume.push_back(kReferenceDensity / material.density_kg_m3);
        if (p.dilates != 0) {
            model.critical_density.push_back(material.dilatancy_angle_rad > 0 ? 0.2 : 0);
        }
        if (p.air != 0) {
            const double fall_speed = material.fall_speed_m_s;
            const double rate =
                fall_speed > 0 ? impl_->def.gravity_m_s2 * impl_->def.step_s / fall_speed : 0;
            model.air.push_back(std::min(kAirMost * kUnit, rate));
        }
        if (p.deposits == 0) continue;
        model.roughness.push_back(material.roughness);
        model.viscosity.push_back(std::round(material.viscosity * kVoxelFull) * kUnit);
    }
    return model;
}

std::vector<oracle::Body> StageBench::oracle_bodies() const {
    std::vector<oracle::Body> bodies;
    for (int i = 0; i < kBodyCount; ++i) {
        const int32_t* record = &impl_->shapes.words()[static_cast<size_t>(i) * kBodyWords];
        const auto vector = [&](int at, double unit) {
            return Vec3{record[at] * unit, record[at + 1] * unit, record[at + 2] * unit};
        };
        bodies.push_back({vector(kBodyLinear, kUnit), vector(kBodyAngular, kUnit),
                          vector(kBodyCenter, 0.5), record[kBodyMoving] != 0,
                          record[kBodyFriction] / static_cast<double>(kOneQ16),
                          record[kBodyPacking] * kUnit, record[kBodyReach]});
    }
    return bodies;
}

void Deviation::take(double got_value, double expected_value, int px, int py, int pz) {
    // What is no number is off by more than any.
    const double difference = std::abs(got_value - expected_value);
    if (std::isnan(difference) ? !std::isnan(value) : difference > value) {
        *this = {difference, px, py, pz, got_value, expected_value};
    }
}

std::ostream& operator<<(std::ostream& out, const Deviation& d) {
    return out << "off by " << d.value << " at voxel " << d.x << " " << d.y << " " << d.z << ": "
               << d.got << ", expected " << d.expected;
}

FieldDeviation compare(const oracle::Field& got, const oracle::Field& expected,
                       int material_count) {
    FieldDeviation deviation;
    got.for_each([&](int x, int y, int z) {
        const oracle::Voxel &a = got.at(x, y, z), &b = expected.at(x, y, z);
        deviation.soil.take(a.soil, b.soil, x, y, z);
        deviation.soil.take(a.bond, b.bond, x, y, z);
        for (int m = 0; m < material_count; ++m) {
            deviation.mass.take(a.mass[static_cast<size_t>(m)], b.mass[static_cast<size_t>(m)], x,
                                y, z);
        }
        deviation.momentum.take(a.momentum.x, b.momentum.x, x, y, z);
        deviation.momentum.take(a.momentum.y, b.momentum.y, x, y, z);
        deviation.momentum.take(a.momentum.z, b.momentum.z, x, y, z);
    });
    return deviation;
}

}  // namespace bsoil
