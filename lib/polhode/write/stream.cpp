#include "polhode/write/stream.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace polhode {
namespace {

constexpr std::size_t rows_per_block = 4096;  // a block and its text stay in a core's cache

}  // namespace

void stream_rows(const Ephemeris& ephemeris, TimeResolution resolution, const std::function<Encoder()>& new_encoder,
                 const std::function<void(EncodedBlock&)>& consume) {
  const std::size_t rows = ephemeris.times().size();
  const std::size_t blocks = (rows + rows_per_block - 1) / rows_per_block;
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t next = 0;  // block that the next free thread makes
  std::size_t turn = 0;  // block that is to be consumed next, by the thread that has made it
  bool stop = false;
  std::exception_ptr failure;

  const auto work = [&] {
    AttitudeBlock scratch;
    EncodedBlock block;
    const Encoder encode = new_encoder();
    for (;;) {
      std::unique_lock lock(mutex);
      if (stop || next == blocks) return;
      const std::size_t number = next++;
      lock.unlock();
      std::exception_ptr fault;
      try {
        const std::size_t first = number * rows_per_block;
        ephemeris.fill(first, std::min(rows_per_block, rows - first), resolution, scratch);
        encode(scratch, block);
        block.rows = scratch.rows;
      } catch (...) {
        fault = std::current_exception();
      }
      lock.lock();
      changed.wait(lock, [&] { return stop || turn == number; });
      if (stop) return;
      lock.unlock();
      if (!fault) {
        try {
          consume(block);
        } catch (...) {
          fault = std::current_exception();
        }
      }
      lock.lock();
      ++turn;
      if (fault) {
        failure = fault;
        stop = true;
      }
      lock.unlock();
      changed.notify_all();
    }
  };

  {
    std::vector<std::jthread> others;
    const std::size_t threads = std::min<std::size_t>({blocks, std::thread::hardware_concurrency(), 16});
    try {
      for (std::size_t i = 1; i < threads; ++i) others.emplace_back(work);
    } catch (const std::system_error&) {  // fewer threads do it too
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace polhode
