/// Devices that run the test kernels, one per backend.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "device/device.h"
#include "device/kernel_set.h"

namespace bsoil::device {

/// The kernels of tests/device/kernels/kernel_list.h.
const KernelSet& test_kernel_set();

enum TestKernel {
#define PLAIN(name) name,
#define SCATTER(name) name,
#include "kernels/kernel_list.h"
#undef PLAIN
#undef SCATTER
};

/// A work list of groups that all belong to tiles of `groups_per_tile`; colours alternate.
WorkList plain_work(int group_count, int groups_per_tile = 4);

/// The uniform block of the test kernels.
struct TestParams {
#include "kernels/test_params.h"
};
/// `params` as words for Device::dispatch.
std::span<const int32_t> words_of(const TestParams& params);
/// Runs a kernel over a list.
void dispatch(Device& device, TestKernel kernel, const WorkList& work,
              const TestParams& params = {});

/// The buffers of the test kernels.
struct Buffer {
    enum Place {
#define BUFFER(name) place_of_##name,
#include "kernels/buffer_list.h"
#undef BUFFER
        count
    };
#define BUFFER(name) static constexpr BufferIndex name{place_of_##name};
#include "kernels/buffer_list.h"
#undef BUFFER
};

/// The whole of a buffer of known size.
std::vector<int32_t> read_words(Device& device, BufferIndex buffer, int64_t count);

/// Runs each test on the CPU with one and with two threads and on OpenGL (software allowed, which
/// also dispatches as a GPU does).
class AnyDevice : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override;
    std::unique_ptr<Device> device_;
};

/// "cpu1", "cpu2", "gl", "gl_as_hardware" or "gl_in_small_blocks" (long buffers in storage blocks
/// of 4 MiB); null with a reason where this machine has no such device.
std::unique_ptr<Device> create_test_device(const std::string& name, std::string& reason);

}  // namespace bsoil::device
