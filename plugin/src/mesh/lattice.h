/// Where the samples of a level of detail lie along one axis of the grid.
#pragma once

namespace bsoil::mesh {

/// Samples lie at the centre of each `spacing`-th voxel, the first one on, and at two more places
/// beyond each side of the grid, both *on* its boundary. Index i along an axis of n voxels:
///
///     i         -2  -1   0         1          ...  count - 1  count  count + 1
///     voxel      .   .   0      spacing       ...     .         .       .
///     position   0   0  0.5  spacing + 0.5    ...     .         n       n
///
/// A level's samples are samples of each finer level, too.
struct Lattice {
    int size = 0;     ///< voxels
    int spacing = 1;  ///< voxels from one sample to the next: a power of two

    /// Samples in voxels.
    int count() const { return (size + spacing - 1) / spacing; }
    /// Where sample i lies [voxels].
    float position(int i) const {
        if (i < 0) return 0.0f;
        const auto voxel = static_cast<float>(i < count() ? i * spacing : size);
        return i < count() ? voxel + 0.5f : voxel;
    }
    /// The voxel of sample i; -1 and `size` are beyond the sides.
    int voxel(int i) const { return i < 0 ? -1 : i < count() ? i * spacing : size; }
    /// The same sample in the lattice of half the spacing.
    int in_finer(int i) const {
        if (i < 0) return i;
        const Lattice finer{size, spacing / 2};
        return i < count() ? 2 * i : finer.count() + i - count();
    }
    /// The finer lattice has a sample between i and i + 1.
    bool has_middle(int i) const { return in_finer(i + 1) - in_finer(i) == 2; }
};

}  // namespace bsoil::mesh
