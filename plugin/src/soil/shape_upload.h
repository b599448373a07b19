/// ShapeUpload: what the device is told of bodies and their shapes.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "bsoil/distance_lattice.h"
#include "soil/body_table.h"

namespace bsoil {

/// Buffer::shapes: bodies, shapes and planes of the sub-step at hand, room for more of them, then
/// the lattices, which stay.
class ShapeUpload {
  public:
    explicit ShapeUpload(SoilCore& core) : core_(core) {}
    /// Once the device is there.
    void start();

    /// Body and shape records for the bodies at share t of the step. ids: SoilBody::id by index.
    void upload(std::span<const StepBody> bodies, std::span<const int> ids, double t);
    /// Boxes around the shapes [voxels], in the order of their records.
    std::span<const Aabb> boxes() const { return boxes_; }
    /// Whether a shape may cover voxels of the block whose middle this is [voxels].
    bool may_cover(size_t shape, const Vec3& block_middle) const;
    std::span<const int32_t> words() const { return words_; }

  private:
    struct LatticePlace {
        std::shared_ptr<const DistanceLattice> lattice;
        size_t offset = 0;  ///< in Buffer::shapes [words]
    };
    /// A shape and the place of its record.
    using ShapeAt = std::pair<size_t, const ConvexShape*>;

    void add_body(const StepBody& body);
    void add_shape(const ConvexShape& shape, const Pose& pose, int body_index);
    void add_size(const ConvexShape& shape, size_t record);
    void add_planes(const ConvexShape& shape, size_t record);
    void put_float(size_t at, double value);
    void write_words(std::span<const int> ids);
    bool place_lattices();
    const LatticePlace* place_of(const ConvexShape& shape) const;

    SoilCore& core_;
    std::vector<LatticePlace> lattices_;
    size_t capacity_ = 0;  ///< words before the first lattice
    // Scratch, kept so that a step does not allocate once warm.
    std::vector<int32_t> words_;
    std::vector<Aabb> boxes_;
    std::vector<ShapeAt> hulls_, lattice_shapes_;
};

}  // namespace bsoil
