/// The device layer: integer buffers and kernels, on the CPU or on OpenGL compute. It knows no
/// soil.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bsoil/result.h"
#include "bsoil/soil_def.h"

#pragma GCC visibility push(default)
namespace bsoil::device {

/// The kernels' buffers, in binding order (GL: shader storage blocks 0..). Names as in
/// shaders/soil_layout.h.
enum class Buffer {
    state,
    delta,
    tile_table,
    block_list,
    block_flags,
    spans,
    shapes,
    tables,
    result,
    count
};
inline constexpr int kBufferCount = static_cast<int>(Buffer::count);

/// Work of one dispatch: group g runs kernel(g, lane 0..63). Groups are ordered by tile; on the CPU
/// all groups of a tile run in order on one thread, and tiles of different colour never at once.
/// With 2 x 2 colours (x and y of the tile odd or even) a kernel may so add to the voxels of its
/// own tile, and to those of the eight around it up to half a tile away, without atomics: two tiles
/// of one colour reach different halves of the tile between them.
struct TileRange {
    int first_group = 0, group_count = 0;
};
struct WorkList {
    int list_offset = 0;  ///< where in Buffer::block_list group 0's entry is; kernels see it as
                          ///< params.list_offset
    int group_count = 0;
    std::vector<TileRange> tiles_by_colour[4];
};

/// A place where kernels run. Every call is in order.
class Device {
  public:
    virtual ~Device() = default;
    virtual std::string backend_name() const = 0;  ///< "cpu" or "gl"
    virtual std::string device_name() const = 0;
    virtual int thread_count() const = 0;
    /// (Re)allocates a buffer of `words` 32-bit words, zero-filled. Old content is lost.
    virtual Status allocate(Buffer buffer, int64_t words) = 0;
    virtual void write(Buffer buffer, int64_t offset, std::span<const int32_t> words) = 0;
    /// Waits for the device.
    virtual void read(Buffer buffer, int64_t offset, std::span<int32_t> words) = 0;
    virtual void fill_zero(Buffer buffer, int64_t offset, int64_t count) = 0;
    /// Sets the uniform block (struct SoilParams).
    virtual void set_params(std::span<const int32_t> words) = 0;
    /// Runs kernel number `kernel` of shaders/kernel_list.h over the list, then makes its writes
    /// visible to what follows. Sets params.list_offset and params.list_count itself.
    virtual void dispatch(int kernel, const WorkList& work) = 0;
    /// Waits for all work (for timing).
    virtual void finish() = 0;
    /// Direct view of a buffer where the device is the host (CPU backend), else nullptr.
    virtual int32_t* host_view(Buffer buffer) = 0;
    /// What broke the device after its creation (context refused, GPU lost or out of memory); empty
    /// while all is well. Once set, calls do nothing and reads give zeros.
    virtual std::string failure() const { return {}; }
    /// Bytes allocated on the device.
    virtual int64_t memory_bytes() const = 0;
};

/// The CPU backend. `thread_count` 0 = all cores.
std::unique_ptr<Device> create_cpu_device(int thread_count);
/// OpenGL 4.5 compute through EGL, surfaceless; software renderers only when `allow_software`.
/// The error says what is missing (no EGL, no 4.5, no compute). Leaves the caller's current context
/// as it was.
Result<std::unique_ptr<Device>> create_gl_device(bool allow_software);
/// `automatic`: hardware GL, else CPU. `reason` says in one sentence why.
Result<std::unique_ptr<Device>> create_device(Backend backend, int thread_count,
                                              std::string& reason);

/// One EGL device or the CPU, as `bsoil info` lists them.
struct DeviceInfo {
    std::string name;    ///< GL_RENDERER, or the CPU's model name
    std::string detail;  ///< version, compute limits, or why it can't be used
    bool usable = false, hardware = false;
};
std::vector<DeviceInfo> list_devices();

}  // namespace bsoil::device
#pragma GCC visibility pop
