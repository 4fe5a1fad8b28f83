#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace polhode {

/// Calls work(begin, end) for contiguous chunks that together cover 0 to count, each on a thread of its own (the last
/// on the caller's), and returns when all are done. Chunks begin at multiples of `grain`, so that work done in blocks
/// of a divisor of `grain` gives the same bits for every thread_count. 0 threads means one per core. Where `work`
/// throws, the other chunks are done all the same, and then the exception of the first chunk that threw is thrown here.
template <class Work>
void parallel_chunks(std::size_t count, std::size_t grain, unsigned thread_count, const Work& work) {
  if (thread_count == 0) thread_count = std::max(1U, std::thread::hardware_concurrency());
  const std::size_t grains = (count + grain - 1) / grain;
  const std::size_t chunk = std::max<std::size_t>(1, (grains + thread_count - 1) / thread_count) * grain;
  std::vector<std::exception_ptr> problems(count / chunk + 1);  // of each chunk
  const auto guarded = [&work, &problems](std::size_t i, std::size_t begin, std::size_t end) {
    try {
      work(begin, end);
    } catch (...) {
      problems[i] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;  // joins when it goes
    std::size_t begin = 0;
    for (; begin + chunk < count; begin += chunk) {
      threads.emplace_back([&guarded, begin, chunk] { guarded(begin / chunk, begin, begin + chunk); });
    }
    guarded(begin / chunk, begin, count);
  }
  for (const std::exception_ptr& problem : problems) {
    if (problem) std::rethrow_exception(problem);
  }
}

}  // namespace polhode
