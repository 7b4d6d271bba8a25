// A seeded stream of normal numbers. Why: the standard library's distributions, and its logarithms, differ between
// platforms; this one needs additions and multiplications only, so a seed means the same flight everywhere.
#pragma once
#include <cstdint>

namespace halfroll::sim {

struct Noise {
  std::uint64_t state = 0;

  /// SplitMix64.
  std::uint64_t bits() {
    std::uint64_t z = (state += 0x9E3779B97F4A7C15U);
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }

  /// Mean 0, variance 1: the sum of twelve uniform numbers of 16 bits; never beyond 6.
  double normal() {
    std::int64_t sum = 0;
    for (int word = 0; word < 3; ++word) {
      const std::uint64_t b = bits();
      sum += static_cast<std::int64_t>((b & 0xFFFFU) + ((b >> 16U) & 0xFFFFU) + ((b >> 32U) & 0xFFFFU) + (b >> 48U));
    }
    return static_cast<double>(2 * sum - 12 * 0xFFFF) / (2 * 65536.0);
  }
};

}  // namespace halfroll::sim
