/// What the CPU backend runs on.
#pragma once

#include <string>

namespace bsoil::device {

std::string cpu_model_name();
/// Threads that the CPU backend takes by default.
int cpu_thread_count();

}  // namespace bsoil::device
