/// TemporaryFile: a file that no other test and no other process has, and that goes with its owner.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace bsoil {

class TemporaryFile {
  public:
    explicit TemporaryFile(const std::string& name)
        : path_(testing::TempDir() + "bsoil_" + std::to_string(getpid()) + "_" + name) {}
    ~TemporaryFile() {
        std::error_code ignored;  // it may never have been written
        std::filesystem::remove(path_, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

}  // namespace bsoil
