// The memory map of shaders/buffer_list.h, printed from the layout.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "base/layout.h"
#include "bsoil/limits.h"
#include "bsoil/soil.h"
#include "soil/slot_buffers.h"
#include "soil/tile_table.h"
#include "soil_fixture.h"

namespace bsoil::memory_map_test {
namespace {

using namespace layout;

/// One row: what a plane or record holds, its bytes, per what, and a remark.
class Map {
  public:
    void row(const std::string& what, const std::string& bytes, const std::string& remark) {
        text_ += fmt::format("// {:<35} {:<24} {}\n", what, bytes, remark);
    }
    void plane(const std::string& name, int first, int count, const std::string& remark) {
        const bool moves = first >= kTransportFirst;
        bool is_kept = false;
        for (int kept = 0; kept <= kKeptMaterial; ++kept) is_kept |= state_plane_of(kept) == first;
        const std::string bytes =
            count > 0 ? fmt::format("{} B a voxel", 4 * count) : "4 M B a voxel";
        const std::string marks = (is_kept ? " K" : "") + std::string(moves ? " T" : "");
        row(fmt::format("state  plane {:>2}  {}", first, name), bytes,
            remark + (marks.empty() ? "" : " [" + marks.substr(1) + "]"));
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

/// State and delta planes.
int moved_and_all(int materials, int water) {
    return transported_planes(materials, water) + state_planes(materials, water);
}

/// "80 + 8 M + 8 W", where each plane is so many bytes or words.
std::string by_materials(int (*planes)(int, int), int unit = 4) {
    const int none = planes(0, 0);
    const auto part = [&](int more, const char* name) {
        return unit * (more - none) == 1 ? fmt::format(" + {}", name)
                                         : fmt::format(" + {} {}", unit * (more - none), name);
    };
    return fmt::format("{}{}{}", unit * none, part(planes(1, 0), "M"), part(planes(0, 1), "W"));
}

std::string memory_map() {
    Map map;
    map.plane("coverage", kPlaneCoverage, 1, "bodies in the voxel, volume units, not clamped");
    map.plane("owner", kPlaneOwner, 1, "body that covers most");
    map.plane("terrain", kPlaneTerrain, 1, "terrain and ground bodies, volume units");
    map.plane("support", kPlaneSupport, 1, "falling, on the ground, or on a body");
    map.plane("volume", kPlaneVolume, 1, "soil, volume units");
    map.plane("momentum x y z", kPlaneMomentumX, kPlaneForceX - kPlaneMomentumX,
              "mass units * Q10 velocity");
    map.plane("force x y z", kPlaneForceX, kPlaneBond - kPlaneForceX, "direction of the push");
    map.plane("bond", kPlaneBond, 1, "volume units never moved");
    map.plane("mass of material m", kPlaneMaterial, 0, "mass units");
    map.row(fmt::format("state  plane {} + M  water", kPlaneMaterial), "4 W B a voxel",
            "water units, behind the materials [K T]");
    map.row(fmt::format("delta  as planes {} ...", kTransportFirst),
            by_materials(transported_planes) + " B a voxel",
            "what a pass moves; zero between passes");
    map.row(
        "  state and delta", by_materials(moved_and_all) + " B a voxel",
        fmt::format("{} with one dry material, {} with {} that take water", 4 * moved_and_all(1, 0),
                    4 * moved_and_all(limits::kMaterialCapacity, 1), limits::kMaterialCapacity));
    map.row("tile_table", fmt::format("{} B a tile", 4 * kTileTableWords),
            "neighbours' slots, place, top of the soil");
    map.row("block_list", "4 B an entry", "work lists of the step");
    map.row("block_flags  flags", fmt::format("{} B a block", 4 * kFlagArrays),
            fmt::format("{} stamps", kFlagArrays));
    map.row("             masks", fmt::format("{} B a block", 4 * kMaskWords),
            "columns and voxels with work");
    map.row("spans  records", fmt::format("{} B a column", 4 * kColumnWords),
            fmt::format("{} spans, slip speeds, bases", kSpanCapacity));
    map.row("       arrays", fmt::format("{} B a column", 4 * kColumnArrays),
            "surface, stamp, ends, cut ...");
    map.row("       of slots", fmt::format("{} B a tile", 4 * kTileArrays),
            "stamp, toes, cut, failing");
    map.row("shapes  bodies", fmt::format("{} B a body", 4 * kBodyWords), "velocity, friction ...");
    map.row("        shapes", fmt::format("{} B a shape", 4 * kShapeWords), "kind, place, size");
    map.row("        faces of hulls", fmt::format("{} B a face", 4 * kFaceWords), "normal, offset");
    map.row("        bricks of lattices", fmt::format("{} B a brick", 4 * kLatticeBrickWords),
            "distances; 4 B where the surface is far");
    map.row("tables", fmt::format("{} B a material", kSoilStates * 4 * kTableWords),
            "wedges and accelerations: bonded, loose, failing");
    map.row("        flows", fmt::format("{} B a flow", 4 * kFlowWords),
            fmt::format("source, sink or open side, {} at most", kFlowCapacity));
    map.row("        parts of flows", fmt::format("{} B a part", 4 * kFlowPartWords),
            "what of a flow's region lies in one tile");
    map.row("result  header", fmt::format("{} B", 4 * kResultHeader),
            "conditions, counts, momentum");
    map.row("        loads", fmt::format("{} x {} B", limits::kBodyCapacity, 4 * kLoadWords),
            "soil that each body carries, momentum it gave");
    map.row("        flows", fmt::format("{} x {} B", kFlowCapacity, 4 * kFlowResultWords),
            "what each has moved, by material");
    map.row("        contacts",
            fmt::format("{} x {} B", limits::kContactCapacity, 4 * kContactWords),
            "voxels in which bodies meet soil; 65536 at first");
    return map.text();
}

std::string text_of(const std::string& path) {
    std::ifstream file(BSOIL_SOURCE_DIR "/" + path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

TEST(MemoryMap, stands_where_the_buffers_are_declared) {
    const std::string map = memory_map();
    EXPECT_NE(text_of("shaders/buffer_list.h").find(map), std::string::npos)
        << "shaders/buffer_list.h should say:\n"
        << map;
}

// A word's number has 32 bits in the kernels, however many tiles a soil may have awake.
TEST(MemoryMap, no_more_slots_than_words_have_numbers) {
    for (const int64_t slot_words : {int64_t{1}, int64_t{32768}, int64_t{64} * 512}) {
        const SlotBuffer buffer{Buffer::state, {{13, slot_words, kPlanePad}, {2, 3, 5}}};
        const auto parts = buffer.parts(7, 3);
        ASSERT_EQ(parts.size(), 15u);
        EXPECT_EQ(parts[2], std::pair(2 * (7 * slot_words + kPlanePad), 3 * slot_words));
        EXPECT_EQ(parts[14].first + 7 * 3 + 5, buffer.words(7));
        const int most = buffer.slots_most();
        EXPECT_LE(buffer.words(most), std::numeric_limits<int32_t>::max());
        EXPECT_GT(buffer.words(int64_t{most} + 1), std::numeric_limits<int32_t>::max());
    }
}

// Nor than entries of tile lists have. In low grids that is what ends it first.
TEST(MemoryMap, no_more_slots_than_tile_lists_name) {
    for (const int nz : {8, 512}) {
        const auto soil = make_soil(grid_def(8, 8, nz));
        ASSERT_TRUE(soil);
        const Soil::Impl& impl = SoilProbe::impl(*soil);
        const int most = slots_most(impl);
        const int64_t lowest = impl.blocks_per_tile - 1, highest = impl.blocks_per_tile;
        EXPECT_LE((int64_t{most - 1} * kTileWord + lowest) * kTileWord + highest,
                  std::numeric_limits<int32_t>::max());
        for (const SlotBuffer& buffer : slot_buffers(impl)) {
            EXPECT_LE(most, buffer.slots_most());
        }
        EXPECT_GT(most, nz == 8 ? 100'000 : 1000);
    }
}

TEST(MemoryMap, is_what_the_pages_say) {
    const std::string readme = text_of("plugin/README.md");
    for (const std::string& said :
         {by_materials(moved_and_all) + " bytes", fmt::format("{} bytes", 4 * kColumnWordsInAll),
          by_materials(kept_planes, 1) + " words a voxel"}) {
        EXPECT_NE(readme.find(said), std::string::npos) << "plugin/README.md: " << said;
    }
    EXPECT_NE(text_of("docs/performance.md").find(by_materials(moved_and_all) + " bytes"),
              std::string::npos)
        << "docs/performance.md: " << by_materials(moved_and_all);
}

// What Soil::memory_use says of a voxel is what the device holds for each more tile.
TEST(MemoryMap, counts_a_tile_as_the_device_does) {
    for (const double pore_water : {0.0, 0.3}) {
        SoilDef def;
        def.size_m = {1.6, 1.6, 0.8};
        def.up = UpAxis::z;
        def.backend = Backend::cpu;
        def.material.pore_water_fraction = pore_water;
        int64_t bytes[2] = {};
        MemoryUse use;
        for (const int tiles : {4, 8}) {
            def.tile_capacity = tiles;
            const auto soil = std::move(*Soil::create(def));
            use = soil->memory_use();
            bytes[tiles == 8] = use.awake_bytes;
        }
        const double voxels = 4 * 64 * 16;
        EXPECT_NEAR(static_cast<double>(bytes[1] - bytes[0]) / voxels, use.bytes_per_awake_voxel,
                    1e-9)
            << pore_water;
    }
}

TEST(MemoryMap, names_every_buffer) {
    const std::string map = memory_map();
#define BUFFER(name) EXPECT_NE(map.find("// " #name), std::string::npos) << #name;
#include "buffer_list.h"
#undef BUFFER
}

}  // namespace
}  // namespace bsoil::memory_map_test
