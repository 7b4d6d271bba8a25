#include "unknowns.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace halfroll::planner {
namespace {

/// At a node put inside a piece everything is free but the axes that stand still.
Mask inner_mask(const Problem& problem) {
  Mask mask = Mask::Constant(false);
  for (int a = 0; a < kAxes; ++a) mask.col(a).setConstant(problem.frozen[a]);
  return mask;
}

}  // namespace

Problem Problem::split(int parts) const {
  Problem finer;
  finer.tied = tied;
  finer.frozen = frozen;
  const Mask inner = inner_mask(*this);
  finer.start.nodes.push_back(start.nodes[0]);
  finer.given.push_back(given[0]);
  for (int k = 0; k < pieces(); ++k) {
    for (int i = 1; i <= parts; ++i) {
      finer.start.durations.push_back(start.durations[k] / parts);
      finer.leg.push_back(leg[k]);
      finer.limits.push_back(limits[k]);
      if (!timed.empty()) finer.timed.push_back(timed[k]);
      finer.start.nodes.push_back(i == parts ? start.nodes[k + 1] : start.at(k, static_cast<double>(i) / parts));
      finer.given.push_back(i == parts ? given[k + 1] : inner);
    }
  }
  return finer;
}

Problem Problem::part(int first, int last) const {
  const auto pieces_of = [&](const auto& all) {
    return std::decay_t<decltype(all)>(all.begin() + first, all.begin() + last);
  };
  const auto nodes_of = [&](const auto& all) {
    return std::decay_t<decltype(all)>(all.begin() + first, all.begin() + last + 1);
  };
  Problem some = {{nodes_of(start.nodes), pieces_of(start.durations)},
                  nodes_of(given),
                  pieces_of(leg),
                  pieces_of(limits),
                  timed.empty() ? timed : pieces_of(timed),
                  frozen,
                  tied};
  some.given.front().setConstant(true);
  some.given.back().setConstant(true);
  return some;
}

Problem Problem::with(int first, const Trajectory& better) const {
  Problem all = *this;
  std::copy(better.nodes.begin(), better.nodes.end(), all.start.nodes.begin() + first);
  std::copy(better.durations.begin(), better.durations.end(), all.start.durations.begin() + first);
  return all;
}

Unknowns::Unknowns(const Problem& problem) : problem_(problem) {
  const Trajectory& path = problem.start;
  const int pieces = path.pieces();
  group_.resize(pieces);
  share_.resize(pieces);
  std::vector<double> group_time;
  for (int k = 0; k < pieces; ++k) {
    if (k == 0 || !problem.tied || problem.leg[k] != problem.leg[k - 1]) group_time.push_back(0.0);
    group_[k] = static_cast<int>(group_time.size()) - 1;
    group_time.back() += path.durations[k];
  }
  const int groups = static_cast<int>(group_time.size());
  start_.u = Eigen::Map<Eigen::ArrayXd>(group_time.data(), groups).log();
  for (int k = 0; k < pieces; ++k) share_[k] = path.durations[k] / group_time[group_[k]];

  scale_.setZero(kNode * (pieces + 1) + groups);
  scale_.tail(groups).setConstant(0.3);
  for (int k = 0; k < pieces; ++k) {
    if (!problem.timed.empty() && problem.timed[k]) scale_[time(group_[k])] = 0.0;
  }
  for (int k = 0; k <= pieces; ++k) {
    const double h = node_time(path.durations, k);
    Node x = path.nodes[k];
    for (int a = 0; a < kAxes; ++a) {
      for (int d = 0; d < kGiven; ++d) {
        if (problem.given[k](d, a)) continue;
        x(d, a) *= std::pow(h, d);
        scale_[node(k) + a * kGiven + d] = 10.0 * h * h;
      }
    }
    start_.x.push_back(x);
  }
}

double Unknowns::node_time(const std::vector<double>& durations, int node) const {
  const int last = static_cast<int>(durations.size());
  if (node == 0) return durations[0];
  if (node == last) return durations[last - 1];
  return std::sqrt(durations[node - 1] * durations[node]);
}

std::vector<double> Unknowns::durations(const Point& point) const {
  std::vector<double> durations(share_.size());
  for (std::size_t k = 0; k < share_.size(); ++k) durations[k] = share_[k] * std::exp(point.u[group_[k]]);
  return durations;
}

PieceMap Unknowns::map(const std::vector<double>& durations, int piece) const {
  PieceMap map;
  const int last = static_cast<int>(durations.size()) - 1, own = group_[piece];
  for (int j = 0; j < 3; ++j) map.times[j] = {own + j - 1, Ends::Zero()};
  for (int end = 0; end < 2; ++end) {
    const double ratio = durations[piece] / node_time(durations, piece + end);
    const bool outer = end == 0 ? piece == 0 : piece == last;
    const int neighbour = outer ? 1 : group_[end == 0 ? piece - 1 : piece + 1] - own + 1;
    double power = 1.0;
    for (int d = 0; d < kGiven; ++d, power *= ratio) {
      const int row = end * kGiven + d;
      for (int a = 0; a < kAxes; ++a) {
        const bool given = problem_.given[piece + end](d, a);
        map.power(row, a) = given ? 0.0 : power;
        map.times[1].alpha(row, a) = given ? d : 0.5 * d;
        if (!given) map.times[neighbour].alpha(row, a) -= 0.5 * d;
      }
    }
  }
  return map;
}

Ends Unknowns::ends(const Point& point, const std::vector<double>& durations, int piece) const {
  Ends z;
  for (int end = 0; end < 2; ++end) {
    const int node = piece + end;
    const double T = durations[piece], ratio = T / node_time(durations, node);
    double given = 1.0, free = 1.0;
    for (int d = 0; d < kGiven; ++d, given *= T, free *= ratio) {
      for (int a = 0; a < kAxes; ++a) {
        z(end * kGiven + d, a) = (problem_.given[node](d, a) ? given : free) * point.x[node](d, a);
      }
    }
  }
  return z;
}

Trajectory Unknowns::trajectory(const Point& point) const {
  Trajectory path;
  path.durations = durations(point);
  for (int k = 0; k <= path.pieces(); ++k) {
    const double h = node_time(path.durations, k);
    Node y = point.x[k];
    for (int d = 0; d < kGiven; ++d) {
      for (int a = 0; a < kAxes; ++a) {
        if (!problem_.given[k](d, a)) y(d, a) *= std::pow(h, -d);
      }
    }
    path.nodes.push_back(y);
  }
  return path;
}

Point Unknowns::moved(const Point& point, const Eigen::VectorXd& step, double length) const {
  Point moved = point;
  for (int k = 0; k < static_cast<int>(moved.x.size()); ++k) {
    moved.x[k] += length * Eigen::Map<const Node>(step.data() + node(k));
  }
  moved.u += length * step.tail(point.u.size());
  return moved;
}

}  // namespace halfroll::planner
