/// Meshes many tiles on several threads.
#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "bsoil/work_threads.h"
#include "mesh/tile_mesher.h"

namespace bsoil::mesh {

/// A tile whose mesh is to be made.
struct TileJob {
    int tx = 0, ty = 0;
    Mesh* mesh = nullptr;
};

/// A TileMesher for each thread that asks for one. The source is read here alone, in the thread
/// that makes this.
class TileMeshers {
  public:
    TileMeshers(const TileSource& source, const SurfaceMeshDef& def)
        : writer_(source, def), close_floor_(def.close_floor) {}

    /// As VertexWriter::take_colors(), for what is built from now on.
    bool take_colors(const std::vector<MaterialDef>& materials) {
        return writer_.take_colors(materials);
    }

    void build(const GridColumns& grid, const TileLevels& levels, std::span<const TileJob> jobs,
               const WorkThreads& threads) {
        threads.for_ranges(jobs.size(), kTilesLeast, [&](size_t first, size_t last) {
            std::unique_ptr<TileMesher> mesher = take();
            for (const TileJob& job : jobs.subspan(first, last - first)) {
                mesher->build(grid, levels, job.tx, job.ty, *job.mesh);
            }
            const std::scoped_lock lock(mutex_);
            idle_.push_back(std::move(mesher));
        });
    }

    /// Tiles that a thread takes at once. Ours: 4, a tenth of a millisecond. Larger: threads that
    /// wait for the last one; smaller: the handing over.
    static constexpr size_t kTilesLeast = 4;

  private:
    std::unique_ptr<TileMesher> take() {
        {
            const std::scoped_lock lock(mutex_);
            if (!idle_.empty()) {
                std::unique_ptr<TileMesher> mesher = std::move(idle_.back());
                idle_.pop_back();
                return mesher;
            }
        }
        return std::make_unique<TileMesher>(writer_, close_floor_);
    }

    VertexWriter writer_;
    bool close_floor_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<TileMesher>> idle_;
};

}  // namespace bsoil::mesh
