#include "closed_form.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "block_tridiagonal.hpp"
#include "pack.hpp"

namespace halfroll::planner {
namespace {

constexpr int kJumps = kOrder - kGiven;  // derivatives 5..9, which a piece does not share with its neighbours
constexpr int kPaper = 8;                // continuity of the paper's form
constexpr int kTimeOfSnap = -7;          // the integral of the squared snap goes with this power of time

using Square = Eigen::Matrix<double, kOrder, kOrder, Eigen::RowMajor>;

/// What does not depend on durations. Unknowns are derivatives over units of their own, in which no entry of the
/// equations is much larger than one.
struct Tables {
  std::array<double, kGiven> size;  // of derivative d: the root of what a unit of it adds to the jump it is paired with
  Square jumps;                     // derivatives 5..9 at the start of a piece, negative, then at its end
  Square snap;                      // z' . this . z is the integral of the squared 4th derivative

  Tables() {
    for (int r = 0; r < kJumps; ++r) {
      jumps.row(r) = -hermite_row(0.0, kGiven + r).transpose();
      jumps.row(kJumps + r) = hermite_row(1.0, kGiven + r).transpose();
    }
    const Eigen::Matrix<double, kOrder, kOrder>& hermite = hermite_matrix();
    Eigen::Matrix<double, kOrder, kOrder> powers = Eigen::Matrix<double, kOrder, kOrder>::Zero();
    for (int i = 4; i < kOrder; ++i) {
      for (int j = 4; j < kOrder; ++j) {
        powers(i, j) = i * (i - 1.0) * (i - 2.0) * (i - 3.0) * j * (j - 1.0) * (j - 2.0) * (j - 3.0) / (i + j - 7.0);
      }
    }
    snap = hermite.transpose() * powers * hermite;
    for (int d = 0; d < kGiven; ++d) size[d] = std::sqrt(std::abs(jumps(kOrder - 1 - d, kGiven + d)));
    for (int row = 0; row < kOrder; ++row) {
      for (int column = 0; column < kOrder; ++column) {
        jumps(row, column) /= size[kGiven - 1 - row % kJumps] * size[column % kGiven];
        snap(row, column) /= size[row % kGiven] * size[column % kGiven];
      }
    }
  }
};

const Tables& tables() {
  static const Tables made;
  return made;
}

/// Of time at a node, from the shorter piece beside it: costs go with odd powers of time.
struct Units {
  Units(double shorter, bool least_snap) : h(shorter), power((least_snap ? 1.0 : h) * h * h * h * std::sqrt(h)) {}
  double h, power;

  /// Of derivatives 0..4: unknown = unit * derivative.
  std::array<double, kGiven> of_derivatives() const {
    std::array<double, kGiven> unit = tables().size;
    double time = 1.0 / power;
    for (int d = 0; d < kGiven; ++d, time *= h) unit[d] *= time;
    return unit;
  }
};

/// The symmetric form W of one piece over the slots of its start (0..9) and of its end (10..19), in those units: W of
/// two derivatives is snap squared, W of a jump and a derivative is what the piece adds to the jump.
class Piece {
 public:
  Piece(double duration, const Units& start, const Units& end, bool least_snap) : least_snap_(least_snap) {
    const Units* units[2] = {&start, &end};
    BasisRow jump;
    for (int e = 0; e < 2; ++e) {
      const double ratio = duration / units[e]->h, inverse = 1.0 / ratio, second = inverse * inverse;
      double grown = units[e]->power, shrunk = second * second * inverse / units[e]->power;
      for (int d = 0; d < kGiven; ++d, grown *= ratio) stretch_[e * kGiven + d] = grown;
      for (int r = 0; r < kJumps; ++r, shrunk *= inverse) jump[e * kJumps + r] = shrunk;
    }
    for (int row = 0; row < kOrder; ++row) {
      jumps_.row(row) = tables().jumps.row(row).cwiseProduct((jump[row] * stretch_).transpose());
    }
    if (least_snap) {
      energy_ = std::pow(duration, kTimeOfSnap) * stretch_.asDiagonal() * tables().snap * stretch_.asDiagonal();
    } else {
      energy_.setZero();
    }
  }

  /// W of a slot at an end and the derivatives of both ends, ten in a row.
  const double* row(int end, int slot) const {
    return slot >= kGiven ? jumps_.row(end * kJumps + slot - kGiven).data() : energy_.row(end * kGiven + slot).data();
  }
  /// W of a slot and a jump.
  double at_jump(int end, int slot, int other_end, int jump) const {
    return slot >= kGiven ? 0.0 : jumps_(other_end * kJumps + jump - kGiven, end * kGiven + slot);
  }

  /// Unknowns of the two nodes to tau-derivatives at the ends, d by d.
  BasisRow scale() const {
    BasisRow scale = stretch_;
    for (int c = 0; c < kOrder; ++c) scale[c] /= tables().size[c % kGiven];
    return scale;
  }

  /// W . (z, m) at the derivatives of both ends; z derivatives, m multipliers of the jumps, in their units.
  Ends applied(const Ends& z, const Ends& m) const {
    Ends out = jumps_.transpose() * m;
    if (least_snap_) out += energy_ * z;
    return out;
  }

  /// Slope of W((y, n), (z, m)) over the logarithm of the duration, summed over axes; units are constants here.
  double time_slope(const Ends& y, const Ends& n, const Ends& z, const Ends& m) const {
    static const BasisRow order = [] {
      BasisRow made;
      for (int c = 0; c < kOrder; ++c) made[c] = c % kGiven;
      return made;
    }();
    const auto jump_slope = [&](const Ends& derivatives, const Ends& multipliers) {
      const Ends grown = jumps_ * (order.asDiagonal() * derivatives);
      const Ends shrunk = (order.array() + kGiven).matrix().asDiagonal() * (jumps_ * derivatives);
      return multipliers.cwiseProduct(grown - shrunk).sum();
    };
    double slope = jump_slope(z, n) + jump_slope(y, m);
    if (least_snap_) {
      const Ends left = order.asDiagonal() * y, right = order.asDiagonal() * z;
      slope += y.cwiseProduct(energy_ * (kTimeOfSnap * z + right)).sum() + left.cwiseProduct(energy_ * z).sum();
    }
    return slope;
  }

 private:
  bool least_snap_;
  BasisRow stretch_;
  Square jumps_, energy_;
};

std::vector<Units> units_of(const std::vector<double>& durations, bool least_snap) {
  std::vector<Units> units;
  units.reserve(durations.size() + 1);
  for (std::size_t k = 0; k <= durations.size(); ++k) {
    units.emplace_back(std::min(durations[k == 0 ? 0 : k - 1], durations[k == durations.size() ? k - 1 : k]),
                       least_snap);
  }
  return units;
}

/// Derivatives of a node in its units; also slopes over derivatives from slopes over unknowns.
Node in_units(const Node& node, const Units& units) {
  const std::array<double, kGiven> unit = units.of_derivatives();
  Node out;
  for (int d = 0; d < kGiven; ++d) out.row(d) = unit[d] * node.row(d);
  return out;
}

Ends both(const Node& start, const Node& end) {
  Ends ends;
  ends << start, end;
  return ends;
}

}  // namespace

ClosedForm::ClosedForm(std::vector<Node> given, std::vector<double> durations, int continuity)
    : durations_(std::move(durations)), continuity_(continuity), values_(std::move(given)), layouts_(layouts()) {
  if (continuity_ < kPaper) multipliers_.assign(values_.size(), Node::Zero());
  for (const Layout& layout : layouts_) {
    if (layout.block == 0) continue;
    if (!(layout.block <= 4 ? solve_4(layout) : layout.block <= 5 ? solve_5(layout) : solve_8(layout))) return;
  }
}

std::vector<ClosedForm::Layout> ClosedForm::layouts() const {
  const int last = pieces();
  const auto alike = [&](int a, int b) {
    for (const Node& node : values_) {
      for (int d = 0; d < kGiven; ++d) {
        if (std::isnan(node(d, a)) != std::isnan(node(d, b))) return false;
      }
    }
    return true;
  };
  std::vector<Layout> found;
  std::array<bool, kAxes> taken{};
  for (int a = 0; a < kAxes; ++a) {
    if (taken[a]) continue;
    Layout& layout = found.emplace_back();
    for (int b = a; b < kAxes; ++b) {
      if (!taken[b] && (b == a || alike(a, b))) layout.axes[b] = taken[b] = true;
    }
    layout.unknowns.resize(last + 1);
    layout.equations.resize(last + 1);
    layout.given.resize(last + 1);
    for (int k = 0; k <= last; ++k) {
      const bool end = k == 0 || k == last;
      Slots &unknowns = layout.unknowns[k], &equations = layout.equations[k], &fixed = layout.given[k];
      for (int d = 0; d < kGiven; ++d) (std::isnan(values_[k](d, a)) ? unknowns : fixed).add(d);
      if (continuity_ == kPaper) {
        for (int j = 0; j < unknowns.count; ++j) equations.add(end ? kOrder - 1 - unknowns.at[j] : kGiven + j);
      } else {
        const int highest = end ? kGiven - 1 : std::min(continuity_, kOrder - 1 - fixed.count);
        for (int r = kGiven; r <= highest; ++r) unknowns.add(r);
        equations = unknowns;
      }
      layout.block = std::max(layout.block, unknowns.count);
    }
  }
  return found;
}

namespace {

/// Feeds the nodes' equations to the elimination: rows of `down` against columns of `across`, and right-hand sides.
template <int B, class RightHandSide>
bool eliminate(BlockTridiagonal<B, kAxes>& system, const std::vector<Slots>& down, const std::vector<Slots>& across,
               const std::vector<double>& durations, const std::vector<Units>& units, bool least_snap, int& stuck,
               RightHandSide right_hand_side) {
  const int last = static_cast<int>(durations.size());
  std::array<typename BlockTridiagonal<B, kAxes>::Rows, 2> buffers;
  const auto add = [&](typename BlockTridiagonal<B, kAxes>::Rows& to, const Piece& piece, int node, int end, int other,
                       int other_end) {
    const Slots &own = down[node], &theirs = across[other];
    for (int i = 0; i < own.count; ++i) {
      const int slot = own.at[i];
      const double* derivatives = piece.row(end, slot) + other_end * kGiven;
      double* row = &to(i, (other - node + 1) * B);
      int j = 0;
      for (; j < theirs.count && theirs.at[j] < kGiven; ++j) row[j] += derivatives[theirs.at[j]];
      for (; j < theirs.count; ++j) row[j] += piece.at_jump(end, slot, other_end, theirs.at[j]);
    }
  };
  buffers[0].setZero();
  for (int k = 0; k <= last; ++k) {
    auto &rows = buffers[k % 2], &next = buffers[(k + 1) % 2];
    next.setZero();
    if (k < last) {
      const Piece piece(durations[k], units[k], units[k + 1], least_snap);
      add(rows, piece, k, 0, k, 0);
      add(rows, piece, k, 0, k + 1, 1);
      add(next, piece, k + 1, 1, k, 0);
      add(next, piece, k + 1, 1, k + 1, 1);
      right_hand_side(piece, k, rows.template middleCols<kAxes>(3 * B), next.template middleCols<kAxes>(3 * B));
    }
    for (int i = down[k].count; i < B; ++i) rows(i, B + i) = 1.0;  // nothing to find
    if (!system.push(rows)) {
      stuck = k;
      return false;
    }
  }
  return true;
}

}  // namespace

template <int B>
bool ClosedForm::solve(const Layout& layout) {
  const int last = pieces();
  const bool least_snap = continuity_ < kPaper;
  const std::vector<Units> units = units_of(durations_, least_snap);
  BlockTridiagonal<B, kAxes> system(last + 1);
  const auto from_given = [&](const Piece& piece, int k, auto start, auto end) {
    for (int e = 0; e < 2; ++e) {
      const Slots& fixed = layout.given[k + e];
      const std::array<double, kGiven> unit = units[k + e].of_derivatives();
      for (int g = 0; g < fixed.count; ++g) {
        const int d = fixed.at[g];
        const Eigen::Matrix<double, 1, kAxes> x = unit[d] * values_[k + e].row(d);
        for (int i = 0; i < layout.equations[k].count; ++i) {
          start.row(i) -= piece.row(0, layout.equations[k].at[i])[e * kGiven + d] * x;
        }
        for (int i = 0; i < layout.equations[k + 1].count; ++i) {
          end.row(i) -= piece.row(1, layout.equations[k + 1].at[i])[e * kGiven + d] * x;
        }
      }
    }
  };
  if (!eliminate(system, layout.equations, layout.unknowns, durations_, units, least_snap, stuck_, from_given)) {
    return false;
  }
  const auto take = [&](int k, const typename BlockTridiagonal<B, kAxes>::Unknowns& x) {
    const Slots& unknowns = layout.unknowns[k];
    const std::array<double, kGiven> unit = units[k].of_derivatives();
    for (int j = 0; j < unknowns.count; ++j) {
      const int slot = unknowns.at[j];
      for (int a = 0; a < kAxes; ++a) {
        if (!layout.axes[a]) continue;
        if (slot < kGiven) {
          values_[k](slot, a) = x(j, a) / unit[slot];
        } else {
          multipliers_[k](slot - kGiven, a) = x(j, a);
        }
      }
    }
  };
  if (!system.solve(take)) {
    stuck_ = last;
    return false;
  }
  bytes_ = std::max(bytes_, system.bytes());
  return true;
}

HALFROLL_WIDE bool ClosedForm::solve_4(const Layout& layout) { return solve<4>(layout); }
HALFROLL_WIDE bool ClosedForm::solve_5(const Layout& layout) { return solve<5>(layout); }
HALFROLL_WIDE bool ClosedForm::solve_8(const Layout& layout) { return solve<8>(layout); }

Coefficients ClosedForm::coefficients(int piece) const {
  static const Eigen::Matrix<double, kOrder, kOrder, Eigen::RowMajor> hermite = hermite_matrix();
  Coefficients z;
  double power = 1.0;
  for (int d = 0; d < kGiven; ++d, power *= durations_[piece]) {
    z.row(d) = power * values_[piece].row(d);
    z.row(kGiven + d) = power * values_[piece + 1].row(d);
  }
  Coefficients out;
  static constexpr double kInverseFactorial[kGiven] = {1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0};
  for (int d = 0; d < kGiven; ++d) out.row(d) = kInverseFactorial[d] * z.row(d);
  out.bottomRows<kJumps>().noalias() = hermite.bottomRows<kJumps>() * z;
  return out;
}

ClosedForm::Slopes ClosedForm::slopes(const std::vector<Coefficients>& cost) const {
  const int last = pieces();
  const bool least_snap = continuity_ < kPaper;
  Slopes out{std::vector<double>(last, 0.0), std::vector<Node>(last + 1, Node::Zero())};
  std::vector<Ends> by_ends(last);
  const std::vector<Units> units = units_of(durations_, least_snap);
  for (int k = 0; k < last; ++k) by_ends[k] = hermite_matrix().transpose() * cost[k];

  // The multipliers l of the equations: W' l = slope over the unknowns, by the same elimination with the roles
  // exchanged.
  std::vector<Node> l_derivatives(last + 1, Node::Zero()), l_jumps(last + 1, Node::Zero());
  for (const Layout& layout : layouts_) {
    const auto adjoint = [&](auto block) {
      constexpr int B = decltype(block)::value;
      BlockTridiagonal<B, kAxes> system(last + 1);
      int stuck = -1;
      const auto of_cost = [&](const Piece& piece, int k, auto start, auto end) {
        const BasisRow scale = piece.scale();
        for (int i = 0; i < layout.unknowns[k].count; ++i) {
          const int d = layout.unknowns[k].at[i];
          if (d < kGiven) start.row(i) += scale[d] * by_ends[k].row(d);
        }
        for (int i = 0; i < layout.unknowns[k + 1].count; ++i) {
          const int d = layout.unknowns[k + 1].at[i];
          if (d < kGiven) end.row(i) += scale[kGiven + d] * by_ends[k].row(kGiven + d);
        }
      };
      if (!eliminate(system, layout.unknowns, layout.equations, durations_, units, least_snap, stuck, of_cost)) return;
      system.solve([&](int k, const typename BlockTridiagonal<B, kAxes>::Unknowns& x) {
        for (int j = 0; j < layout.equations[k].count; ++j) {
          const int slot = layout.equations[k].at[j];
          for (int a = 0; a < kAxes; ++a) {
            if (layout.axes[a]) (slot < kGiven ? l_derivatives[k](slot, a) : l_jumps[k](slot - kGiven, a)) = x(j, a);
          }
        }
      });
    };
    if (layout.block == 0) continue;
    if (layout.block <= 4) {
      adjoint(std::integral_constant<int, 4>{});
    } else if (layout.block <= 5) {
      adjoint(std::integral_constant<int, 5>{});
    } else {
      adjoint(std::integral_constant<int, 8>{});
    }
  }

  for (int k = 0; k < last; ++k) {
    const Piece piece(durations_[k], units[k], units[k + 1], least_snap);
    const Ends x = both(in_units(values_[k], units[k]), in_units(values_[k + 1], units[k + 1]));
    const Ends m = least_snap ? both(multipliers_[k], multipliers_[k + 1]) : Ends(Ends::Zero());
    const Ends l = both(l_derivatives[k], l_derivatives[k + 1]), l_m = both(l_jumps[k], l_jumps[k + 1]);
    const BasisRow scale = piece.scale();
    const Ends z = scale.asDiagonal() * x;
    double explicitly = 0.0;
    for (int c = 0; c < kOrder; ++c) explicitly += c % kGiven * by_ends[k].row(c).dot(z.row(c));
    out.durations[k] = (explicitly - piece.time_slope(l, l_m, x, m)) / durations_[k];
    const Ends by_x = scale.asDiagonal() * by_ends[k] - piece.applied(l, l_m);
    out.given[k] += by_x.topRows<kGiven>();
    out.given[k + 1] += by_x.bottomRows<kGiven>();
  }
  for (int k = 0; k <= last; ++k) {
    const Node all = in_units(out.given[k], units[k]);
    out.given[k].setZero();
    for (const Layout& layout : layouts_) {
      for (int g = 0; g < layout.given[k].count; ++g) {
        const int d = layout.given[k].at[g];
        for (int a = 0; a < kAxes; ++a) {
          if (layout.axes[a]) out.given[k](d, a) = all(d, a);
        }
      }
    }
  }
  return out;
}

}  // namespace halfroll::planner
