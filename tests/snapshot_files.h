/// What tests of snapshots share: files of their own that are gone afterwards.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace bsoil {

/// Files "a" and "b" of each test.
class SnapshotFiles : public testing::Test {
  protected:
    std::string path(const std::string& name) const {
        return (std::filesystem::temp_directory_path() /
                ("bsoil_" + std::to_string(getpid()) + "_" +
                 testing::UnitTest::GetInstance()->current_test_info()->name() + "_" + name))
            .string();
    }
    void TearDown() override {
        for (const char* name : {"a", "b"}) std::filesystem::remove(path(name));
    }
    static std::vector<char> bytes_of(const std::string& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write_bytes(const std::string& file, const std::vector<char>& bytes) {
        std::ofstream(file, std::ios::binary)
            .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
};

}  // namespace bsoil
