#include "bsoil/backend_choice.h"

#include <fmt/format.h>

#include "bsoil/device_info.h"
#include "soil/soil_kernels.h"

namespace bsoil {

std::vector<DeviceInfo> list_devices() { return device::list_devices(soil_kernel_set()); }

Result<std::unique_ptr<device::Device>> create_device(Backend backend, int thread_count,
                                                      std::string& reason) {
    if (backend == Backend::cpu) {
        reason = "the CPU backend was asked for";
        return device::create_cpu_device(soil_kernel_set(), thread_count);
    }
    auto gl_device = device::create_gl_device(soil_kernel_set(), backend == Backend::gl);
    if (backend == Backend::gl) {
        reason = "the OpenGL backend was asked for";
        return gl_device;
    }
    if (gl_device) {
        reason = fmt::format("{} offers OpenGL 4.5 compute", (*gl_device)->device_name());
        return gl_device;
    }
    reason = gl_device.error();
    return device::create_cpu_device(soil_kernel_set(), thread_count);
}

Result<BackendChoice> choose_backend(Backend backend, int thread_count) {
    SoilDef def;
    def.thread_count = thread_count;
    if (const Status sound = def.validate(); !sound) return Error{sound.error()};
    BackendChoice choice;
    const auto made = create_device(backend, thread_count, choice.reason);
    if (!made) return Error{made.error()};
    choice.backend_name = (*made)->backend_name();
    choice.device_name = (*made)->device_name();
    choice.thread_count = (*made)->thread_count();
    return choice;
}

}  // namespace bsoil
