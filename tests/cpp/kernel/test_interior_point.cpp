#include <doctest/doctest.h>

#include "flights.hpp"
#include "kernel/interior_point.hpp"
#include "kernel/peaks.hpp"

namespace halfroll::planner {
namespace {

Limits rotors_alone() {
  Limits limits;
  limits.rotor_min = 0.15;
  limits.rotor_max = 3.0;
  return limits;
}

}  // namespace

// A single 9th-order piece 1 m up takes 1.0344 s with fixed pitch: the closed form of docs/paper.md.
TEST_CASE("one piece straight up takes the time of the closed form") {
  Problem climb = course({{0, 0, 1}, {0, 0, 2}}, 3.0);
  for (Mask& given : climb.given) given.setConstant(true);
  Limits limits = rotors_alone();
  limits.vertical = true;
  SolverSettings settings;
  settings.samples = 200;
  const Constraints constraints(paper_vehicle(), limits, false);
  const Solution solution = minimise_time(climb, constraints, settings, {});
  CHECK(solution.feasible);
  CHECK(solution.trajectory.total() == doctest::Approx(1.0344).epsilon(2e-4));
}

TEST_CASE("the answer is inside the limits, meets the points, and is the same twice") {
  const Problem start = course({{0, 0, 1}, {2, 1, 2}, {4, -1, 1}}, 2.0);
  const Constraints constraints(paper_vehicle(), rotors_alone(), false);
  const Solution one = minimise_time(start, constraints, {}, {});
  const Solution two = minimise_time(start, constraints, {}, {});
  CHECK(one.feasible);
  CHECK(one.trajectory.total() < 0.7 * start.start.total());
  CHECK(least_margin(one.trajectory, start, constraints, 32) >= 0.0);
  for (int k = 0; k <= start.pieces(); ++k) {
    CHECK(one.trajectory.nodes[k].row(0).head<3>() == start.start.nodes[k].row(0).head<3>());
    CHECK(one.trajectory.nodes[k] == two.trajectory.nodes[k]);
  }
}

TEST_CASE("a given velocity stays given") {
  Problem start = course({{0, 0, 1}, {2, 0, 1}, {4, 0, 1}}, 2.0);
  start.given[1].row(1).head<3>().setConstant(true);
  start.start.nodes[1].row(1).head<3>() << 1.5, 0.0, 0.0;
  const Constraints constraints(paper_vehicle(), rotors_alone(), false);
  const Solution solution = minimise_time(start, constraints, {}, {});
  CHECK(solution.feasible);
  CHECK(solution.trajectory.nodes[1](1, 0) == 1.5);
  CHECK(solution.trajectory.at(0, 1.0)(1, 0) == doctest::Approx(1.5));
}

TEST_CASE("the price of the least thrust is the slope of the time over it, by differences") {
  Problem climb = course({{0, 0, 1}, {0, 0, 2}}, 3.0);
  for (Mask& given : climb.given) given.setConstant(true);
  const auto solved = [&](double rotor_min) {
    Limits limits = rotors_alone();
    limits.rotor_min = rotor_min;
    limits.vertical = true;
    SolverSettings settings;
    settings.samples = 200;
    settings.gap_end = 1e-5;
    return minimise_time(climb, Constraints(paper_vehicle(), limits, false), settings, {});
  };
  const double step = 0.01;
  const double slope = (solved(0.15 + step).trajectory.total() - solved(0.15 - step).trajectory.total()) / (2.0 * step);
  CHECK(solved(0.15).push_price == doctest::Approx(slope).epsilon(0.02));
  CHECK(slope > 0.1);
}

TEST_CASE("nothing is paid for a least thrust that is not touched") {
  const Problem start = course({{0, 0, 1}, {2, 1, 2}, {4, -1, 1}}, 2.0);
  Limits limits = rotors_alone();
  limits.rotor_min = -3.0;
  limits.rotor_max = 2.0;
  limits.body_rate_max = 1.0;
  CHECK(minimise_time(start, Constraints(paper_vehicle(), limits, false), {}, {}).push_price == 0.0);
}

TEST_CASE("stopped from outside it returns the best flight so far") {
  const Problem start = course({{0, 0, 1}, {2, 1, 2}, {4, -1, 1}}, 3.0);
  const Constraints constraints(paper_vehicle(), rotors_alone(), false);
  int calls = 0;
  const Solution solution = minimise_time(start, constraints, {}, [&](double) { return ++calls < 6; });
  CHECK(solution.interrupted);
  CHECK(solution.feasible);
  CHECK(solution.trajectory.total() < start.start.total());
}

}  // namespace halfroll::planner
