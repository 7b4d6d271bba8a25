#include <doctest/doctest.h>

#include "flights.hpp"

namespace halfroll::planner {

TEST_CASE("a piece has the derivatives of its nodes at its ends") {
  const Trajectory path = random_piece(5);
  CHECK(path.at(0, 0.0).isApprox(path.nodes[0], 1e-12));
  CHECK(path.at(0, 1.0).isApprox(path.nodes[1], 1e-9));
}

TEST_CASE("splitting a piece does not change the path") {
  Problem whole;
  whole.start = random_piece(6);
  whole.given = {Mask::Constant(true), Mask::Constant(true)};
  whole.leg = {0};
  whole.limits = {PieceLimits{}};
  const Problem split = whole.split(4);
  CHECK(split.pieces() == 4);
  CHECK(split.start.total() == doctest::Approx(whole.start.total()).epsilon(1e-15));
  for (double t : {0.03, 0.3, 0.62, 0.97}) {
    const int piece = static_cast<int>(4.0 * t);
    const Node there = split.start.at(piece, 4.0 * t - piece), here = whole.start.at(0, t);
    CHECK((there - here).norm() < 1e-8 * here.norm());
  }
}

TEST_CASE("stretching time keeps the places and slows the rest down") {
  const Trajectory path = random_piece(7), slower = path.stretched(2.0);
  CHECK(slower.total() == 2.0 * path.total());
  const Node here = path.at(0, 0.4), there = slower.at(0, 0.4);
  for (int d = 0; d < kGiven; ++d) CHECK(there.row(d).isApprox(here.row(d) * std::pow(0.5, d), 1e-12));
}

}  // namespace halfroll::planner
