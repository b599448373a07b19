/// Single stages of the step on a small grid, all of it awake and dispatched, with the state as
/// dense integer planes.
#pragma once

#include <functional>
#include <map>
#include <random>

#include "base/kernels.h"
#include "oracle/contacts.h"
#include "oracle/field.h"
#include "oracle/slippage.h"
#include "soil_fixture.h"

namespace bsoil {

/// Every state plane of soil_layout.h, dense.
struct StatePlanes {
    int nx = 0, ny = 0, nz = 0, plane_count = 0;
    std::vector<int32_t> words;
    int32_t& at(int plane, int x, int y, int z) { return words[index(plane, x, y, z)]; }
    int32_t at(int plane, int x, int y, int z) const { return words[index(plane, x, y, z)]; }
    bool operator==(const StatePlanes&) const = default;

  private:
    size_t index(int plane, int x, int y, int z) const {
        return ((static_cast<size_t>(plane) * nz + z) * ny + y) * nx + x;
    }
};

class StageBench {
  public:
    explicit StageBench(const SoilDef& def);

    const Soil& soil() const { return *soil_; }
    Soil::Impl& impl() { return SoilProbe::impl(*soil_); }

    StatePlanes empty_planes() const;
    void write(const StatePlanes& planes);
    StatePlanes read() const;

    /// Voxelizes bodies into the coverage field; their velocities are used from then on.
    void place(const std::vector<Mover>& movers);
    /// The stages, one pass each.
    void find_support();
    void apply_force();
    void propagate_force();                              ///< with apply_flow
    void advect(int substeps, int substep = 0);          ///< with apply_flow
    void resolve_overflow(OverflowHeuristic heuristic);  ///< of all blocks, with apply_flow
    void build_spans();
    void find_failures();        ///< with break_bonds, after build_spans
    void find_failures_again();  ///< the same, where soil failed in the look before
    /// By column [y * nx + x] the height of the plane above which soil has no cohesion, infinity
    /// where there is none: what find_failures left, or is to have left.
    std::vector<double> read_cuts() const;
    void write_cuts(const std::vector<double>& heights);
    /// With apply_flow; from the set of speeds of write_speeds.
    void slip(int substeps, int stride = 1);
    void move_water();       ///< with apply_flow, after build_spans
    void slide(int passes);  ///< one of so many in a step, with apply_flow
    std::vector<std::array<int32_t, layout::kContactWords>> collect_contacts();  ///< sorted

    /// Words of a column of the span buffer.
    std::vector<int32_t> read_column(int x, int y) const;
    /// Height of the free surface of a column (Q16), -1 where a body stands on it.
    int32_t read_surface(int x, int y) const;
    /// Slip speeds (Q16), [(y * nx + x) * kSpanCapacity + span]: those the next slip reads, those
    /// the last one wrote.
    void write_speeds(const std::vector<int32_t>& speeds);
    std::vector<int32_t> read_speeds() const;
    uint32_t result_status() const;

    /// The same state and bodies for the oracle.
    oracle::Field to_field(const StatePlanes& planes) const;
    oracle::Model model(int substeps = 1) const;
    std::vector<oracle::Body> oracle_bodies() const;

  private:
    int slot_of(int x, int y) const;
    int64_t column_words_at(int x, int y) const;
    int64_t cut_word_at(int x, int y) const;
    void run(layout::Kernel kernel, const ListedWork& work);
    void fill_masks(std::initializer_list<int> masks);

    std::unique_ptr<Soil> soil_;
    Soil::Impl* impl_ = nullptr;
    std::vector<BodyTrack> tracks_;
};

/// Largest difference of a quantity over all voxels, and where.
struct Deviation {
    double value = 0;
    int x = 0, y = 0, z = 0;
    double got = 0, expected = 0;
    void take(double got_value, double expected_value, int px, int py, int pz);
};
std::ostream& operator<<(std::ostream& out, const Deviation& deviation);

/// Soil (with its bonded part), masses and momentum of a kernel's result against the oracle's.
struct FieldDeviation {
    Deviation soil, mass, momentum;
};
FieldDeviation compare(const oracle::Field& got, const oracle::Field& expected, int material_count);

}  // namespace bsoil
