#include "own_files.h"

#include <algorithm>
#include <filesystem>
#include <vector>

namespace bsoil::scene {

bool is_numbered(std::string_view name, std::string_view before, size_t digits_least,
                 std::string_view after) {
    const size_t around = before.size() + after.size();
    if (!name.starts_with(before) || name.size() < around + digits_least) return false;
    if (!name.substr(before.size()).ends_with(after)) return false;
    const std::string_view digits = name.substr(before.size(), name.size() - around);
    return std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; });
}

Status remove_own_files(const std::string& folder,
                        const std::function<bool(std::string_view name)>& is_own) {
    namespace fs = std::filesystem;
    std::error_code failed;
    if (!fs::is_directory(folder, failed)) return Done{};
    std::vector<fs::path> own;
    for (fs::directory_iterator at(folder, failed), end; !failed && at != end;
         at.increment(failed)) {
        std::error_code unknown;
        if (!fs::is_regular_file(at->symlink_status(unknown))) continue;
        if (is_own(at->path().filename().string())) own.push_back(at->path());
    }
    if (failed) return Error{folder + ": " + failed.message()};
    for (const fs::path& path : own) {
        fs::remove(path, failed);
        if (failed) return Error{path.string() + ": cannot be removed: " + failed.message()};
    }
    return Done{};
}

}  // namespace bsoil::scene
