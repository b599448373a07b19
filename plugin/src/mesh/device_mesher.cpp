#include "mesh/device_mesher.h"

#include <algorithm>
#include <bit>

#include "device/kernel_set.h"
#include "mesh/marching_cases.h"

namespace bsoil::mesh {
namespace {

using device::BufferIndex;
using kernels::Buffer;

static_assert(kernels::kWindowSide == DisplayField::kWindow);
static_assert(kernels::kWindowColumns == kernels::kWindowSide * kernels::kWindowSide);
static_assert(kernels::kWindowGroups * kernels::kGroupLanes >= kernels::kWindowColumns);
static_assert(kernels::kGroupLanes == device::kLanesPerGroup);
static_assert(kernels::kTileSide == kTileSide);
static_assert(kernels::kBareDepth == kBareDepth);
static_assert(kernels::kKeptWords == kernels::kKeptLook + kernels::kLookWords);

/// What a tile of level ground has, for a first guess of the room that meshes take.
constexpr size_t kVerticesOfTile = 256, kTrianglesOfTile = 512;
/// Buffers grow by this much beyond what is asked for.
constexpr size_t kGrowthDivisor = 2;

int32_t bits_of(float value) { return std::bit_cast<int32_t>(value); }
float float_of(int32_t bits) { return std::bit_cast<float>(bits); }

GridVector vector_at(const int32_t* words) {
    return {float_of(words[0]), float_of(words[1]), float_of(words[2])};
}

/// marching_cases() as the kernels read them.
std::vector<int32_t> case_words() {
    constexpr int kEdgesPerWord = kernels::kCaseEdgesPerWord;
    static_assert(1 + (3 * MarchingCase::kTriangleCapacity + kEdgesPerWord - 1) / kEdgesPerWord ==
                  kernels::kCaseWords);
    std::vector<int32_t> words;
    for (const MarchingCase& entry : marching_cases()) {
        uint32_t edges[kernels::kCaseWords - 1] = {};
        for (int k = 0; k < 3 * entry.triangle_count; ++k) {
            edges[k / kEdgesPerWord] |= uint32_t{entry.edges[static_cast<size_t>(k)]}
                                        << (kernels::kCaseEdgeBits * (k % kEdgesPerWord));
        }
        words.push_back(entry.triangle_count);
        for (const uint32_t word : edges) words.push_back(static_cast<int32_t>(word));
    }
    return words;
}

/// `tile_groups` groups for each of `tile_count` tiles.
device::WorkList work_list(int tile_count, int tile_groups) {
    device::WorkList work;
    work.group_count = tile_count * tile_groups;
    for (int t = 0; t < tile_count; ++t) {
        work.tiles_by_colour[0].push_back({t * tile_groups, tile_groups});
    }
    return work;
}

void push_bits(std::vector<int32_t>& words, uint64_t bits) {
    words.push_back(static_cast<int32_t>(bits & 0xFFFFFFFF));
    words.push_back(static_cast<int32_t>(bits >> 32));
}

}  // namespace

Result<std::unique_ptr<DeviceMesher>> DeviceMesher::create(const TileSource& source,
                                                           const SurfaceMeshDef& def,
                                                           bool allow_software) {
    auto made = device::create_gl_device(device::mesh_kernel_set(), allow_software);
    if (!made) return Error{made.error()};
    return std::make_unique<DeviceMesher>(std::move(*made), source, def);
}

DeviceMesher::DeviceMesher(std::unique_ptr<device::Device> device, const TileSource& source,
                           const SurfaceMeshDef& def)
    : device_(std::move(device)),
      writer_(source, def),
      border_mesher_(writer_, def.close_floor),
      close_floor_(def.close_floor) {}

Status DeviceMesher::build(const GridColumns& grid, const TileLevels& levels,
                           std::span<const TileJob> jobs, const WorkThreads* threads) {
    if (jobs.empty()) return Done{};
    fields_.resize(std::max(fields_.size(), std::min(kBatch, jobs.size())));
    while (!jobs.empty()) {
        const std::span<const TileJob> batch = jobs.first(std::min(kBatch, jobs.size()));
        jobs = jobs.subspan(batch.size());
        tiles_.assign(kernels::kHeaderWords, 0);
        columns_.clear();
        runs_.clear();
        if (kept_) look_words_.begin(runs_);
        work_words_ = 0;
        for_ranges(threads, batch.size(), TileMeshers::kTilesLeast, [&](size_t first, size_t last) {
            for (size_t t = first; t < last; ++t) {
                const auto& [tx, ty, mesh] = batch[t];
                fields_[t].build(grid, levels, levels.at(tx, ty), tx, ty);
            }
        });
        for (size_t t = 0; t < batch.size(); ++t) write_tile(levels, fields_[t]);
        if (const Status ran = run(grid); !ran) return ran;
        if (kept_) {
            if (const Status kept = keep_batch(grid, batch); !kept) return kept;
            continue;
        }
        for_ranges(threads, batch.size(), TileMeshers::kTilesLeast, [&](size_t first, size_t last) {
            for (size_t t = first; t < last; ++t) take(fields_[t], t, *batch[t].mesh);
        });
        for (size_t t = 0; t < batch.size(); ++t) {
            if (!levels.is_beside_finer(batch[t].tx, batch[t].ty)) continue;
            add_border(grid, levels, batch[t], t);
        }
    }
    return kept_ ? write_draws() : Status(Done{});
}

void DeviceMesher::write_tile(const TileLevels& levels, const DisplayField& field) {
    const int word_count = 2 * field.word_count();
    const size_t record = tiles_.size();
    tiles_.resize(record + kernels::kTileWords, 0);
    int32_t* tile = &tiles_[record];
    tile[kernels::kTileSpacing] = field.lattice(0).spacing;
    tile[kernels::kTileOriginX] = field.origin(0);
    tile[kernels::kTileOriginY] = field.origin(1);
    tile[kernels::kTileFirstX] = field.cell_first(0);
    tile[kernels::kTileFirstY] = field.cell_first(1);
    tile[kernels::kTileLastX] = field.cell_last(0);
    tile[kernels::kTileLastY] = field.cell_last(1);
    tile[kernels::kTileColumnsAt] = static_cast<int32_t>(columns_.size());
    tile[kernels::kTileWordCount] = word_count;
    tile[kernels::kTileWorkAt] = static_cast<int32_t>(work_words_);
    work_words_ += static_cast<size_t>(
        kernels::kWindowColumns *
        (kernels::kEdgesOfColumn * (kernels::kEdgeBits + word_count) + kernels::kCellWords));
    for (int j = 0; j < kernels::kWindowSide; ++j) {
        for (int i = 0; i < kernels::kWindowSide; ++i) {
            write_column(levels, field, field.origin(0) + i, field.origin(1) + j);
        }
    }
}

void DeviceMesher::write_column(const TileLevels& levels, const DisplayField& field, int i, int j) {
    const auto place = [&] { return static_cast<int32_t>(runs_.size()); };
    std::array<int32_t, 2> layers{};
    looks_.clear();
    if (kept_) {
        for (const Run& run : field.runs(i, j)) looks_.push_back(look_words_.add(run.look, runs_));
        layers[0] = look_words_.add_layers(field, i, j, runs_);
        layers[1] = place();
    }
    columns_.push_back(place());
    size_t number = 0;
    for (const Run& run : field.runs(i, j)) {
        runs_.insert(runs_.end(),
                     {bits_of(run.bottom), bits_of(run.top), run.in_solid,
                      kept_ ? looks_[number] : 0, kept_ ? look_words_.plain(run.material) : 0});
        ++number;
    }
    columns_.push_back(place());
    columns_.push_back(place());
    for (const SolidRun& solid : field.solids(i, j)) {
        runs_.insert(runs_.end(), {bits_of(solid.bottom), bits_of(solid.top)});
    }
    columns_.push_back(place());
    const bool is_near = i >= field.cell_first(0) - 1 && i <= field.cell_last(0) + 1 &&
                         j >= field.cell_first(1) - 1 && j <= field.cell_last(1) + 1;
    columns_.push_back(is_near && levels.is_plain(field.level(), i, j));
    columns_.push_back(field.material(i, j, 0));
    columns_.insert(columns_.end(), layers.begin(), layers.end());
    for (int w = 0; w < field.word_count(); ++w) push_bits(columns_, field.inside_bits(i, j)[w]);
    for (int w = 0; w < field.word_count(); ++w) {
        push_bits(columns_, field.material_borders(i, j, w));
    }
}

size_t DeviceMesher::capacity(BufferIndex buffer) const {
    return words_in_[static_cast<size_t>(buffer)];
}

/// The buffer may be larger than it has to be: then it stays as it is.
Status DeviceMesher::reserve(BufferIndex buffer, size_t word_count) {
    if (word_count <= capacity(buffer)) return Done{};
    const size_t wanted = word_count + word_count / kGrowthDivisor;
    const Status allocated = device_->allocate(buffer, static_cast<int64_t>(wanted));
    words_in_[static_cast<size_t>(buffer)] = allocated ? wanted : 0;
    return allocated;
}

Status DeviceMesher::upload(BufferIndex buffer, std::span<const int32_t> words) {
    if (const Status reserved = reserve(buffer, words.size()); !reserved) return reserved;
    device_->write(buffer, 0, words);
    return Done{};
}

Status DeviceMesher::failed() const {
    if (device_->failure().empty()) return Done{};
    return Error{device_->failure()};
}

/// The device has had room for all, by the totals it has counted.
bool DeviceMesher::has_room() const {
    const auto holds = [&](BufferIndex buffer, int total, int words) {
        return static_cast<size_t>(tiles_[static_cast<size_t>(total)]) *
                   static_cast<size_t>(words) <=
               capacity(buffer);
    };
    return holds(Buffer::vertices, kernels::kTotalVertices, kernels::kVertexWords) &&
           holds(Buffer::copies, kernels::kTotalCopies, kernels::kCopyWords) &&
           holds(Buffer::triangles, kernels::kTotalTriangles, kernels::kTriangleWords);
}

namespace {

std::span<const int32_t> words_of(const kernels::Params& params) {
    return {reinterpret_cast<const int32_t*>(&params), sizeof(params) / sizeof(int32_t)};
}

}  // namespace

void DeviceMesher::dispatch_all() {
    const device::WorkList columns = work_list(params_.tile_count, kernels::kWindowGroups);
    const device::WorkList tiles =
        work_list((params_.tile_count + kernels::kGroupLanes - 1) / kernels::kGroupLanes, 1);
    using kernels::Kernel;
    for (const Kernel kernel :
         {Kernel::count_edges, Kernel::place_edges, Kernel::make_vertices, Kernel::count_triangles,
          Kernel::place_triangles, Kernel::make_triangles}) {
        const bool is_of_tiles = kernel == Kernel::place_edges || kernel == Kernel::place_triangles;
        device_->dispatch(static_cast<int>(kernel), words_of(params_),
                          is_of_tiles ? tiles : columns);
    }
}

/// Leaves what the device has counted in tiles_, and its meshes in vertices_, copies_, triangles_.
Status DeviceMesher::run(const GridColumns& grid) {
    const device::DeviceSession session(*device_);
    if (!has_cases_) {
        if (const Status cases = upload(Buffer::cases, case_words()); !cases) return cases;
        has_cases_ = true;
    }
    const size_t tile_count = (tiles_.size() - kernels::kHeaderWords) / kernels::kTileWords;
    size_t wanted[3] = {tile_count * kVerticesOfTile, tile_count, tile_count * kTrianglesOfTile};
    do {
        for (const Status& made :
             {reserve(Buffer::work, work_words_),
              reserve(Buffer::vertices, wanted[0] * kernels::kVertexWords),
              reserve(Buffer::copies, wanted[1] * kernels::kCopyWords),
              reserve(Buffer::triangles, wanted[2] * kernels::kTriangleWords),
              upload(Buffer::columns, columns_), upload(Buffer::runs, runs_)}) {
            if (!made) return made;
        }
        std::fill_n(tiles_.begin(), kernels::kHeaderWords, 0);
        if (const Status tiles = upload(Buffer::tiles, tiles_); !tiles) return tiles;
        kernels::Params& params = params_;
        params.size_x = grid.size[0];
        params.size_y = grid.size[1];
        params.size_z = grid.size[2];
        params.tile_count = static_cast<int>(tile_count);
        params.close_floor = close_floor_;
        params.vertex_capacity =
            static_cast<int>(capacity(Buffer::vertices) / kernels::kVertexWords);
        params.copy_capacity = static_cast<int>(capacity(Buffer::copies) / kernels::kCopyWords);
        params.triangle_capacity =
            static_cast<int>(capacity(Buffer::triangles) / kernels::kTriangleWords);
        dispatch_all();
        device_->read(Buffer::tiles, 0, tiles_);
        if (const Status alive = failed(); !alive) return alive;
        for (size_t k = 0; k < 3; ++k) wanted[k] = static_cast<size_t>(tiles_[k]);
    } while (!has_room());
    if (kept_) return Done{};
    vertices_.resize(wanted[0] * kernels::kVertexWords);
    copies_.resize(wanted[1] * kernels::kCopyWords);
    triangles_.resize(wanted[2] * kernels::kTriangleWords);
    const device::ReadRange ranges[] = {{Buffer::vertices, 0, vertices_},
                                        {Buffer::copies, 0, copies_},
                                        {Buffer::triangles, 0, triangles_}};
    device_->read(ranges);
    return failed();
}

Status DeviceMesher::grow(BufferIndex buffer, int64_t word_count) {
    if (static_cast<size_t>(word_count) <= capacity(buffer)) return Done{};
    const int64_t wanted = word_count + word_count / static_cast<int64_t>(kGrowthDivisor);
    Status grown = device_->grow(buffer, wanted);
    if (grown) words_in_[static_cast<size_t>(buffer)] = static_cast<size_t>(wanted);
    return grown;
}

/// The meshes just made get places of their own. The host learns their sizes alone.
Status DeviceMesher::keep_batch(const GridColumns& grid, std::span<const TileJob> batch) {
    for (size_t t = 0; t < batch.size(); ++t) {
        writer_.begin(*batch[t].mesh);
        int32_t* tile = &tiles_[kernels::kHeaderWords + t * kernels::kTileWords];
        const auto number = static_cast<size_t>(batch[t].ty * grid.tile_count[0] + batch[t].tx);
        const KeptMeshes::Place& place = kept_->place(
            number,
            int64_t{tile[kernels::kTileVertexCount]} + int64_t{tile[kernels::kTileCopyCount]},
            int64_t{tile[kernels::kTileTriangleCount]} * kernels::kTriangleWords);
        tile[kernels::kTileKeptVertexAt] = static_cast<int32_t>(place.vertex_at);
        tile[kernels::kTileKeptIndexAt] = static_cast<int32_t>(place.index_at);
    }
    const device::DeviceSession session(*device_);
    for (const Status& made :
         {grow(Buffer::kept_vertices, kept_->vertex_end() * kernels::kKeptWords),
          grow(Buffer::kept_indices, kept_->index_end()), upload(Buffer::tiles, tiles_)}) {
        if (!made) return made;
    }
    device_->dispatch(static_cast<int>(kernels::Kernel::keep_mesh), words_of(params_),
                      work_list(params_.tile_count, kernels::kWindowGroups));
    return failed();
}

/// A command of glMultiDrawElementsIndirect for each tile.
Status DeviceMesher::write_draws() {
    draws_.clear();
    for (const KeptMeshes::Place& place : kept_->places()) {
        draws_.insert(draws_.end(), {static_cast<int32_t>(place.index_count), 1,
                                     static_cast<int32_t>(place.index_at),
                                     static_cast<int32_t>(place.vertex_at), 0});
    }
    return upload(Buffer::kept_draws, draws_);
}

void DeviceMesher::take_vertex(const DisplayField& field, const int32_t* tile,
                               const int32_t* vertex, Mesh& mesh) const {
    const GridVector position = vector_at(vertex + kernels::kVertexPosition),
                     outward = vector_at(vertex + kernels::kVertexOutward);
    const int column = vertex[kernels::kVertexLook] / kernels::kLookKinds;
    const int i = tile[kernels::kTileOriginX] + column % kernels::kWindowSide;
    const int j = tile[kernels::kTileOriginY] + column / kernels::kWindowSide;
    const float z = field.height(vertex[kernels::kVertexSample]);
    switch (vertex[kernels::kVertexLook] % kernels::kLookKinds) {
        case kernels::kLookFloor:
            writer_.add(mesh, position, outward, writer_.look_of(field.material(i, j, 0)));
            break;
        case kernels::kLookCut:
            writer_.add(mesh, position, outward, writer_.look_inside(field, i, j, z));
            break;
        default:
            writer_.add(mesh, position, outward, writer_.look_at(field, i, j, z));
    }
}

void DeviceMesher::take(const DisplayField& field, size_t tile, Mesh& mesh) const {
    const int32_t* record = &tiles_[kernels::kHeaderWords + tile * kernels::kTileWords];
    writer_.begin(mesh);
    const int vertex_at = record[kernels::kTileVertexAt];
    for (int v = vertex_at; v < vertex_at + record[kernels::kTileVertexCount]; ++v) {
        take_vertex(field, record, &vertices_[static_cast<size_t>(v) * kernels::kVertexWords],
                    mesh);
    }
    const int copy_at = record[kernels::kTileCopyAt];
    for (int c = copy_at; c < copy_at + record[kernels::kTileCopyCount]; ++c) {
        const int32_t* copy = &copies_[static_cast<size_t>(c) * kernels::kCopyWords];
        const int side = copy[kernels::kCopySide];
        writer_.add_copy(mesh, static_cast<uint32_t>(copy[kernels::kCopyOf]),
                         {static_cast<float>(side % 3 - 1), static_cast<float>(side / 3 - 1), 0});
    }
    const auto first =
        triangles_.begin() + int64_t{record[kernels::kTileTriangleAt]} * kernels::kTriangleWords;
    mesh.indices.assign(
        first, first + int64_t{record[kernels::kTileTriangleCount]} * kernels::kTriangleWords);
}

/// The cells beside finer tiles of a mesh just taken.
void DeviceMesher::add_border(const GridColumns& grid, const TileLevels& levels, const TileJob& job,
                              size_t tile) {
    const int32_t* record = &tiles_[kernels::kHeaderWords + tile * kernels::kTileWords];
    edges_.clear();
    places_.clear();
    const int vertex_at = record[kernels::kTileVertexAt];
    for (int v = vertex_at; v < vertex_at + record[kernels::kTileVertexCount]; ++v) {
        const int32_t* vertex = &vertices_[static_cast<size_t>(v) * kernels::kVertexWords];
        const int code = vertex[kernels::kVertexEdge];
        const int edge = code % kernels::kEdgesOfColumn, place = code / kernels::kEdgesOfColumn;
        const int column = place % kernels::kWindowColumns;
        edges_.push_back({edge == 0 ? 2 : edge - 1,
                          record[kernels::kTileOriginX] + column % kernels::kWindowSide,
                          record[kernels::kTileOriginY] + column / kernels::kWindowSide,
                          place / kernels::kWindowColumns});
        places_.push_back(vector_at(vertex + kernels::kVertexPosition));
    }
    const int copy_at = record[kernels::kTileCopyAt];
    for (int c = copy_at; c < copy_at + record[kernels::kTileCopyCount]; ++c) {
        const int32_t original = copies_[static_cast<size_t>(c) * kernels::kCopyWords];
        places_.push_back(GridVector(places_[static_cast<size_t>(original)]));
    }
    border_mesher_.add_border(grid, levels, job.tx, job.ty, edges_, places_, *job.mesh);
}

}  // namespace bsoil::mesh
