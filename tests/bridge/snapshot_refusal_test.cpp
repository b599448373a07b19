// Snapshots of worlds that do not fit or are damaged: they are refused and change nothing.
#include <algorithm>
#include <array>
#include <cstring>
#include <random>

#include "bsoil/snapshot_file.h"
#include "cure.h"
#include "snapshot_worlds.h"

namespace bsoil::bullet::snapshot_refusal_test {
namespace {

TEST_F(WorldSnapshot, other_raycast_vehicles_are_refused_by_name) {
    const auto saved = build_car(1);
    saved->run(10);
    ASSERT_TRUE(saved->save(path("a")));
    const auto expect = [&](TestWorld& w, const std::string& words) {
        w.run(5);
        const uint64_t before = w.checksum();
        for (const Status& status : {w.load(path("a")), w.soil->load(path("a"))}) {
            ASSERT_FALSE(status) << words;
            EXPECT_NE(status.error().find(words), std::string::npos) << status.error();
            EXPECT_TRUE(says_what_to_do(status.error())) << status.error();
        }
        EXPECT_EQ(w.checksum(), before);
    };
    expect(*build_car(1, {.width_m = 0.25}), "wheel 0 of vehicle 0 has here width_m 0.25");
    expect(*build_car(1, {.width_m = 0.24, .surface = {.friction = 0.3}}), "friction 0.3");
    const auto larger = build_car(1);
    larger->car->vehicle->getWheelInfo(2).m_wheelsRadius = 0.5f;
    ASSERT_TRUE(larger->caster->attach(*larger->car->vehicle, SoilWheelDef{.width_m = 0.24}));
    expect(*larger, "wheel 2 of vehicle 0 has here m_wheelsRadius 0.5");
    const auto six = build_car(1);
    for (const btScalar z : {-0.6f, 0.6f}) {
        six->car->vehicle->addWheel({0, -0.2f, z}, {0, -1, 0}, {0, 0, 1}, Car::kRestM,
                                    Car::kRadiusM, six->car->tuning, false);
    }
    ASSERT_TRUE(six->caster->attach(*six->car->vehicle, SoilWheelDef{.width_m = 0.24}));
    expect(*six, "4 wheels of vehicle 0 in the snapshot, 6 here");
    const auto detached = build_car(1);
    detached->caster->detach();
    expect(*detached, "1 vehicles attached to a SoilRaycaster in the snapshot, 0 here");
    // Bullet's part alone: a vehicle that is no action of the world.
    const auto without = build_car(1);
    without->world().removeVehicle(without->car->vehicle.get());
    const uint64_t before = without->checksum();
    const Status missing = without->load(path("a"));
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().find("1 vehicles in the snapshot, 0 here"), std::string::npos)
        << missing.error();
    EXPECT_EQ(without->checksum(), before);
}

TEST_F(WorldSnapshot, damaged_files_are_refused_and_change_nothing) {
    const auto w = build_machine(), twin = build_machine();
    w->run(8);
    twin->run(8);
    ASSERT_TRUE(w->save(path("a")));
    const std::vector<char> good = bytes_of(path("a"));
    w->run(2);
    twin->run(2);
    const uint64_t checksum = w->checksum();
    const auto expect_refused = [&](const std::vector<char>& bytes, const std::string& what) {
        write_bytes(path("b"), bytes);
        for (const Status& status : {w->load(path("b")), w->soil->load(path("b"))}) {
            ASSERT_FALSE(status) << what;
            ASSERT_NE(status.error().find(path("b")), std::string::npos) << status.error();
        }
        ASSERT_EQ(w->checksum(), checksum) << what;
    };
    std::mt19937 random(3);
    for (size_t i = 0; i < 400; ++i) {
        std::vector<char> flipped = good;
        const size_t at = i < 200 ? i : random() % good.size();
        flipped[at] = static_cast<char>(flipped[at] ^ (1 << random() % 8));
        expect_refused(flipped, "bit flipped in byte " + std::to_string(at));
    }
    for (const size_t size : {size_t{0}, size_t{7}, size_t{16}, size_t{60}, size_t{200},
                              good.size() / 2, good.size() - 1}) {
        expect_refused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)},
                       "cut to " + std::to_string(size));
    }
    std::vector<char> longer = good;
    longer.push_back('x');
    expect_refused(longer, "a byte too many");
    expect_refused({}, "empty");
    w->run(10);
    twin->run(10);
    EXPECT_EQ(w->checksum(), twin->checksum());
}

// A hash keeps accidents out, not someone who computes it anew: whatever stands in a section, the
// world is whole after, and as it was where an error is returned.
TEST_F(WorldSnapshot, forged_sections_are_refused_or_harmless) {
    for (const Build& build : {Build(build_machine), Build([] { return build_car(1); })}) {
        const auto w = build();
        w->run(8);
        ASSERT_TRUE(w->save(path("a")));
        const auto sections = read_snapshot_file(path("a"));
        ASSERT_TRUE(sections);
        std::mt19937 random(4);
        int refused = 0;
        for (int i = 0; i < 300; ++i) {
            std::vector<SnapshotSection> forged = *sections;
            std::vector<uint8_t>& bytes = forged[random() % forged.size()].bytes;
            const size_t at = random() % bytes.size();
            if (i % 4 == 0) {
                bytes.resize(at);
            } else if (i % 4 == 1) {
                std::fill(
                    bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    bytes.begin() + static_cast<std::ptrdiff_t>(std::min(at + 8, bytes.size())),
                    static_cast<uint8_t>(0xff));
            } else {
                bytes[at] = static_cast<uint8_t>(random());
            }
            ASSERT_TRUE(write_snapshot_file(path("b"), forged));
            const uint64_t before = w->checksum();
            if (w->load(path("b"))) {
                const Status back = w->load(path("a"));
                ASSERT_TRUE(back) << back.error() << i;
            } else {
                ++refused;
                ASSERT_EQ(w->checksum(), before) << i;
            }
            if (i % 40 == 0) w->step();
        }
        EXPECT_GT(refused, 150);
        w->run(20);
    }
}

// What a body owes for its load becomes a force on it. 3.2 x 0.9 x 2.4 m hold 34 t of the densest
// soil, wet. To turn all of it round at 16 voxels a step takes 1.1e7 N s.
TEST_F(WorldSnapshot, more_load_or_debt_than_the_grid_can_give_is_refused) {
    const auto w = build_machine();
    w->run(60);
    ASSERT_TRUE(w->save(path("a")));
    const auto sections = read_snapshot_file(path("a"));
    ASSERT_TRUE(sections);
    const auto loads = w->soil->last_report().loads;
    ASSERT_FALSE(loads.empty());
    // A load lies as: body; mass, centre, impulse, what walls hold, the same times its place;
    // then debt and push, each with its moment. Of its two places the last is what the coupling
    // remembers.
    std::array<uint8_t, sizeof(int) + sizeof(double)> head;
    std::memcpy(head.data(), &loads[0].body, sizeof(int));
    std::memcpy(head.data() + sizeof(int), &loads[0].mass_kg, sizeof(double));
    const auto coupling =
        std::find_if(sections->begin(), sections->end(),
                     [](const SnapshotSection& section) { return section.name == "coupling"; });
    const auto found =
        std::find_end(coupling->bytes.begin(), coupling->bytes.end(), head.begin(), head.end());
    ASSERT_NE(found, coupling->bytes.end());
    const auto load_at = static_cast<size_t>(found - coupling->bytes.begin()) + sizeof(int);
    const auto write = [&](int number, double value) {
        std::vector<SnapshotSection> forged = *sections;
        for (SnapshotSection& section : forged) {
            if (section.name != "coupling") continue;
            std::memcpy(&section.bytes[load_at + static_cast<size_t>(number) * sizeof(double)],
                        &value, sizeof(double));
        }
        EXPECT_TRUE(write_snapshot_file(path("b"), forged));
    };
    const struct {
        int number;
        double value;
        const char* words;
    } cases[] = {{0, 1e5, "carries 1e+05 kg"},
                 {1, 1e3, "at a distance of"},
                 {4, 1e9, "gave soil"},
                 {7, -1e5, "holds up 1e+05 kg for"},
                 {9, 1e9, "holds up 1e+09 kg m"},
                 {11, -1e9, "owes 1e+09 N s"},
                 {13, 1e100, "owes 1e+100 N s"},
                 {14, 1e9, "owes 1e+09 N m s"},
                 {17, 1e10, "is pushed by 1e+10 N"},
                 {22, -1e12, "is pushed by 1e+12 N m"}};
    const uint64_t before = w->checksum();
    for (const auto& forged : cases) {
        write(forged.number, forged.value);
        for (const Status& status : {w->load(path("b")), w->soil->load(path("b"))}) {
            ASSERT_FALSE(status) << forged.words;
            EXPECT_NE(status.error().find(forged.words), std::string::npos) << status.error();
            EXPECT_TRUE(says_what_to_do(status.error())) << status.error();
        }
        EXPECT_EQ(w->checksum(), before) << forged.words;
    }
    write(0, loads[0].mass_kg);
    const Status same = w->load(path("b"));
    EXPECT_TRUE(same) << same.error();
}

TEST_F(WorldSnapshot, sizes_in_the_head_are_not_believed) {
    const SnapshotSection section{"soil", std::vector<uint8_t>(1000, 7)};
    ASSERT_TRUE(write_snapshot_file(path("a"), {&section, 1}));
    const std::vector<char> good = bytes_of(path("a"));
    for (const size_t at : {size_t{12}, size_t{32}, size_t{40}}) {  // sections, content, frame
        std::vector<char> huge = good;
        for (size_t i = 0; i < 4; ++i) huge[at + i] = static_cast<char>(0x7f);
        if (at > 12) huge[at + 7] = static_cast<char>(0x7f);
        // The head's own hash would catch it: make it fit.
        const size_t head = 16 + 40;
        uint64_t hash = 0xcbf29ce484222325ull;
        hash = add(hash, huge.data(), head);
        std::memcpy(huge.data() + head, &hash, sizeof(hash));
        write_bytes(path("b"), huge);
        const auto read = read_snapshot_file(path("b"));
        ASSERT_FALSE(read) << at;
        EXPECT_NE(read.error().find("damaged"), std::string::npos) << read.error();
        EXPECT_TRUE(says_what_to_do(read.error())) << read.error();
    }
    std::vector<char> other = good;
    other[8] = 2;
    write_bytes(path("b"), other);
    const auto read = read_snapshot_file(path("b"));
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().find("version 2"), std::string::npos) << read.error();
}

TEST_F(WorldSnapshot, another_world_or_soil_is_refused_by_name) {
    const auto saved = build_machine();
    saved->run(5);
    ASSERT_TRUE(saved->save(path("a")));
    const auto expect = [&](TestWorld& w, const std::string& words) {
        const uint64_t before = w.checksum();
        const Status status = w.load(path("a"));
        ASSERT_FALSE(status) << words;
        EXPECT_NE(status.error().find(words), std::string::npos) << status.error();
        EXPECT_TRUE(says_what_to_do(status.error())) << status.error();
        EXPECT_EQ(w.checksum(), before);
    };
    const auto more = build_machine();
    more->scene.add_box(1, {0.1f, 0.1f, 0.1f}, {0, 3, 0});
    expect(*more, "collision objects");
    const auto heavy = build_machine();
    heavy->scene.bodies[0]->setMassProps(41, btVector3(1, 1, 1));
    expect(*heavy, "mass_kg 41");
    const auto indexed = build_machine();
    indexed->scene.bodies[1]->setUserIndex(3);
    expect(*indexed, "user index 3");
    const auto loose = build_machine();
    loose->world().removeConstraint(loose->constraints[0].get());
    expect(*loose, "constraints");
    loose->constraints.clear();
    const auto bare = build_heap();
    expect(*bare, "another world");
    const auto finer = build_machine();
    finer->soil.reset();
    SoilDef def;
    def.material.shear_displacement_m = 0.03;  // the only difference
    def.size_m = {3.2, 0.9, 2.4};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    // The soil's anchor goes to the end of the list; a world of that order is another one.
    finer->soil = std::move(*SoilAction::create(finer->world(), def));
    expect(*finer, "another world");
    const Status soil = finer->soil->soil().load(path("a"));
    ASSERT_FALSE(soil);
    EXPECT_NE(soil.error().find("shear_displacement_m of material 'dry_sand' 0.02"),
              std::string::npos)
        << soil.error();
    EXPECT_FALSE(save_world(saved->world(), {}, path("b")));  // has a soil that is not given
    btSimpleBroadphase simple;
    btDiscreteDynamicsWorld other(&saved->scene.dispatcher, &simple, &saved->scene.solver,
                                  &saved->scene.configuration);
    const Status broadphase = save_world(other, {}, path("b"));
    ASSERT_FALSE(broadphase);
    EXPECT_NE(broadphase.error().find("btDbvtBroadphase"), std::string::npos);
}

}  // namespace
}  // namespace bsoil::bullet::snapshot_refusal_test
