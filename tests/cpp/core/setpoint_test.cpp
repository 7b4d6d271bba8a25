// Extrapolation of the setpoint. Why: a message is 1 to 20 ms old when it is used, and a flip does not wait.
#include "core/setpoint.hpp"

#include <doctest/doctest.h>

#include "core/quaternion.hpp"
#include "oracle.hpp"

namespace halfroll {
namespace {

Setpoint spinning() {
  Setpoint s;
  s.t_us = 1000000;
  s.q_WD = oracle::to_core(oracle::Random(1).attitude());
  s.w_WD_D = {3.F, -15.F, 2.F};
  s.thrust = 5.F;
  return s;
}

}  // namespace

TEST_CASE("a setpoint turns with its own rate from its stamp, and back for a stamp in the future") {
  const Setpoint s = spinning();
  for (const int age_ms : {-20, 0, 1, 12, 100}) {
    const Reference r = extrapolate(s, Estimate{}, s.t_us + static_cast<std::uint64_t>(age_ms * 1000), Params{});
    const auto wanted = oracle::from_core(s.q_WD) * oracle::turn(s.w_WD_D.cast<double>() * (age_ms * 1e-3));
    CHECK(oracle::angle_between(oracle::from_core(r.q_WD), wanted) < 1e-5);
    CHECK(r.w_WD_D == s.w_WD_D);
  }
}

TEST_CASE("extrapolation ends 0.1 s after the stamp") {
  const Setpoint s = spinning();
  CHECK(extrapolate(s, Estimate{}, s.t_us + 100000, Params{}).q_WD ==
        extrapolate(s, Estimate{}, s.t_us + 5000000, Params{}).q_WD);
}

TEST_CASE("an angular acceleration speeds the reference up") {
  Setpoint s = spinning();
  s.w_WD_D = {0.F, 2.F, 0.F};
  s.dw_WD_D = {0.F, 100.F, 0.F};
  const Reference r = extrapolate(s, Estimate{}, s.t_us + 20000, Params{});
  CHECK(r.w_WD_D.y() == doctest::Approx(4.F));
  CHECK(oracle::angle_between(r.q_WD, s.q_WD) == doctest::Approx(2.0 * 0.02 + 0.5 * 100.0 * 4e-4).epsilon(1e-4));
}

TEST_CASE("with REF_EXTRAP off the attitude is held and the rate stays") {
  Params params;
  params.reference_extrapolation = 0.F;
  const Setpoint s = spinning();
  const Reference r = extrapolate(s, Estimate{}, s.t_us + 9000, params);
  CHECK(oracle::angle_between(r.q_WD, s.q_WD) < 1e-6);
  CHECK(r.w_WD_D == s.w_WD_D);
}

TEST_CASE("thrust is projected on the actual body axis and reverses with it") {
  Setpoint s;
  s.thrust = 5.F;
  Estimate estimate;
  for (const double tilt : {0.0, 60.0, 90.0, 120.0, 180.0}) {
    estimate.q_WB = oracle::to_core(oracle::turn({0.0, tilt * oracle::kDegree, 0.0}));
    CHECK(extrapolate(s, estimate, 0, Params{}).thrust ==
          doctest::Approx(5.0 * std::cos(tilt * oracle::kDegree)).epsilon(1e-5));
  }
}

TEST_CASE("without attitude only rates are controlled and thrust is taken as it is") {
  Setpoint s = spinning();
  s.attitude_used = false;
  s.rate_used = {true, true, false};
  Estimate estimate;
  estimate.q_WB = oracle::to_core(oracle::Random(2).attitude());
  estimate.w_WB_B = {0.F, 0.F, 7.F};
  const Reference r = extrapolate(s, estimate, s.t_us + 5000, Params{});
  CHECK(r.q_WD == estimate.q_WB);
  CHECK(r.thrust == s.thrust);
  CHECK(r.w_WD_D == Vec3(3.F, -15.F, 0.F));  // an axis that nobody commands stops
}

}  // namespace halfroll
