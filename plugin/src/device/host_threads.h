/// Threads for what the host does between kernels.
#pragma once

#include <tbb/task_arena.h>

#include "device/parallel_ranges.h"

namespace bsoil::device {

class HostThreads {
  public:
    /// count: 0 = all cores.
    explicit HostThreads(int count) : arena_(count > 0 ? count : tbb::task_arena::automatic) {}
    /// Calls body(i) for all i of 0..count - 1, in any order and at the same time, and waits for
    /// all of them. On one thread in order.
    template <typename Body>
    void run(size_t count, const Body& body) {
        const auto range = [&](size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) {
                body(i);
            }
        };
        if (count < 2 || arena_.max_concurrency() == 1) {
            range(0, count);
        } else {
            arena_.execute([&] { parallel_ranges(count, range); });
        }
    }

  private:
    tbb::task_arena arena_;
};

}  // namespace bsoil::device
