#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "polhode/ephemeris/ephemeris.hpp"

namespace polhode {

/// Called after each block with the count of rows written so far, by one thread at a time. It may throw to stop: the
/// output file is then removed.
using Progress = std::function<void(std::size_t rows_written)>;

/// A block of rows as the bytes of a format, and the sum of its big-endian 32-bit words for formats that want one.
struct EncodedBlock {
  std::string bytes;
  std::uint64_t word_sum = 0;
  std::size_t rows = 0;
};

/// Makes the bytes of a block of rows. It finds in `out` what an earlier block left there.
using Encoder = std::function<void(const AttitudeBlock& rows, EncodedBlock& out)>;

/// Computes and encodes the rows of an ephemeris block by block on all cores, each thread with an encoder of its own,
/// and hands the blocks to `consume` in order, one at a time, on whichever thread made them. Memory does not depend on
/// the count of rows. An exception on any thread stops all and is rethrown: that of the first block which has one.
void stream_rows(const Ephemeris& ephemeris, TimeResolution resolution, const std::function<Encoder()>& new_encoder,
                 const std::function<void(EncodedBlock&)>& consume);

}  // namespace polhode
