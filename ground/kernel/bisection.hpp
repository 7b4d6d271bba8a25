// Parts of a piece, halved until what is asked of them is proven, four at a time. Why: that search is the same whatever
// the flight is made of.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "certificate.hpp"
#include "pack.hpp"

namespace halfroll::planner {

/// Four parts of a piece: tau in [centre - half, centre + half], both exact.
struct Parts {
  Pack centre, half;
};

/// The bound that a part may exceed by most, relative to a size of its own; none: the part is proven.
struct Doubt {
  int bound = -1;
  double excess = 0.0, relative = 0.0;

  /// A bound that may be exceeded by `over`; NaN counts as infinitely much.
  void consider(int other, double over, double scale) {
    if (std::isnan(over)) over = kNoLimit;
    if (over / scale > relative) *this = {other, over, over / scale};
  }
};
using Doubts = std::array<Doubt, Pack::kWidth>;

/// Tells the certificate about tau from `begin` to `end` of piece k. look(Parts) -> Doubts. False: not proven.
template <class Look>
bool prove(int k, double begin, double end, Certificate& result, Look&& look) {
  constexpr double kSmallest = 1.0 / 4096.0;
  std::vector<std::array<double, 2>> open;  // centre, half; the next is the last
  const double first = (end - begin) / (2 * Pack::kWidth);
  for (int i = Pack::kWidth - 1; i >= 0; --i) open.push_back({begin + (2 * i + 1) * first, first});
  while (!open.empty()) {
    const int count = std::min<int>(Pack::kWidth, static_cast<int>(open.size()));
    Parts parts;
    for (int lane = 0; lane < Pack::kWidth; ++lane) {  // lanes without a part of their own repeat the last one
      const auto& [centre, half] = open[open.size() - 1 - std::min(lane, count - 1)];
      parts.centre.v[lane] = centre;
      parts.half.v[lane] = half;
    }
    open.resize(open.size() - count);
    result.intervals += count;
    const Doubts doubts = look(parts);
    for (int lane = count - 1; lane >= 0; --lane) {
      const Doubt& doubt = doubts[lane];
      if (doubt.bound < 0) continue;
      const double centre = parts.centre.v[lane], half = parts.half.v[lane] / 2.0;
      if (half * 4.0 > kSmallest) {
        open.push_back({centre + half, half});
        open.push_back({centre - half, half});
        continue;
      }
      result.refuse(k, doubt.bound, doubt.excess, doubt.relative);
      return false;  // one is enough to refuse the piece
    }
  }
  return true;
}

}  // namespace halfroll::planner
