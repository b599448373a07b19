#include "bsoil/work_threads.h"

#include <tbb/task_arena.h>

#include <algorithm>

#include "device/parallel_ranges.h"

namespace bsoil {

struct WorkThreads::Arena {
    tbb::task_arena arena;
};

WorkThreads::WorkThreads(int count)
    : arena_(new Arena{
          tbb::task_arena(count > 0 ? std::min(count, kCountMost) : tbb::task_arena::automatic)}) {}

WorkThreads::~WorkThreads() = default;

void WorkThreads::run(size_t count, size_t least, const void* body,
                      void (*call)(const void*, size_t, size_t)) const {
    if (count <= least || arena_->arena.max_concurrency() == 1) {
        if (count > 0) call(body, 0, count);
        return;
    }
    arena_->arena.execute([&] {
        device::parallel_ranges(
            count, [&](size_t first, size_t last) { call(body, first, last); }, least);
    });
}

}  // namespace bsoil
