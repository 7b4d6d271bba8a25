// The estimator without motion capture: satellites, barometer, magnetometer. Why: a mission drawn on a map is flown
// where nobody has cameras.
#include <doctest/doctest.h>

#include "estimated_flight.hpp"

namespace halfroll {
namespace {

using oracle::Flight;
using oracle::kDegree;
using oracle::Quatd;
using oracle::SensorSuite;
using oracle::Vec3d;
using oracle::Vector15d;

/// Stands still at q for some seconds.
Estimate stood(const Quatd& q, int milliseconds, unsigned seed, const Params& params = {}) {
  SensorSuite sensors(seed);
  sensors.poses = false;
  sensors.outdoors = true;
  sensors.gyro_bias = 0.01;
  sensors.accelerometer_bias = 0.1;
  Estimator estimator;
  Estimate estimate;
  for (int k = 0; k < milliseconds; ++k) {
    oracle::Seen truth;
    truth.p = {30.0, -20.0, 1.0};
    truth.q = q;
    truth.specific_force_B = q.conjugate() * Vec3d(0.0, 0.0, oracle::kGravity);
    estimate = estimator.step(static_cast<std::uint64_t>(k) * 1000, sensors.read(k, truth), false, params);
  }
  return estimate;
}

}  // namespace

TEST_CASE("a still vehicle finds its attitude and place from gravity, field and satellites, lying in any attitude") {
  oracle::Random random(5);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Quatd q = seed == 1   ? Quatd::Identity()
                    : seed == 2 ? oracle::turn({oracle::kDegree * 180.0, 0.0, 0.0})
                    : seed == 3 ? oracle::turn({0.0, oracle::kDegree * 90.0, 0.0})
                                : random.attitude();
    const Estimate e = stood(q, 5000, seed);
    CAPTURE(seed);
    CHECK(e.attitude_valid);
    CHECK(e.position_valid);
    CHECK(e.aiding == Aiding::kSatellites);
    CHECK(oracle::angle_between(e.q_WB, oracle::to_core(q)) < 5.0 * kDegree);
    CHECK((e.p_WB.cast<double>() - Vec3d(30.0, -20.0, 1.0)).norm() < 1.0);
    CHECK(e.v_WB.norm() < 0.3F);
  }
}

TEST_CASE("where magnetic north is east of true north the parameter says so, and a compass shows less") {
  Params east;
  east.est_declination = 0.3F;
  const Estimate e = stood(Quatd::Identity(), 5000, 1, east);
  CHECK(heading_after_levelling(e.q_WB) == doctest::Approx(-0.3).epsilon(0.15));
}

TEST_CASE("without satellites there is no position, however still it stands") {
  Params blind;
  blind.est_sensors = 24.F;
  CHECK(!stood(Quatd::Identity(), 3000, 1, blind).position_valid);
}

TEST_CASE("hover by satellites: within a metre, and upright to a few degrees") {
  double worst_attitude = 0.0, position2 = 0.0;
  int samples = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Flight flight(seed, 0);
    flight.sensors.poses = false;
    flight.sensors.outdoors = true;
    flight.sensors.gyro_bias = 0.01;
    flight.sensors.accelerometer_bias = 0.05;
    flight.fly(5000);
    flight.observe(30000, [&](const Vector15d& e) {
      worst_attitude = std::max(worst_attitude, e.segment<3>(0).norm());
      position2 += e.segment<3>(6).squaredNorm();
      ++samples;
    });
    CHECK(flight.estimate.position_valid);
    CHECK((flight.body.p - Vec3d(0.0, 0.0, 2.0)).norm() < 2.0);
  }
  MESSAGE("worst " << worst_attitude / kDegree << " deg, rms " << std::sqrt(position2 / samples) << " m");
  CHECK(worst_attitude < 6.0 * kDegree);
  CHECK(std::sqrt(position2 / samples) < 0.6);
}

TEST_CASE("when the cameras go, satellites take over without a jump; when they come back, they do again") {
  Flight flight(3, 0);
  flight.sensors.outdoors = true;
  flight.fly(3000);
  CHECK(flight.estimate.aiding == Aiding::kPose);
  flight.sensors.poses = false;
  for (int i = 0; i < 8000; ++i) {
    const Vec3 before = flight.estimate.p_WB;
    flight.step();
    REQUIRE((flight.estimate.p_WB - before).norm() < 0.3F);
  }
  CHECK(flight.estimate.aiding == Aiding::kSatellites);
  CHECK(flight.estimate.position_valid);
  flight.sensors.poses = true;
  flight.fly(2000);
  CHECK(flight.estimate.aiding == Aiding::kPose);
  CHECK((flight.body.p - flight.estimate.p_WB.cast<double>()).norm() < 0.01);
}

}  // namespace halfroll
