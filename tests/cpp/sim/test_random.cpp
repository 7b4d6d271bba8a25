// Random numbers by counter: published vectors, and the distribution they are meant to have.
#include <doctest/doctest.h>

#include <cmath>

#include "sim/lag.hpp"
#include "sim/random.hpp"

using namespace halfroll::sim;

TEST_CASE("Philox agrees with the known answers published with Random123") {
  CHECK(philox({0, 0, 0, 0}, {0, 0}) == Words{0x6627e8d5U, 0xe169c58dU, 0xbc57ac4cU, 0x9b00dbd8U});
  CHECK(philox({~0U, ~0U, ~0U, ~0U}, {~0U, ~0U}) == Words{0x408f276dU, 0x41c83b0eU, 0xa20bc7c6U, 0x6d5451fdU});
  CHECK(philox({0x243f6a88U, 0x85a308d3U, 0x13198a2eU, 0x03707344U}, {0xa4093822U, 0x299f31d0U}) ==
        Words{0xd16cfe09U, 0x94fdccebU, 0x5001e420U, 0x24126ea1U});
}

TEST_CASE("the normal quantile inverts the normal distribution, far into its tails") {
  double worst = 0;
  for (std::uint64_t word = 0; word <= 0xFFFFFFFFU; word += word < 5000000U ? 9973U : 999983U) {
    const double p = (static_cast<double>(word) + 0.5) / 4294967296.0;
    const double x = normal_quantile(static_cast<std::uint32_t>(word));
    const double share = 0.5 * std::erfc(-x / std::sqrt(2.0));
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::acos(-1.0));
    worst = std::max(worst, std::abs(share - p) / density);  // as an error of x
  }
  MESSAGE("largest error of the quantile ", worst);
  CHECK(worst < 2e-6);
  CHECK(normal_quantile(0) == doctest::Approx(-6.34).epsilon(0.001));
  CHECK(normal_quantile(0xFFFFFFFFU) == -normal_quantile(0));
}

TEST_CASE("normal numbers have mean 0, variance 1, no skew, and the tails of a normal distribution") {
  const Random random{1};
  double sum = 0, squares = 0, cubes = 0, fourths = 0;
  const int n = 400000;
  for (std::uint64_t i = 0; i < n / 4; ++i) {
    for (const double x : random.normals(Stream::kGyro, i)) {
      sum += x, squares += x * x, cubes += x * x * x, fourths += x * x * x * x;
    }
  }
  CHECK(std::abs(sum / n) < 0.006);  // 4 standard errors
  CHECK(squares / n == doctest::Approx(1).epsilon(0.01));
  CHECK(std::abs(cubes / n) < 0.03);
  CHECK(fourths / n == doctest::Approx(3).epsilon(0.03));
}

TEST_CASE("streams and seeds are uncorrelated") {
  const Random one{1}, two{2};
  double across_streams = 0, across_seeds = 0, across_time = 0;
  const int n = 100000;
  for (std::uint64_t i = 0; i < n; ++i) {
    const double x = one.normals(Stream::kGyro, i)[0];
    across_streams += x * one.normals(Stream::kAccelerometer, i)[0];
    across_seeds += x * two.normals(Stream::kGyro, i)[0];
    across_time += x * one.normals(Stream::kGyro, i + 1)[0];
  }
  for (const double product : {across_streams, across_seeds, across_time}) CHECK(std::abs(product / n) < 0.013);
}

TEST_CASE("the share that a lag covers is 1 - exp(-x)") {
  for (double x = 1e-9; x < 40; x *= 1.7) CHECK(covered(x) == doctest::Approx(-std::expm1(-x)).epsilon(1e-14));
  CHECK(covered(0.0) == 0.0);
  CHECK(covered(1e-3, 0.0) == 1.0);
}
