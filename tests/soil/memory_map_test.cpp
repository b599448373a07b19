// The memory map of shaders/buffer_list.h, printed from the layout.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "base/layout.h"
#include "bsoil/limits.h"
#include "soil/tile_table.h"

namespace bsoil::memory_map_test {
namespace {

using namespace layout;

/// One row: what a plane or record holds, its bytes, per what, and a remark.
class Map {
  public:
    void row(const std::string& what, const std::string& bytes, const std::string& remark) {
        text_ += fmt::format("// {:<33} {:<20} {}\n", what, bytes, remark);
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
    const int transported = kPlaneMaterial - kTransportFirst;
    map.row(fmt::format("delta  as planes {} ...", kTransportFirst),
            fmt::format("{} + 4 M B a voxel", 4 * transported),
            "what a pass moves; zero between passes");
    map.row("  state and delta",
            fmt::format("{} + 8 M B a voxel", 4 * (kPlaneMaterial + transported)),
            fmt::format("{} with one material, {} with {}", 4 * (kPlaneMaterial + transported) + 8,
                        4 * (kPlaneMaterial + transported) + 8 * limits::kMaterialCapacity,
                        limits::kMaterialCapacity));
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
    map.row("       of slots", fmt::format("{} B a tile", 4 * kTileArrays), "stamp, toes, cut");
    map.row("shapes  bodies", fmt::format("{} B a body", 4 * kBodyWords), "velocity, friction ...");
    map.row("        shapes", fmt::format("{} B a shape", 4 * kShapeWords), "kind, place, size");
    map.row("        faces of hulls", fmt::format("{} B a face", 4 * kFaceWords), "normal, offset");
    map.row("        bricks of lattices", fmt::format("{} B a brick", 4 * kLatticeBrickWords),
            "distances; 4 B where the surface is far");
    map.row("tables", fmt::format("{} B a material", 2 * 4 * kTableWords),
            "wedges and accelerations, bonded and loose");
    map.row("result  header", fmt::format("{} B", 4 * kResultHeader), "conditions, counts");
    map.row("        loads", fmt::format("{} x {} B", limits::kBodyCapacity, 4 * kLoadWords),
            "soil that each body carries");
    map.row("        contacts",
            fmt::format("{} x {} B", limits::kContactCapacity, 4 * kContactWords),
            "voxels in which bodies meet soil");
    return map.text();
}

TEST(MemoryMap, stands_where_the_buffers_are_declared) {
    std::ifstream file(BSOIL_SOURCE_DIR "/shaders/buffer_list.h");
    std::stringstream text;
    text << file.rdbuf();
    const std::string map = memory_map();
    EXPECT_NE(text.str().find(map), std::string::npos) << "shaders/buffer_list.h should say:\n"
                                                       << map;
}

TEST(MemoryMap, names_every_buffer) {
    const std::string map = memory_map();
#define BUFFER(name) EXPECT_NE(map.find("// " #name), std::string::npos) << #name;
#include "buffer_list.h"
#undef BUFFER
}

}  // namespace
}  // namespace bsoil::memory_map_test
