#include "chain.hpp"

#include <algorithm>
#include <cmath>

#include "pack.hpp"

namespace halfroll::planner {
namespace {

constexpr int kPacks = kFront / Pack::kWidth;
constexpr double kLeast = 1e-5, kRaise = 5.0, kForget = 0.1, kMost = 1e9;  // of a piece's own damping

/// matrix -= row' row in the upper triangle, rows from `first` on.
HALFROLL_WIDE void take_away(double* matrix, const double* row, int first) {
  Pack r[kPacks];
  for (int j = first / Pack::kWidth; j < kPacks; ++j) r[j] = load(row + j * Pack::kWidth);
  for (int i = first; i < kFrontUsed; ++i) {
    const Pack factor = splat(row[i]);
    double* out = matrix + i * kFront;
    for (int j = i / Pack::kWidth; j < kPacks; ++j) {
      store(out + j * Pack::kWidth, load(out + j * Pack::kWidth) - factor * r[j]);
    }
  }
}

HALFROLL_WIDE double product(const double* a, const double* b) {
  Pack total = splat(0.0);
  for (int j = 0; j < kFront; j += Pack::kWidth) total += load(a + j) * load(b + j);
  return sum(total);
}

HALFROLL_WIDE void take_away_multiple(double* a, const double* b, double factor) {
  const Pack by = splat(factor);
  for (int j = 0; j < kFront; j += Pack::kWidth) store(a + j, load(a + j) - by * load(b + j));
}

}  // namespace

Chain::Chain(std::vector<int> group) : group_(std::move(group)), fronts_(group_.size()), more_(group_.size()) {
  rows_.reserve(size());
}

bool Chain::eliminate(Front& front, int piece, int place, double damping) {
  rows_.emplace_back();
  Row& row = rows_.back();
  row.piece = piece;
  row.place = place;
  std::fill(row.entries, row.entries + kFront, 0.0);
  const double diagonal = front(place, place) + damping;
  if (!(diagonal > 0.0)) return false;
  row.inverse = 1.0 / std::sqrt(diagonal);
  if (place < kTimes) {
    for (int j = place + 1; j < kFrontUsed; ++j) row.entries[j] = row.inverse * front(place, j);
    take_away(front.entries, row.entries, place + 1);
    return true;
  }
  // A duration, after the left node.
  const int first = piece + 1 == pieces() ? kTimes : kNode;
  for (int j = first; j < kFrontUsed; ++j) {
    if (j != place) row.entries[j] = row.inverse * front(std::min(j, place), std::max(j, place));
  }
  take_away(front.entries, row.entries, first);
  for (int j = 0; j < kFrontUsed; ++j) front(std::min(j, place), std::max(j, place)) = 0.0;
  return true;
}

bool Chain::factorise(double damping) {
  rows_.clear();
  Front start, carried{};  // what was left to the right node and the durations
  for (int k = 0; k < pieces(); ++k) {
    start = fronts_[k];
    for (int i = 0; i < kNode; ++i) {
      for (int j = i; j < kNode; ++j) start(i, j) += carried(kNode + i, kNode + j);
      for (int j = kTimes; j < kFrontUsed; ++j) start(i, j) += carried(kNode + i, j);
    }
    for (int i = kTimes; i < kFrontUsed; ++i) {
      for (int j = i; j < kFrontUsed; ++j) start(i, j) += carried(i, j);
    }
    const std::size_t before = rows_.size();
    double& own = more_[k];
    own = own * kForget < kLeast ? 0.0 : own * kForget;
    for (;;) {
      carried = start;
      if (leave(carried, k, damping + own)) break;
      rows_.resize(before);
      own = std::max(kRaise * own, kLeast);
      if (own > kMost) return false;
    }
  }
  return true;
}

bool Chain::leave(Front& front, int k, double damping) {
  const bool last = k + 1 == pieces();
  for (int i = 0; i < (last ? kTimes : kNode); ++i) {
    if (!eliminate(front, k, i, damping)) return false;
  }
  if ((last || group_[k + 1] != group_[k]) && group_[k] > 0) {
    if (!eliminate(front, k, place(group_[k] - 1), damping)) return false;
  }
  return !last || eliminate(front, k, place(group_[k]), damping);
}

void Chain::load(const Eigen::VectorXd& x, int k, double* front) const {
  std::copy_n(x.data() + node(k), kTimes, front);
  std::fill(front + kTimes, front + kFront, 0.0);
  for (int g = std::max(group_[k] - 1, 0); g <= std::min(group_[k] + 1, group_.back()); ++g) {
    front[place(g)] = x[time(g)];
  }
}

Eigen::VectorXd Chain::solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd x = b;
  alignas(32) double front[kFront];
  const auto keep = [&](int k) {
    std::copy_n(front, kTimes, x.data() + node(k));
    for (int g = std::max(group_[k] - 1, 0); g <= std::min(group_[k] + 1, group_.back()); ++g) {
      x[time(g)] = front[place(g)];
    }
  };
  const int count = static_cast<int>(rows_.size());
  for (int i = 0; i < count; ++i) {
    const Row& row = rows_[i];
    if (i == 0 || rows_[i - 1].piece != row.piece) load(x, row.piece, front);
    front[row.place] *= row.inverse;
    take_away_multiple(front, row.entries, front[row.place]);
    if (i + 1 == count || rows_[i + 1].piece != row.piece) keep(row.piece);
  }
  for (int i = count - 1; i >= 0; --i) {
    const Row& row = rows_[i];
    if (i + 1 == count || rows_[i + 1].piece != row.piece) load(x, row.piece, front);
    front[row.place] = row.inverse * (front[row.place] - product(front, row.entries));
    if (i == 0 || rows_[i - 1].piece != row.piece) keep(row.piece);
  }
  return x;
}

}  // namespace halfroll::planner
