// The scaled unknowns of the optimisation. Why: with them a change of a duration only rescales the path in time, which
// is what makes Newton steps long; with physical derivatives the same solver stalls.
//
//   free derivative d at node k:  x = y h^d,  h = sqrt(T before * T after)      durations:  T = share * exp(u of its
//   group) tau-derivative of a piece:    z = T^d y = (T/h)^d x,   dz = (T/h)^d dx + z alpha . du,  u of piece before,
//   own, after
// A given derivative keeps its physical value: z = T^d y, alpha = d for the piece's own u.
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "trajectory.hpp"

namespace halfroll::planner {

using Mask = Eigen::Array<bool, kGiven, kAxes>;

/// What is optimised: a starting trajectory, what is given at its nodes, and which pieces share one leg.
struct Problem {
  Trajectory start;
  std::vector<Mask> given;           // N + 1
  std::vector<int> leg;              // N, rising
  std::vector<double> speed_max;     // N [m/s], infinite for none
  std::array<bool, kAxes> frozen{};  // axes that stand still: given whole at every node
  bool tied = true;                  // pieces of a leg keep their shares of its time

  int pieces() const { return start.pieces(); }
  /// Each piece cut into `parts` equal ones; the path does not change. Frozen axes stay given.
  Problem split(int parts) const;
};

/// Values of all unknowns.
struct Point {
  std::vector<Node> x;  // scaled where free, physical where given
  Eigen::VectorXd u;    // log of time, one a group
};

/// How the tau-derivatives of a piece follow from the unknowns: rows as Ends.
struct PieceMap {
  Ends power;                 // dz/dx, 0 where given
  std::array<Ends, 3> alpha;  // by u of the piece before, its own, the piece after
};

class Unknowns {
 public:
  explicit Unknowns(const Problem& problem);

  Point start() const { return start_; }
  std::vector<double> durations(const Point& point) const;
  Ends ends(const Point& point, const std::vector<double>& durations, int piece) const;
  PieceMap map(const std::vector<double>& durations, int piece) const;
  Trajectory trajectory(const Point& point) const;
  Point moved(const Point& point, const Eigen::VectorXd& step, double length) const;

  int size() const { return static_cast<int>(scale_.size()); }
  /// Of row `row` (0..9, as Ends) and axis of a piece; -1: given.
  int index(int piece, int row, int axis) const { return node_index_[piece + row / kGiven](row % kGiven, axis); }
  /// Of the log time of the piece before (0), itself (1), after (2); -1: there is none.
  int time_index(int piece, int neighbour) const;
  int group(int piece) const { return group_[piece]; }
  /// For steps of unit size to mean the same for every unknown.
  const Eigen::VectorXd& scale() const { return scale_; }
  /// First column of each row of the Hessian.
  std::vector<int> envelope() const;

 private:
  double node_time(const std::vector<double>& durations, int node) const;

  const Problem& problem_;
  Point start_;
  std::vector<Eigen::Array<int, kGiven, kAxes>> node_index_;
  std::vector<int> group_, time_index_;  // of each piece
  std::vector<double> share_;            // of the piece in its group's time
  Eigen::VectorXd scale_;
};

}  // namespace halfroll::planner
