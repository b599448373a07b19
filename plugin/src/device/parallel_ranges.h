/// Work on several threads.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace bsoil::device {

/// Orders what this thread did before what any thread does after its next hand_over with the same
/// counter. oneTBB orders its tasks by itself, but inside its library, where a thread sanitizer
/// does not see it. A function of its own: the sanitizer's suppressions name it.
[[gnu::noinline]] inline void hand_over(std::atomic<uint32_t>& counter) {
    counter.fetch_add(1, std::memory_order_acq_rel);
}

/// Calls body(first, last) for ranges that make up 0..count, in any order and at the same time, and
/// waits for all of them. least: a range that is no longer is not divided.
template <typename Body>
void parallel_ranges(size_t count, const Body& body, size_t least = 1) {
    // Threads reach all of it by one pointer, which oneTBB copies.
    struct Job {
        const Body& body;
        std::atomic<uint32_t> hand_overs = 0;
    } job{body};
    hand_over(job.hand_overs);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, least),
                      [at = &job](const tbb::blocked_range<size_t>& range) {
                          hand_over(at->hand_overs);
                          at->body(range.begin(), range.end());
                          hand_over(at->hand_overs);
                      });
    hand_over(job.hand_overs);
}

}  // namespace bsoil::device
