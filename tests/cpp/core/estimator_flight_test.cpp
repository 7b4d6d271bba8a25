// The estimator in flights that it controls itself. Why: its covariance is worth what the truth says of it.
#include <doctest/doctest.h>

#include <array>

#include "estimated_flight.hpp"

namespace halfroll {
namespace {

using oracle::Flight;
using oracle::Vec3d;
using oracle::Vector15d;

}  // namespace

TEST_CASE("over 100 flights with four flips each, 20 ms late: 1 cm, 0.05 m/s, 1 deg, and as sure of it as it may be") {
  constexpr int kFlights = 100, kMilliseconds = 8000, kFrom = 500;
  double attitude2 = 0.0, velocity2 = 0.0, position2 = 0.0, worst_position = 0.0, worst_attitude = 0.0;
  std::array<double, kMilliseconds / 10> nees{};
  double nees_15 = 0.0;
  int samples = 0;
  std::uint32_t rejected = 0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    Flight flight(seed, 4);
    flight.observe(kMilliseconds, [&](const Vector15d& e) {
      const int k = flight.k - 1;
      if (k < kFrom) return;
      attitude2 += e.segment<3>(0).squaredNorm();
      velocity2 += e.segment<3>(3).squaredNorm();
      position2 += e.segment<3>(6).squaredNorm();
      worst_position = std::max(worst_position, e.segment<3>(6).norm());
      worst_attitude = std::max(worst_attitude, e.segment<3>(0).norm());
      ++samples;
      if (k % 10 == 1) nees[static_cast<std::size_t>(k) / 10] += flight.nees(e) / kFlights;
    });
    rejected += flight.estimator.health().rejected;
  }
  int inside = 0, instants = 0;
  for (std::size_t i = kFrom / 10; i < nees.size(); ++i) {
    nees_15 += nees[i];
    ++instants;
    inside += nees[i] > 13.947 && nees[i] < 16.092 ? 1 : 0;  // chi² of 1500, 2.5 % and 97.5 %, over 100
  }
  nees_15 /= instants;
  const double attitude_deg = std::sqrt(attitude2 / samples) / oracle::kDegree;
  const double velocity = std::sqrt(velocity2 / samples), position = std::sqrt(position2 / samples);
  MESSAGE("rms " << attitude_deg << " deg, " << velocity << " m/s, " << position * 1e3 << " mm; worst "
                 << worst_attitude / oracle::kDegree << " deg, " << worst_position * 1e3 << " mm");
  MESSAGE("mean NEES " << nees_15 << " of 15, inside the 95 % band at " << 100.0 * inside / instants
                       << " % of instants");
  CHECK(nees_15 > 13.947);
  CHECK(nees_15 < 16.092);
  CHECK(inside > 0.9 * instants);
  CHECK(rejected <= 10);  // 5 sigma: about 2 of 80000 poses
  CHECK(attitude_deg < 1.0);
  CHECK(velocity < 0.05);
  CHECK(position < 0.01);
}

TEST_CASE("half a second without poses in hover costs less than 0.3 m") {
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Flight flight(seed, 0);
    flight.fly(3000);
    flight.sensors.poses = false;
    flight.fly(500);
    flight.sensors.poses = true;
    worst = std::max(worst, (flight.body.p - Vec3d(0.0, 0.0, 2.0)).norm());
    flight.fly(2000);
    CHECK(flight.estimate.position_valid);
    CHECK((flight.body.p - Vec3d(0.0, 0.0, 2.0)).norm() < 0.1);
  }
  MESSAGE("worst drift " << worst * 1e3 << " mm");
  CHECK(worst < 0.3);
}

TEST_CASE("of one pose in twenty that is wrong none is believed that matters") {
  double worst = 0.0, worst_without = 0.0;
  std::uint32_t rejected = 0;
  int lies = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const bool lying : {true, false}) {
      Flight flight(seed, 4);
      flight.sensors.outliers = lying ? 0.05 : 0.0;
      flight.fly(500);
      flight.observe(7500, [&](const Vector15d& e) {
        double& of = lying ? worst : worst_without;
        of = std::max(of, e.segment<3>(6).norm());
        if (lying && flight.sensors.lied() && (flight.k - 1) % 10 == 0) ++lies;
      });
      if (lying) rejected += flight.estimator.health().rejected;
      CHECK(flight.estimate.resets == 0);
    }
  }
  MESSAGE(lies << " lies, " << rejected << " rejected; worst position error " << worst * 1e3 << " mm, without lies "
               << worst_without * 1e3 << " mm");
  CHECK(lies > 300);
  CHECK(worst < worst_without + 5e-3);
}

TEST_CASE("a tracker that froze is found out: the position is invalid half a second later, and valid when it wakes") {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Flight flight(seed, 0);
    flight.fly(3000);
    flight.frozen = true;
    flight.fly(400);
    CHECK(flight.estimate.position_valid);
    flight.fly(200);
    CHECK(!flight.estimate.position_valid);
    CHECK(flight.estimate.attitude_valid);
    CHECK(flight.estimator.health().frozen > 50);
    flight.frozen = false;
    flight.fly(300);
    CHECK(flight.estimate.position_valid);
    CHECK((flight.body.p - flight.estimate.p_WB.cast<double>()).norm() < 0.01);
  }
}

TEST_CASE("a tracker whose origin jumps is believed after 0.4 s of agreeing with itself, and the jump is counted") {
  Flight flight(1, 0);
  flight.fly(3000);
  const Vec3 before = flight.estimate.p_WB;
  flight.shift = Vec3(0.5F, -0.3F, 0.F);
  flight.fly(350);
  CHECK(flight.estimate.resets == 0);
  CHECK((flight.estimate.p_WB - before).norm() < 0.05F);
  flight.fly(150);
  CHECK(flight.estimate.resets == 1);
  CHECK(flight.estimate.position_valid);
}

TEST_CASE("the covariance stays symmetric and positive for ten minutes, through dropouts, lies and flips") {
  Flight flight(7, 300);
  flight.sensors.outliers = 0.05;
  double least = 1.0;
  for (int second = 0; second < 600; ++second) {
    flight.sensors.poses = second % 20 != 19;
    flight.fly(1000);
    const auto p = flight.estimator.covariance().matrix().cast<double>().eval();
    REQUIRE(p.allFinite());
    REQUIRE(p == p.transpose());
    const auto scale = p.diagonal().cwiseSqrt().cwiseInverse().eval();
    const auto correlation = (scale.asDiagonal() * p * scale.asDiagonal()).eval();
    const Eigen::SelfAdjointEigenSolver<std::decay_t<decltype(correlation)>> solver(correlation,
                                                                                    Eigen::EigenvaluesOnly);
    least = std::min(least, solver.eigenvalues().minCoeff());
  }
  MESSAGE("least eigenvalue of the correlations " << least);
  CHECK(least > 1e-5);
}

}  // namespace halfroll
