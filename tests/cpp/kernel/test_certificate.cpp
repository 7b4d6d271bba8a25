#include <doctest/doctest.h>

#include "flights.hpp"
#include "kernel/certificate.hpp"
#include "kernel/peaks.hpp"

namespace halfroll::planner {
namespace {

std::vector<Coefficients> coefficients(const Trajectory& path) {
  std::vector<Coefficients> pieces;
  for (int k = 0; k < path.pieces(); ++k) pieces.push_back(hermite_matrix() * path.ends(k));
  return pieces;
}

/// A zigzag, as fast as a rough solve makes it, and the largest thrust of its rotors.
struct Flown {
  Problem problem;
  double highest;
};

Flown zigzag() {
  Limits limits;
  limits.rotor_min = 0.15;
  limits.rotor_max = 3.0;
  const Constraints constraints(paper_vehicle(), limits, false);
  Flown flown{course({{0, 0, 1}, {2, 1, 2}, {4, -1, 1}, {6, 1, 1.5}}, 2.0), 0.0};
  SolverSettings settings;
  settings.gap_end = 0.03;
  flown.problem.start = minimise_time(flown.problem, constraints, settings, {}).trajectory;
  for (double high : rotor_range(flown.problem.start, constraints, 4000).high)
    flown.highest = std::max(flown.highest, high);
  return flown;
}

Certificate check(const Flown& flown, double rotor_max) {
  Limits limits;
  limits.rotor_min = -3.0;
  limits.rotor_max = rotor_max;
  return certify(coefficients(flown.problem.start), flown.problem.start.durations, flown.problem.limits,
                 Constraints(paper_vehicle(), limits, false));
}

}  // namespace

TEST_CASE("a flight is proven with a hundredth of a millinewton to spare, and refused for a millinewton too much") {
  const Flown flown = zigzag();
  CHECK(check(flown, flown.highest + 1e-5).proven);
  const Certificate refused = check(flown, flown.highest - 1e-3);
  CHECK_FALSE(refused.proven);
  CHECK(refused.excess == doctest::Approx(1e-3).epsilon(0.5));
}

TEST_CASE("rates of rotor thrusts are proven between samples as closely as thrusts are") {
  const Flown flown = zigzag();
  const auto check_drive = [&](const Drive& drive, double rate_max) {
    Limits limits;
    limits.rotor_min = -1e3;
    limits.rotor_max = 1e3;
    limits.rotor_rate_max = rate_max;
    limits.drive = drive;
    const Constraints constraints(paper_vehicle(), limits, false);
    return std::pair{
        least_margin(flown.problem.start, flown.problem, constraints, 4000),
        certify(coefficients(flown.problem.start), flown.problem.start.durations, flown.problem.limits, constraints)};
  };
  for (const Drive& drive : {Drive{0.018, 0.018, false, -50.0, 50.0}, Drive{0.12, 0.14, true, 1e-4, 90.0}}) {
    const auto [least, certificate] = check_drive(drive, 1e4);
    CHECK(certificate.proven == (least > 0.0));
  }
  const double relative = check_drive({}, 1000.0).first;  // (1000 - largest)/1000
  const double largest = 1000.0 * (1.0 - relative);
  CHECK(check_drive({}, largest + 1e-2).second.proven);
  const Certificate refused = check_drive({}, largest - 1.0).second;
  CHECK_FALSE(refused.proven);
  CHECK(refused.excess > 0.0);  // of the first part that is refused, not of the worst
  CHECK(refused.excess < 1.1);
}

TEST_CASE("the piece that exceeds a limit is named, alone") {
  Problem problem = course({{0, 0, 1}, {2, 0, 1}, {4, 1, 1}, {6, 0, 1}}, 2.5);
  problem.start.nodes[2](4, 1) = 0.0;
  const Constraints constraints(paper_vehicle(), every_limit(), false);
  REQUIRE(certify(coefficients(problem.start), problem.start.durations, problem.limits, constraints).proven);
  auto pieces = coefficients(problem.start);
  pieces[1](9, 2) += 8.0;
  const Certificate refused = certify(pieces, problem.start.durations, problem.limits, constraints);
  CHECK_FALSE(refused.proven);
  CHECK(refused.unproven == std::vector<int>{1});
  CHECK(refused.piece == 1);
}

TEST_CASE("a path through free fall cannot be proven") {
  Problem problem = course({{0, 0, 1}, {0.5, 0, 30}, {1, 0, 1}}, 1.2);
  const Constraints constraints(paper_vehicle(), every_limit(), false);
  CHECK_FALSE(certify(coefficients(problem.start), problem.start.durations, problem.limits, constraints).proven);
}

}  // namespace halfroll::planner
