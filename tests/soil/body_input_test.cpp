// Bodies as a host may hand them over: bad ones are skipped and reported, the soil stays sound.
#include <algorithm>
#include <cmath>
#include <limits>

#include "soil_fixture.h"

namespace bsoil::body_input_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class BodyInput : public testing::Test {
  protected:
    void SetUp() override {
        soil_ = make_soil(grid_def(32, 24, 16));
        ASSERT_TRUE(soil_->fill(voxel_box(*soil_, {0, 0, 0}, {32, 24, 6})));
        units_ = soil_->totals().units;
    }
    void TearDown() override { EXPECT_EQ(soil_->totals().units, units_); }

    static Mover stone(int id = 1, Vec3 at = Vec3{16, 12, 6} * 0.05) {
        Mover mover(id, box_shape(Vec3{2, 2, 2} * 0.05), at);
        return mover;
    }
    uint32_t bits_after(const SoilBody& body, int steps = 3) {
        soil_->clear_status();
        for (int i = 0; i < steps; ++i) soil_->step({&body, 1});
        return soil_->status_bits();
    }
    static uint32_t bit(StatusBit status) { return static_cast<uint32_t>(status); }

    std::unique_ptr<Soil> soil_;
    std::vector<int64_t> units_;
};

TEST_F(BodyInput, poses_and_velocities_that_are_not_finite_are_ignored) {
    const uint64_t checksum = soil_->checksum();
    for (double bad : {kNan, kInfinity, -kInfinity}) {
        for (int field = 0; field < 8; ++field) {
            Mover mover = stone();
            SoilBody& body = mover.body;
            double* const places[8] = {&body.pose.position.x,       &body.pose.position.z,
                                       &body.pose.rotation.x,       &body.pose.rotation.w,
                                       &body.linear_velocity_m_s.y, &body.angular_velocity_rad_s.z,
                                       &body.center_of_mass_m.x,    &body.linear_velocity_m_s.z};
            *places[field] = bad;
            EXPECT_EQ(bits_after(body), bit(StatusBit::pose_not_finite)) << field;
        }
    }
    EXPECT_EQ(soil_->checksum(), checksum);
}

TEST_F(BodyInput, rotations_that_stretch_are_ignored) {
    const uint64_t checksum = soil_->checksum();
    for (const double length : {0.0, 0.9, 1.01, 1e37}) {
        Mover mover = stone();
        mover.body.pose.rotation = {0, 0, 0, length};
        EXPECT_EQ(bits_after(mover.body), bit(StatusBit::pose_not_finite)) << length;
    }
    EXPECT_EQ(soil_->checksum(), checksum);
    Mover mover = stone();
    mover.body.pose.rotation = {0, 0, 0, 1 + 1e-6};  // single precision
    EXPECT_EQ(bits_after(mover.body), 0u);
}

TEST_F(BodyInput, conditions_of_impossible_ids_are_saved_and_read) {
    for (const int id : {-10, 1 << 30}) {
        Mover mover = stone(id);
        EXPECT_EQ(bits_after(mover.body), bit(StatusBit::shape_refused)) << id;
        mover.body.pose.position.x = kNan;
        EXPECT_EQ(bits_after(mover.body), bit(StatusBit::pose_not_finite)) << id;
        EXPECT_TRUE(make_soil(grid_def(32, 24, 16))->prepare(soil_->state())) << id;
    }
}

TEST_F(BodyInput, a_contact_as_wide_as_the_world_has_numbers) {
    Mover mover = stone();
    mover.body.contact_width_m = 1e308;
    const StepReport report = soil_->step({&mover.body, 1});
    EXPECT_FALSE(report.contacts.empty());
    for (const ContactVoxel& contact : report.contacts) {
        EXPECT_TRUE(std::isfinite(contact.depth_m));
    }
}

TEST_F(BodyInput, shapes_without_size_are_refused) {
    using Kind = ConvexShape::Kind;
    std::vector<ConvexShape> bad;
    for (double size : {0.0, -1.0, kNan, kInfinity, 1e9}) {
        bad.push_back(box_shape({size, 1, 1}));
        bad.push_back(box_shape({1, 1, size}));
        bad.push_back(sphere_shape(size));
        bad.push_back(round_shape(Kind::capsule, size, 1));
        bad.push_back(round_shape(Kind::cylinder, 1, size));
        bad.push_back(round_shape(Kind::cone, size, 1));
        ConvexShape hull = octahedron_shape(1);
        hull.bound_m = size;
        bad.push_back(hull);
    }
    for (double rounding : {-0.1, kNan, kInfinity}) {
        bad.push_back(sphere_shape(1));
        bad.back().rounding_m = rounding;
    }
    ConvexShape few = octahedron_shape(1);
    few.planes.resize(3);
    ConvexShape many = octahedron_shape(1);
    many.planes.resize(limits::kHullPlaneCapacity + 1, many.planes[0]);
    ConvexShape skewed = octahedron_shape(1);
    skewed.planes[2].normal = {2, 0, 0};
    ConvexShape endless = octahedron_shape(1);
    endless.planes[2].offset = kInfinity;
    ConvexShape lost = sphere_shape(1);
    lost.local.position.y = kNan;
    ConvexShape hollow;  // without its lattice
    hollow.kind = Kind::lattice;
    for (const ConvexShape& shape : {few, many, skewed, endless, lost, hollow}) {
        bad.push_back(shape);
    }
    const uint64_t checksum = soil_->checksum();
    for (const ConvexShape& shape : bad) {
        const Mover mover(1, shape, Vec3{16, 12, 6} * 0.05);
        EXPECT_EQ(bits_after(mover.body), bit(StatusBit::shape_refused))
            << static_cast<int>(shape.kind);
    }
    Mover mover = stone();
    mover.body.shapes = nullptr;
    EXPECT_EQ(bits_after(mover.body), bit(StatusBit::shape_refused));
    mover.shapes.clear();
    mover.body.shapes = &mover.shapes;
    EXPECT_EQ(bits_after(mover.body), bit(StatusBit::shape_refused));
    for (int id : {-1, 65535}) {
        const Mover misnamed = stone(id);
        EXPECT_EQ(bits_after(misnamed.body), bit(StatusBit::shape_refused)) << id;
    }
    EXPECT_EQ(soil_->checksum(), checksum);
}

TEST_F(BodyInput, every_id_in_range_is_accepted) {
    for (int id : {0, 65534}) {
        const Mover mover = stone(id);
        EXPECT_EQ(bits_after(mover.body), 0u) << id;
    }
}

TEST_F(BodyInput, a_body_outside_of_the_grid_is_reported_and_moves_nothing) {
    for (Vec3 at :
         {Vec3{-50, 0, 0}, Vec3{0, 1e6, 0}, Vec3{0.8, 0.6, -30}, Vec3{1e300, 1e300, 1e300}}) {
        const uint64_t checksum = soil_->checksum();
        const Mover mover = stone(1, at);
        EXPECT_TRUE(bits_after(mover.body) & bit(StatusBit::body_outside_grid));
        EXPECT_EQ(soil_->checksum(), checksum);
    }
    const Mover fixed(2, box_shape({1, 1, 1}), {-50, 0, 0},
                      true);  // a wall beside the grid is no fault
    EXPECT_EQ(bits_after(fixed.body), 0u);
}

TEST_F(BodyInput, a_body_that_jumps_is_placed_and_reported) {
    Mover mover = stone(1, Vec3{4, 12, 6} * 0.05);
    EXPECT_EQ(bits_after(mover.body), 0u);
    mover.body.pose.position.x += 100 * 0.05;
    mover.body.center_of_mass_m = mover.body.pose.position;
    EXPECT_TRUE(bits_after(mover.body) & bit(StatusBit::body_teleported));
    mover.body.pose.position.x -= 85 * 0.05;
    mover.body.center_of_mass_m = mover.body.pose.position;
    EXPECT_TRUE(bits_after(mover.body, 30) & bit(StatusBit::body_teleported));
}

TEST_F(BodyInput, a_body_that_appears_in_soil_pushes_it_out_and_loses_none) {
    Mover mover = stone(1, Vec3{16, 12, 3} * 0.05);
    EXPECT_EQ(bits_after(mover.body, 60), 0u);
}

TEST_F(BodyInput, soil_filled_into_a_body_is_kept) {
    Mover mover = stone(1, Vec3{16, 12, 9} * 0.05);
    soil_->step({&mover.body, 1});
    ASSERT_TRUE(soil_->fill(voxel_box(*soil_, {12, 8, 6}, {20, 16, 12})));
    units_ = soil_->totals().units;
    EXPECT_EQ(bits_after(mover.body, 60) & ~bit(StatusBit::span_list_full), 0u);
}

TEST_F(BodyInput, absurd_velocities_do_no_harm) {
    for (double speed : {1e3, 1e30, 1e300}) {
        Mover mover = stone();
        mover.set_velocity({speed, -speed, speed}, {speed, speed, -speed});
        bits_after(mover.body, 5);
        for (int i = 0; i < 20; ++i) soil_->step({});
        EXPECT_EQ(soil_->totals().units, units_);
    }
}

TEST_F(BodyInput, hundreds_of_bodies_come_and_go) {
    std::vector<Mover> movers;
    for (int i = 0; i < 600; ++i) {
        movers.emplace_back(i, sphere_shape(0.04),
                            Vec3{1.0 + i % 30, 1.0 + i / 30 % 20, 6.2 + i % 7} * 0.05);
        movers.back().set_velocity({0, 0, -0.4});
    }
    for (int s = 0; s < 12; ++s) {
        for (Mover& mover : movers) mover.advance(1.0 / 60);
        std::vector<SoilBody> bodies = bodies_of(movers);
        bodies.erase(bodies.begin(), bodies.begin() + s * 40);
        const StepReport report = soil_->step(bodies);
        EXPECT_GT(report.contacts.size(), 0u);
        EXPECT_TRUE(std::all_of(report.contacts.begin(), report.contacts.end(),
                                [&](const ContactVoxel& contact) {
                                    return contact.body >= s * 40 && contact.body < 600;
                                }));
    }
    EXPECT_EQ(soil_->status_bits() & ~bit(StatusBit::span_list_full), 0u);
}

TEST_F(BodyInput, bodies_beyond_the_capacity_are_refused) {
    std::vector<Mover> movers;
    movers.reserve(limits::kBodyCapacity + 1);
    for (int i = 0; i <= limits::kBodyCapacity; ++i) {
        movers.emplace_back(i, sphere_shape(0.01), Vec3{i % 32 + 0.5, i / 32 % 24 + 0.5, 9} * 0.05);
    }
    const std::vector<SoilBody> bodies = bodies_of(movers);
    soil_->step(std::span(bodies).first(limits::kBodyCapacity));
    EXPECT_EQ(soil_->status_bits(), 0u);
    soil_->step(bodies);
    EXPECT_EQ(soil_->status_bits(), bit(StatusBit::shape_refused));
    EXPECT_EQ(status_texts(soil_->status_bits()).size(), 1u);
}

// More than half of all that there may be: new ones come before the indices of the old are free.
TEST_F(BodyInput, thousands_of_bodies_change_places_with_others) {
    constexpr int kCount = limits::kBodyCapacity / 2 + 52;
    const auto bodies_from = [](int first_id) {
        std::vector<Mover> movers;
        movers.reserve(kCount);
        for (int i = 0; i < kCount; ++i) {
            // Most of them fly over the soil; the last have come to it.
            const Vec3 at{i % 32 + 0.5, i / 32 % 24 + 0.5, i + 64 < kCount ? 14.0 : 6.0};
            movers.emplace_back(first_id + i, sphere_shape(0.04), at * 0.05);
        }
        return movers;
    };
    for (int round = 0; round < 3; ++round) {
        const std::vector<Mover> movers = bodies_from(round * kCount);
        const StepReport report = soil_->step(bodies_of(movers));
        const BodyTable& table = SoilProbe::impl(*soil_).bodies;
        EXPECT_LE(table.ids().size(), static_cast<size_t>(limits::kBodyCapacity));
        std::vector<int> indices;
        for (const auto& [id, track] : table.tracks()) {
            indices.push_back(track.index);
            ASSERT_EQ(table.ids()[static_cast<size_t>(track.index)], id);
        }
        EXPECT_EQ(indices.size(), static_cast<size_t>(kCount));
        std::sort(indices.begin(), indices.end());
        EXPECT_EQ(std::unique(indices.begin(), indices.end()), indices.end());
        // Contacts are of bodies that are there, also of those that came last.
        ASSERT_FALSE(report.contacts.empty());
        for (const ContactVoxel& contact : report.contacts) {
            EXPECT_GE(contact.body, (round + 1) * kCount - 64);
            EXPECT_LT(contact.body, (round + 1) * kCount);
        }
        const auto put = make_soil(grid_def(32, 24, 16))->prepare(soil_->state());
        EXPECT_TRUE(put) << put.error();
    }
    EXPECT_EQ(soil_->status_bits() & ~bit(StatusBit::span_list_full), 0u);
}

TEST_F(BodyInput, the_same_id_twice_counts_once) {
    const Mover first = stone(4), second = stone(4, Vec3{8, 12, 6} * 0.05);
    const SoilBody both[2] = {first.body, second.body};
    const StepReport report = soil_->step(both);
    for (const ContactVoxel& contact : report.contacts) EXPECT_GT(contact.position_m.x, 0.6);
}

}  // namespace
}  // namespace bsoil::body_input_test
