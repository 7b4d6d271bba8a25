#include "unknowns.hpp"

#include <algorithm>
#include <cmath>

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
      finer.speed_max.push_back(speed_max[k]);
      finer.start.nodes.push_back(i == parts ? start.nodes[k + 1] : start.at(k, static_cast<double>(i) / parts));
      finer.given.push_back(i == parts ? given[k + 1] : inner);
    }
  }
  return finer;
}

Unknowns::Unknowns(const Problem& problem) : problem_(problem) {
  const Trajectory& path = problem.start;
  const int pieces = path.pieces();
  group_.resize(pieces);
  time_index_.resize(pieces);
  share_.resize(pieces);
  std::vector<double> group_time;
  for (int k = 0; k < pieces; ++k) {
    if (k == 0 || !problem.tied || problem.leg[k] != problem.leg[k - 1]) group_time.push_back(0.0);
    group_[k] = static_cast<int>(group_time.size()) - 1;
    group_time.back() += path.durations[k];
  }
  start_.u.resize(static_cast<int>(group_time.size()));
  for (std::size_t g = 0; g < group_time.size(); ++g) start_.u[static_cast<int>(g)] = std::log(group_time[g]);
  for (int k = 0; k < pieces; ++k) share_[k] = path.durations[k] / group_time[group_[k]];

  std::vector<double> scale;
  for (int k = 0; k <= pieces; ++k) {
    const double h = node_time(path.durations, k);
    Node x = path.nodes[k];
    node_index_.emplace_back();
    for (int d = 0; d < kGiven; ++d) {
      for (int a = 0; a < kAxes; ++a) {
        const bool free = !problem.given[k](d, a);
        node_index_[k](d, a) = free ? static_cast<int>(scale.size()) : -1;
        if (!free) continue;
        x(d, a) *= std::pow(h, d);
        scale.push_back(10.0 * h * h);
      }
    }
    start_.x.push_back(x);
    if (k < pieces && (k + 1 == pieces || group_[k + 1] != group_[k])) {  // a leg's time comes after its inner nodes
      for (int j = k; j >= 0 && group_[j] == group_[k]; --j) time_index_[j] = static_cast<int>(scale.size());
      scale.push_back(0.3);
    }
  }
  scale_ = Eigen::Map<Eigen::VectorXd>(scale.data(), static_cast<int>(scale.size()));
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
  for (Ends& alpha : map.alpha) alpha.setZero();
  const int last = static_cast<int>(durations.size()) - 1;
  for (int end = 0; end < 2; ++end) {
    const double ratio = durations[piece] / node_time(durations, piece + end);
    const bool outer = end == 0 ? piece == 0 : piece == last;
    for (int d = 0; d < kGiven; ++d) {
      const int row = end * kGiven + d;
      for (int a = 0; a < kAxes; ++a) {
        if (problem_.given[piece + end](d, a)) {
          map.power(row, a) = 0.0;
          map.alpha[1](row, a) = d;
        } else {
          map.power(row, a) = std::pow(ratio, d);
          map.alpha[1](row, a) = outer ? 0.0 : 0.5 * d;
          map.alpha[end == 0 ? 0 : 2](row, a) = outer ? 0.0 : -0.5 * d;
        }
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
  for (std::size_t k = 0; k < moved.x.size(); ++k) {
    for (int d = 0; d < kGiven; ++d) {
      for (int a = 0; a < kAxes; ++a) {
        const int i = node_index_[k](d, a);
        if (i >= 0) moved.x[k](d, a) += length * step[i];
      }
    }
  }
  for (std::size_t k = 0; k < group_.size(); ++k) {
    moved.u[group_[k]] = point.u[group_[k]] + length * step[time_index_[k]];
  }
  return moved;
}

int Unknowns::time_index(int piece, int neighbour) const {
  const int k = piece + neighbour - 1;
  return k < 0 || k >= static_cast<int>(time_index_.size()) ? -1 : time_index_[k];
}

std::vector<int> Unknowns::envelope() const {
  std::vector<int> first(size());
  for (int i = 0; i < size(); ++i) first[i] = i;
  for (int k = 0; k < static_cast<int>(group_.size()); ++k) {
    std::vector<int> touched;
    for (int row = 0; row < kOrder; ++row) {
      for (int a = 0; a < kAxes; ++a) touched.push_back(index(k, row, a));
    }
    for (int j = 0; j < 3; ++j) touched.push_back(time_index(k, j));
    int lowest = size();
    for (int i : touched) lowest = i < 0 ? lowest : std::min(lowest, i);
    for (int i : touched) {
      if (i >= 0) first[i] = std::min(first[i], lowest);
    }
  }
  return first;
}

}  // namespace halfroll::planner
