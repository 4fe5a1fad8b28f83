#pragma once

#include <array>
#include <cstdint>

namespace polhode {

/// Philox4x32-10 of Salmon, Moraes, Dror & Shaw (2011, SC11, "Parallel random numbers: as easy as 1, 2, 3"): four
/// random words from a counter and a key, with no state in between.
inline std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53U} * counter[0], b = std::uint64_t{0xCD9E8D57U} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32U) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32U) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9U;
    key[1] += 0xBB67AE85U;
  }
  return counter;
}

/// Evenly spread numbers in (0, 1), two for each counter: never 0, never 1, symmetric about 1/2.
inline std::array<double, 2> philox_uniforms(std::uint64_t seed, std::uint64_t item, std::uint32_t block,
                                             std::uint32_t attempt) {
  const auto words =
      philox4x32({static_cast<std::uint32_t>(item), static_cast<std::uint32_t>(item >> 32U), block, attempt},
                 {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)});
  const auto uniform = [](std::uint32_t high, std::uint32_t low) {
    const std::uint64_t bits = (std::uint64_t{high} << 32U | low) >> 12U;
    return (static_cast<double>(bits) + 0.5) * 0x1p-52;
  };
  return {uniform(words[0], words[1]), uniform(words[2], words[3])};
}

/// The number below which a standard normal one lies with probability p, 0 < p < 1, to 1e-15 of itself (Wichura 1988,
/// Applied Statistics 37, 477, algorithm AS 241, PPND16).
double normal_quantile(double p);

}  // namespace polhode
