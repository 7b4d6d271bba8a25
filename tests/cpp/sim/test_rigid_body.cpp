// Physics of a free body, against closed forms and conservation laws.
#include <doctest/doctest.h>

#include <cmath>

#include "sim/rigid_body.hpp"
#include "sim/rotors.hpp"

using namespace halfroll::sim;

namespace {

Inertia asymmetric() { return {0.571, Vec3d(0.002, 0.004, 0.007)}; }  // three different axes tumble

/// The same body with axes that are not its principal ones.
Inertia skewed() {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
  return {0.571, Eigen::Matrix3d(turn * asymmetric().moments() * turn.transpose())};
}

RigidBody tumbling() {
  RigidBody body;
  body.w_WB_B = {3.0, 17.0, -5.0};  // [rad/s], about as fast as a flip
  return body;
}

Load nothing(const RigidBody&, Moment) { return {}; }

double energy(const Inertia& inertia, const RigidBody& b) { return 0.5 * b.w_WB_B.dot(inertia.moments() * b.w_WB_B); }
Vec3d momentum(const Inertia& inertia, const RigidBody& b) { return rotation(b.q_WB) * (inertia.moments() * b.w_WB_B); }

RigidBody after(const Inertia& inertia, RigidBody body, double seconds, double h) {
  for (long n = std::lround(seconds / h); n > 0; --n) rk4(inertia, body, nothing, h);
  return body;
}

}  // namespace

TEST_CASE("a tumbling body keeps its energy and angular momentum to 1e-9 over a minute") {
  for (const Inertia& inertia : {asymmetric(), skewed()}) {
    const RigidBody begin = tumbling(), end = after(inertia, begin, 60.0, kSubstep);
    const double energy_change = std::abs(energy(inertia, end) / energy(inertia, begin) - 1.0);
    const double momentum_change =
        (momentum(inertia, end) - momentum(inertia, begin)).norm() / momentum(inertia, begin).norm();
    MESSAGE("relative change after 60 s: energy ", energy_change, ", angular momentum ", momentum_change);
    CHECK(energy_change < 1e-9);
    CHECK(momentum_change < 1e-9);
    CHECK(std::abs(end.q_WB.norm() - 1.0) < 1e-15);
  }
}

TEST_CASE("halving the step divides the error by sixteen: the integrator is of fourth order") {
  const Inertia inertia = asymmetric();
  const RigidBody exact = after(inertia, tumbling(), 1.0, 1e-4);
  const auto error = [&](double h) { return (after(inertia, tumbling(), 1.0, h).q_WB - exact.q_WB).norm(); };
  const double order = std::log2(error(8e-3) / error(4e-3));
  CHECK(order > 3.8);
  CHECK(order < 4.3);
}

TEST_CASE("axes that are not principal turn the same body the same way") {
  const Eigen::AngleAxisd turn(0.7, Vec3d(1, 2, 3).normalized());
  RigidBody turned = tumbling();
  turned.w_WB_B = turn * turned.w_WB_B;
  const RigidBody plain = after(asymmetric(), tumbling(), 1.0, kSubstep), same = after(skewed(), turned, 1.0, kSubstep);
  CHECK((turn * plain.w_WB_B - same.w_WB_B).norm() < 1e-9);
}

TEST_CASE("a body turning about a principal axis turns by rate times time") {
  RigidBody body;
  body.w_WB_B = {0.0, 0.0, 2.0};
  body = after(asymmetric(), body, 0.5, kSubstep);
  CHECK(body.q_WB[0] == doctest::Approx(std::cos(0.5)).epsilon(1e-12));
  CHECK(body.q_WB[3] == doctest::Approx(std::sin(0.5)).epsilon(1e-12));
}

TEST_CASE("a quarter turn to the left about up takes forward to west") {
  const double half = std::sqrt(0.5);
  const Vec3d forward_W = rotation({half, 0.0, 0.0, half}) * Vec3d::UnitX();
  CHECK((forward_W - Vec3d::UnitY()).norm() < 1e-15);
}
