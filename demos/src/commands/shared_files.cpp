#include "shared_files.h"

#include <filesystem>

namespace bsoil::command {

std::string shared_folder(const std::string& name) {
    namespace fs = std::filesystem;
    std::error_code failed;
    const fs::path program = fs::read_symlink("/proc/self/exe", failed);
    return (program.parent_path() / BSOIL_SHARE_FOLDER / name).lexically_normal().string();
}

}  // namespace bsoil::command
