#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace polhode {

/// Calls work(begin, end) for contiguous chunks that together cover 0 to count, and returns when all are done. Each
/// thread, of which the caller's is one, takes the next chunk when it is done with its last, so that a slow core or a
/// costly chunk holds up no other. Chunks begin at multiples of `grain`, so that work done in blocks of a divisor of
/// `grain` gives the same bits for every thread_count. 0 threads means one per core; one thread takes all as one chunk.
/// Where `work` throws, the other chunks are done all the same, and then the exception of the first chunk that threw is
/// thrown here.
template <class Work>
void parallel_chunks(std::size_t count, std::size_t grain, unsigned thread_count, const Work& work) {
  if (count == 0) return;
  constexpr std::size_t chunks_of_a_thread = 32;  // who ends first waits for a thirty-second of a share at most
  if (thread_count == 0) thread_count = std::max(1U, std::thread::hardware_concurrency());
  const std::size_t grains = (count + grain - 1) / grain, threads = std::min<std::size_t>(thread_count, grains);
  const std::size_t shares = threads <= 1 ? 1 : threads * chunks_of_a_thread;
  const std::size_t chunk = std::max<std::size_t>(1, grains / shares) * grain;
  std::vector<std::exception_ptr> problems((count + chunk - 1) / chunk);  // of each chunk
  std::atomic<std::size_t> next = 0;
  const auto take = [&work, &problems, &next, count, chunk] {
    for (std::size_t i = next++; i < problems.size(); i = next++) {
      try {
        work(i * chunk, std::min(count, (i + 1) * chunk));
      } catch (...) {
        problems[i] = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;  // joins when it goes
    for (std::size_t i = 1; i < threads; ++i) others.emplace_back(take);
    take();
  }
  for (const std::exception_ptr& problem : problems) {
    if (problem) std::rethrow_exception(problem);
  }
}

}  // namespace polhode
