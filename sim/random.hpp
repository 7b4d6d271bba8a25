// Random numbers by counter: number i of stream s under a seed is a function of (seed, s, i) and nothing else.
// Why: a sensor that is added, or read more often, must not change what the others say; and the standard library's
// distributions, and its logarithms, differ between platforms. These need arithmetic and a square root only.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace halfroll::sim {

/// Who draws. A number, once given away, keeps its meaning: it is part of what a seed stands for.
enum class Stream : std::uint32_t {
  kGyro = 1,
  kGyroBias = 2,
  kAccelerometer = 3,
  kAccelerometerBias = 4,
  kVibration = 5,
  kMocapPosition = 6,
  kMocapAttitude = 7,
  kMocapWander = 8,
  kMocapDelivery = 9,
  kMocapOutlier = 10,
  kTurbulence = 11,
  kTurbulenceCross = 12,
  kGpsPosition = 13,
  kGpsVelocity = 14,
  kGpsWander = 15,
  kBarometer = 16,
  kMagnetometer = 17,
  kReferenceLink = 18,
  kTelemetryLink = 19,
};

using Words = std::array<std::uint32_t, 4>;

/// Philox4x32-10 (Salmon, Moraes, Dror, Shaw: Parallel random numbers: as easy as 1, 2, 3; SC11).
inline Words philox(Words counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53U} * counter[0], b = std::uint64_t{0xCD9E8D57U} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32U) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32U) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9U;
    key[1] += 0xBB67AE85U;
  }
  return counter;
}

/// Natural logarithm of a positive, normal number, to 1e-12.
inline double logarithm(double x) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  int exponent = static_cast<int>(bits >> 52U) - 1023;
  bits = (bits & 0xFFFFFFFFFFFFFU) | 0x3FF0000000000000U;
  double m = 0.0;
  std::memcpy(&m, &bits, sizeof m);
  if (m > 1.4142135623730951) m *= 0.5, ++exponent;
  const double s = (m - 1.0) / (m + 1.0), z = s * s;
  const double series =
      1.0 + z * (1.0 / 3 + z * (1.0 / 5 + z * (1.0 / 7 + z * (1.0 / 9 + z * (1.0 / 11 + z * (1.0 / 13))))));
  return exponent * 0.6931471805599453 + 2.0 * s * series;
}

/// The normal deviate below which a share (word + 1/2) / 2^32 of all lie; to 1e-6, between -6.3 and 6.3.
/// Wichura's PPND7 (Algorithm AS 241, Applied Statistics 37, 1988).
inline double normal_quantile(std::uint32_t word) {
  const double p = (static_cast<double>(word) + 0.5) * 0x1p-32, q = p - 0.5;
  if (std::abs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q * (((59.109374720 * r + 159.29113202) * r + 50.434271938) * r + 3.3871327179) /
           (((67.187563600 * r + 78.757757664) * r + 17.895169469) * r + 1.0);
  }
  const double r = std::sqrt(-logarithm(q < 0.0 ? p : 1.0 - p)) - 1.6;
  const double x = (((0.17023821103 * r + 1.3067284816) * r + 2.7568153900) * r + 1.4234372777) /
                   ((0.12021132975 * r + 0.73700164250) * r + 1.0);
  return q < 0.0 ? -x : x;
}

/// All random numbers of one flight.
struct Random {
  std::uint64_t seed = 0;

  Words words(Stream stream, std::uint64_t index) const {
    return philox({static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32U),
                   static_cast<std::uint32_t>(stream), 0U},
                  {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)});
  }

  /// Independent numbers of mean 0 and variance 1: four, or as many of them as are wanted.
  template <std::size_t kWanted = 4>
  std::array<double, kWanted> normals(Stream stream, std::uint64_t index) const {
    static_assert(kWanted <= 4);
    const Words w = words(stream, index);
    std::array<double, kWanted> n;
    for (std::size_t i = 0; i < kWanted; ++i) n[i] = normal_quantile(w[i]);
    return n;
  }

  /// Four independent numbers between 0 and 1, neither included.
  std::array<double, 4> uniforms(Stream stream, std::uint64_t index) const {
    const Words w = words(stream, index);
    const auto share = [](std::uint32_t word) { return (static_cast<double>(word) + 0.5) * 0x1p-32; };
    return {share(w[0]), share(w[1]), share(w[2]), share(w[3])};
  }
};

}  // namespace halfroll::sim
