/// Choice of a device, and what all of them share.
#include "device/device.h"

#include <fmt/format.h>

#include "device/allocation_error.h"
#include "device/egl_context.h"
#include "device/kernel_set.h"

namespace bsoil::device {

const char* buffer_name(Buffer buffer) {
    static constexpr const char* kNames[kBufferCount] = {"state",      "delta",       "tile_table",
                                                         "block_list", "block_flags", "spans",
                                                         "shapes",     "tables",      "result"};
    return kNames[static_cast<int>(buffer)];
}

Error allocation_error(Buffer buffer, int64_t words, const std::string& reason) {
    constexpr double kWordsPerMebibyte = 1024.0 * 1024.0 / sizeof(int32_t);
    return {fmt::format("buffer {}: cannot allocate {:.1f} MiB: {}", buffer_name(buffer),
                        static_cast<double>(words) / kWordsPerMebibyte, reason)};
}

bool covers_all_groups(const WorkList& work) {
    int group_count = 0;
    for (const auto& tiles : work.tiles_by_colour) {
        for (const TileRange& tile : tiles) {
            group_count += tile.group_count;
        }
    }
    return group_count == work.group_count;
}

std::unique_ptr<Device> create_cpu_device(int thread_count) {
    return create_cpu_device(soil_kernel_set(), thread_count);
}

Result<std::unique_ptr<Device>> create_gl_device(bool allow_software) {
    return create_gl_device(soil_kernel_set(), allow_software);
}

Result<std::unique_ptr<Device>> create_device(Backend backend, int thread_count,
                                              std::string& reason) {
    if (backend == Backend::cpu) {
        reason = "the CPU backend was asked for";
        return create_cpu_device(thread_count);
    }
    auto gl_device = create_gl_device(backend == Backend::gl);
    if (backend == Backend::gl) {
        reason = "the OpenGL backend was asked for";
        return gl_device;
    }
    if (gl_device) {
        reason = fmt::format("{} offers OpenGL 4.5 compute", (*gl_device)->device_name());
        return gl_device;
    }
    reason = gl_device.error();
    return create_cpu_device(thread_count);
}

std::vector<DeviceInfo> list_devices() {
    const auto cpu = create_cpu_device(0);
    std::vector<DeviceInfo> devices{{.name = cpu->device_name(),
                                     .detail = fmt::format("CPU, {} threads", cpu->thread_count()),
                                     .usable = true,
                                     .hardware = true}};
    const auto displays = find_egl_displays();
    if (!displays) {
        devices.push_back({.name = "OpenGL", .detail = displays.error()});
        return devices;
    }
    for (const EglDisplay& display : *displays) {
        auto context = EglContext::create(display);
        if (!context) {
            devices.push_back({.name = display.name, .detail = context.error()});
            continue;
        }
        const GlCapabilities& gl = context->capabilities();
        const std::string shortfall = gl.shortfall();
        devices.push_back(
            {.name = gl.renderer,
             .detail = fmt::format("OpenGL {}, {} storage blocks of {} MiB at most{}", gl.version,
                                   gl.storage_block_count, gl.storage_block_bytes >> 20,
                                   shortfall.empty() ? "" : "; unusable: " + shortfall),
             .usable = shortfall.empty(),
             .hardware = !gl.is_software});
    }
    return devices;
}

}  // namespace bsoil::device
