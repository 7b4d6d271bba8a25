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
#include "vehicle.hpp"

namespace halfroll::planner {

using Mask = Eigen::Array<bool, kGiven, kAxes>;

/// What is optimised: a starting trajectory, what is given at its nodes, and which pieces share one leg.
struct Problem {
  Trajectory start;
  std::vector<Mask> given;           // N + 1
  std::vector<int> leg;              // N, rising
  std::vector<PieceLimits> limits;   // N
  std::vector<bool> timed;           // N, whether its time is given; alike in a leg. Empty: none
  std::array<bool, kAxes> frozen{};  // axes that stand still: given whole at every node
  bool tied = true;                  // pieces of a leg keep their shares of its time

  int pieces() const { return start.pieces(); }
  /// Each piece cut into `parts` equal ones; the path does not change. Frozen axes stay given.
  Problem split(int parts) const;
  /// Pieces first..last-1 alone, between nodes that are given whole: whatever comes of it fits in their place.
  Problem part(int first, int last) const;
  /// With the flight of a part, whose first piece is `first` here.
  Problem with(int first, const Trajectory& better) const;
};

/// Values of all unknowns.
struct Point {
  std::vector<Node> x;  // scaled where free, physical where given
  Eigen::VectorXd u;    // log of time, one a group
};

/// How the tau-derivatives of a piece follow from the unknowns: rows as Ends.
struct PieceMap {
  struct Time {
    int group;
    Ends alpha;  // zero for groups that are not there
  };
  Ends power;                 // dz/dx, 0 where given
  std::array<Time, 3> times;  // of the groups before, its own, after; neighbours in one group: all in its own
};

/// Order of the unknowns as in Chain: kNode a node (Node's columns), then one a group. Given ones have scale 0.
class Unknowns {
 public:
  explicit Unknowns(const Problem& problem);

  const Point& start() const { return start_; }
  std::vector<double> durations(const Point& point) const;
  Ends ends(const Point& point, const std::vector<double>& durations, int piece) const;
  PieceMap map(const std::vector<double>& durations, int piece) const;
  Trajectory trajectory(const Point& point) const;
  Point moved(const Point& point, const Eigen::VectorXd& step, double length) const;

  int size() const { return static_cast<int>(scale_.size()); }
  int node(int k) const { return kNode * k; }
  int time(int group) const { return size() - static_cast<int>(start_.u.size()) + group; }
  const std::vector<int>& group() const { return group_; }  // of each piece
  /// For steps of unit size to mean the same for every unknown.
  const Eigen::VectorXd& scale() const { return scale_; }

 private:
  double node_time(const std::vector<double>& durations, int node) const;

  const Problem& problem_;
  Point start_;
  std::vector<int> group_;
  std::vector<double> share_;  // of the piece in its group's time
  Eigen::VectorXd scale_;
};

}  // namespace halfroll::planner
