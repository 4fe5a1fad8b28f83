#include "polhode/write/stream.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace polhode {
namespace {

constexpr std::size_t rows_per_block = 4096;

/// A place in the ring of blocks under way: free, or holding block `number`, encoded.
struct Slot {
  EncodedBlock block;
  std::size_t number = 0;
  bool full = false;
};

}  // namespace

void stream_rows(const Ephemeris& ephemeris, TimeResolution resolution,
                 const std::function<void(std::size_t, const AttitudeBlock&, EncodedBlock&)>& encode,
                 const std::function<void(EncodedBlock&)>& consume) {
  const std::size_t rows = ephemeris.times().size();
  const std::size_t blocks = (rows + rows_per_block - 1) / rows_per_block;
  const auto make = [&](std::size_t number, AttitudeBlock& scratch, EncodedBlock& out) {
    const std::size_t first = number * rows_per_block;
    const std::size_t count = std::min(rows_per_block, rows - first);
    ephemeris.fill(first, count, resolution, scratch);
    out.bytes.clear();
    out.word_sum = 0;
    out.rows = count;
    encode(first, scratch, out);
  };
  if (blocks <= 4) {  // not worth a thread
    AttitudeBlock scratch;
    EncodedBlock out;
    for (std::size_t number = 0; number < blocks; ++number) {
      make(number, scratch, out);
      consume(out);
    }
    return;
  }

  const std::size_t threads = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, 16);
  std::vector<Slot> ring(2 * threads + 2);
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t next = 0;      // block that the next free worker takes
  std::size_t consumed = 0;  // blocks handed on
  bool stop = false;
  std::exception_ptr failure;

  const auto work = [&] {
    try {
      AttitudeBlock scratch;
      for (;;) {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return stop || next == blocks || next < consumed + ring.size(); });
        if (stop || next == blocks) return;
        const std::size_t number = next++;
        Slot& slot = ring[number % ring.size()];  // free: block number - ring.size() is consumed
        lock.unlock();
        make(number, scratch, slot.block);
        lock.lock();
        slot.number = number;
        slot.full = true;
        lock.unlock();
        changed.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
      stop = true;
      changed.notify_all();
    }
  };

  std::vector<std::jthread> workers;
  const auto finish = [&] {
    {
      const std::lock_guard lock(mutex);
      stop = true;
    }
    changed.notify_all();
    workers.clear();  // joins
  };
  try {
    for (std::size_t i = 0; i < threads; ++i) workers.emplace_back(work);
    for (std::size_t number = 0; number < blocks; ++number) {
      Slot& slot = ring[number % ring.size()];
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return failure || (slot.full && slot.number == number); });
        if (failure) break;
      }
      consume(slot.block);
      {
        const std::lock_guard lock(mutex);
        slot.full = false;
        consumed = number + 1;
      }
      changed.notify_all();
    }
  } catch (...) {
    finish();
    throw;
  }
  finish();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace polhode
