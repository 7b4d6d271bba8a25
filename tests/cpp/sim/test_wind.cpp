// Air: gusts and the statistics of Dryden turbulence, against the closed forms of MIL-F-8785C.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "sim/wind.hpp"

using namespace halfroll::sim;

namespace {

std::vector<Vec3d> blown(const WindSetup& setup, std::uint64_t seed, int milliseconds) {
  const WindModel model(setup);
  const Random random{seed};
  Wind wind = model.start(random);
  std::vector<Vec3d> air;
  for (int n = 1; n <= milliseconds; ++n) {
    air.push_back(wind.velocity_W);
    model.advance(wind, random, static_cast<std::uint64_t>(n) * 1000);
  }
  return air;
}

}  // namespace

TEST_CASE("turbulence has the Dryden intensities and correlations along, across and upwards") {
  WindSetup setup;
  setup.mean = {0.0, 4.0, 0.0};  // westward: along is y, across is x
  setup.intensity = {0.8, 0.6, 0.4};
  setup.length = {2.0, 1.6, 1.2};  // time constants 0.5, 0.4, 0.3 s: many of them in the record
  const int n = 4000000;
  const std::vector<Vec3d> air = blown(setup, 3, n);
  Vec3d mean = Vec3d::Zero();
  for (const Vec3d& v : air) mean += v / n;
  CHECK((mean - setup.mean).norm() < 0.05);
  const auto correlation = [&](int axis, int lag) {
    double sum = 0;
    for (int i = 0; i + lag < n; ++i) {
      sum += (air[std::size_t(i)][axis] - mean[axis]) * (air[std::size_t(i + lag)][axis] - mean[axis]);
    }
    return sum / (n - lag);
  };
  const struct {
    int axis;
    double sigma, tau;
    bool along;
  } rows[] = {{1, 0.8, 0.5, true}, {0, 0.6, 0.4, false}, {2, 0.4, 0.3, false}};
  for (const auto& row : rows) {
    for (const double s : {0.0, 0.5, 1.0, 2.0}) {  // in time constants
      const double expected = row.sigma * row.sigma * std::exp(-s) * (row.along ? 1.0 : 1.0 - 0.5 * s);
      const double found = correlation(row.axis, int(std::lround(1000 * s * row.tau)));
      CHECK(std::abs(found - expected) < 0.04 * row.sigma * row.sigma);
    }
  }
}

TEST_CASE("turbulence is stationary from the first moment") {
  WindSetup setup;
  setup.mean = {4.0, 0.0, 0.0};
  setup.intensity = {1.0, 1.0, 1.0};
  Vec3d squares = Vec3d::Zero();
  const int seeds = 4000;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    squares += (blown(setup, seed, 1)[0] - setup.mean).cwiseAbs2() / seeds;
  }
  for (const double variance : {squares.x(), squares.y(), squares.z()})
    CHECK(variance == doctest::Approx(1.0).epsilon(0.08));
}

TEST_CASE("a gust rises as (1 - cos) / 2, stays and falls") {
  WindSetup setup;
  setup.gusts[0] = {1.0, 0.5, 2.0, {0.0, 3.0, 0.0}};
  const std::vector<Vec3d> air = blown(setup, 0, 5000);
  const auto at = [&](double t) { return air[std::size_t(std::lround(1000 * t))].y(); };
  CHECK(at(0.99) == 0.0);
  CHECK(at(1.125) == doctest::Approx(3.0 * (0.5 - 0.5 * std::cos(std::acos(-1.0) / 4))).epsilon(1e-5));
  CHECK(at(1.25) == doctest::Approx(1.5).epsilon(1e-5));
  CHECK(at(2.5) == 3.0);
  CHECK(at(3.75) == doctest::Approx(1.5).epsilon(1e-5));
  CHECK(at(4.1) == 0.0);
}

TEST_CASE("still air stays still") { CHECK_FALSE(WindModel(WindSetup{}).blows()); }
