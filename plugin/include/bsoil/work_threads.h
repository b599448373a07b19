/// WorkThreads: several cores for what the host does outside of kernels.
#pragma once

#include <cstddef>
#include <memory>

#include "bsoil/cxx20.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Runs a loop's parts at the same time. What a part does must not depend on the others: then the
/// result is the same on any number of threads. May be used from within a part.
class WorkThreads {
  public:
    /// Larger counts are taken for this one, the most that SoilDef::thread_count may be.
    static constexpr int kCountMost = 1024;
    /// count: 0 or less = all cores.
    explicit WorkThreads(int count);
    ~WorkThreads();
    WorkThreads(const WorkThreads&) = delete;
    WorkThreads& operator=(const WorkThreads&) = delete;

    /// Calls body(first, last) for ranges that make up 0..count, in any order and at the same time,
    /// and waits for all of them. least: a range that is no longer is not divided, > 0. Allocates
    /// nothing once warm.
    template <typename Body>
    void for_ranges(size_t count, size_t least, const Body& body) const {
        run(count, least, &body, [](const void* b, size_t first, size_t last) {
            (*static_cast<const Body*>(b))(first, last);
        });
    }

  private:
    struct Arena;
    void run(size_t count, size_t least, const void* body,
             void (*call)(const void* body, size_t first, size_t last)) const;

    std::unique_ptr<Arena> arena_;
};

/// The same on `threads`, or on this thread alone where there are none.
template <typename Body>
void for_ranges(const WorkThreads* threads, size_t count, size_t least, const Body& body) {
    if (threads) {
        threads->for_ranges(count, least, body);
    } else if (count > 0) {
        body(size_t{0}, count);
    }
}

}  // namespace bsoil
#pragma GCC visibility pop
