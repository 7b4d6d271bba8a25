// The proof of flights that turn over, against dense samples of the same flight. Why: where the force is zero, samples
// have no value, and this is what says that nothing hides there.
#include <doctest/doctest.h>

#include <cmath>

#include "kernel/planar_certificate.hpp"

namespace halfroll::planner {
namespace {

const Vehicle kVehicle{0.571, {0.00365, 0.00365, 0.0068}, 0.175, 0.01, 9.81};

/// Through free fall at t = 0 with this jerk along x, snap along z: force (j t, s t²/2) reverses there.
std::vector<PlanarPiece> reversal(double jerk, double snap, double duration) {
  std::vector<PlanarPiece> pieces;
  for (const double begin : {-duration, 0.0}) {  // tau = (t - begin)/duration
    PlanarPiece piece{Coefficients::Zero(), duration, begin < 0.0 ? 1.0 : -1.0, begin == 0.0, begin < 0.0};
    const auto power = [&](int axis, double scale, int order) {  // scale t^order
      double binomial = 1.0;
      for (int i = 0; i <= order; ++i) {
        piece.path(i, axis) += scale * binomial * std::pow(duration, i) * std::pow(begin, order - i);
        binomial *= static_cast<double>(order - i) / (i + 1);
      }
    };
    power(0, jerk / 6.0, 3);
    power(2, -kVehicle.gravity / 2.0, 2);
    power(2, snap / 24.0, 4);
    pieces.push_back(piece);
  }
  return pieces;
}

/// Of rotors 2 and 4: the force is j t along x, s t²/2 up, so the thrust axis turns as atan(k t), k = s/(2 j).
double largest_thrust(double jerk, double snap, double duration) {
  double largest = 0.0;
  for (double t = -duration; t <= duration; t += duration / 20000.0) {
    const double k = snap / (2.0 * jerk), along = std::hypot(jerk * t, snap * t * t / 2.0);
    const double quickening =
        2.0 * k * k * k * t / std::pow(1.0 + k * k * t * t, 2);  // of atan(k t), the tilt from level
    const double pair = 0.5 * kVehicle.inertia[1] / kVehicle.arm * std::abs(quickening);
    largest = std::max(largest, 0.25 * kVehicle.mass * along + pair);
  }
  return largest;
}

Limits rotors(double most) {
  Limits limits;
  limits.rotor_min = -most;
  limits.rotor_max = most;
  return limits;
}

}  // namespace

TEST_CASE("through zero force the proof holds just above the largest rotor thrust, and fails just below") {
  for (const auto& [jerk, snap] : {std::pair{60.0, 400.0}, {20.0, 900.0}, {-45.0, 1500.0}}) {
    const double most = largest_thrust(jerk, snap, 0.2);
    CAPTURE(most);
    const Certificate above = certify_planar(reversal(jerk, snap, 0.2), kVehicle, rotors(1.001 * most));
    CHECK(above.proven);
    CHECK(above.intervals < 400);
    const Certificate below = certify_planar(reversal(jerk, snap, 0.2), kVehicle, rotors(0.999 * most));
    CHECK_FALSE(below.proven);
    CHECK(below.bound < 4);
  }
}

TEST_CASE("where no reversal is said, zero force is not proven: its direction would have to jump") {
  std::vector<PlanarPiece> pieces = reversal(60.0, 400.0, 0.2);
  for (PlanarPiece& piece : pieces) piece.begins_at_reversal = piece.ends_at_reversal = false;
  CHECK_FALSE(certify_planar(pieces, kVehicle, rotors(100.0)).proven);
}

TEST_CASE("body rate, speed, height, and how quickly thrust changes are proven too") {
  const std::vector<PlanarPiece> pieces = reversal(60.0, 900.0, 0.2);
  const double turning = 900.0 / 120.0;  // at zero force
  Limits limits = rotors(100.0);
  limits.body_rate_max = 1.001 * turning;
  CHECK(certify_planar(pieces, kVehicle, limits).proven);
  limits.body_rate_max = 0.999 * turning;
  CHECK(certify_planar(pieces, kVehicle, limits).bound == 12);
  limits = rotors(100.0);
  limits.rotor_rate_max = 0.25 * kVehicle.mass * 60.0;  // of the thrust alone, at zero force
  CHECK(certify_planar(pieces, kVehicle, limits).bound / 4 == 1);
  limits = rotors(100.0);
  limits.floor = -0.001;
  CHECK(certify_planar(pieces, kVehicle, limits).bound == 14);
}

}  // namespace halfroll::planner
