/// What the CPU backend asks of the system.
#include <fstream>
#include <sstream>

#include "device_fixture.h"

namespace bsoil::device::cpu_device_test {

/// Memory of this process for which huge pages were asked [KB].
int64_t huge_page_kb() {
    std::ifstream maps("/proc/self/smaps");
    int64_t size_kb = 0, asked_kb = 0;
    for (std::string line; std::getline(maps, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "Size:") words >> size_kb;
        if (word != "VmFlags:") continue;
        while (words >> word) asked_kb += word == "hg" ? size_kb : 0;
    }
    return asked_kb;
}

TEST(CpuDevice, asks_for_huge_pages_for_large_buffers_alone) {
    if (!std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled")) {
        GTEST_SKIP() << "the system has no huge pages";
    }
    const auto device = create_cpu_device(test_kernel_set(), 1);
    const int64_t before = huge_page_kb();
    constexpr int64_t kMegabyte = int64_t{1} << 18;  // words
    ASSERT_TRUE(device->allocate(Buffer::inputs, kMegabyte));
    EXPECT_EQ(huge_page_kb(), before);
    ASSERT_TRUE(device->allocate(Buffer::inputs, 64 * kMegabyte));
    EXPECT_GE(huge_page_kb() - before, 63 * 1024);  // a page less at its start
}

}  // namespace bsoil::device::cpu_device_test
