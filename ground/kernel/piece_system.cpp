#include "piece_system.hpp"

#include <algorithm>

#include "pack.hpp"

namespace halfroll::planner {
namespace {

constexpr int kRow = SampleTable::kRow;
constexpr int kPacks = kRow / Pack::kWidth;

/// `rows` rows of out, from the first: sum over k of left[k][row] right[k].
template <int rows>
inline void add_rows(const double* left, const double* right, int count, double* out) {
  Pack total[rows][kPacks];
  for (int p = 0; p < rows; ++p) {
    for (int q = 0; q < kPacks; ++q) total[p][q] = load(out + p * kRow + q * Pack::kWidth);
  }
  for (int k = 0; k < count; ++k, left += kRow, right += kRow) {
    const Pack r[kPacks] = {load(right), load(right + 4), load(right + 8)};
    for (int p = 0; p < rows; ++p) {
      const Pack factor = splat(left[p]);
      for (int q = 0; q < kPacks; ++q) total[p][q] += factor * r[q];
    }
  }
  for (int p = 0; p < rows; ++p) {
    for (int q = 0; q < kPacks; ++q) store(out + p * kRow + q * Pack::kWidth, total[p][q]);
  }
}

/// out (10, 12) += left' right, both (count, 12)
HALFROLL_WIDE void add_product(const double* left, const double* right, int count, double* out) {
  add_rows<4>(left, right, count, out);
  add_rows<4>(left + 4, right, count, out + 4 * kRow);
  add_rows<2>(left + 8, right, count, out + 8 * kRow);
}

/// out[i] += scale weight[i] table[i], rows of 12
HALFROLL_WIDE void add_weighted_rows(const double* table, const double* weight, double scale, int count, double* out) {
  for (int i = 0; i < count; ++i) {
    const Pack factor = splat(scale * weight[i]);
    for (int q = 0; q < kRow; q += Pack::kWidth) {
      store(out + i * kRow + q, load(out + i * kRow + q) + factor * load(table + i * kRow + q));
    }
  }
}

/// out (12) += scale sum over i of weight[i] table[i]
HALFROLL_WIDE void add_combination(const double* table, const double* weight, double scale, int count, double* out) {
  Pack total[kPacks] = {};
  for (int i = 0; i < count; ++i) {
    const Pack factor = splat(weight[i]);
    for (int q = 0; q < kPacks; ++q) total[q] += factor * load(table + i * kRow + q * Pack::kWidth);
  }
  for (int q = 0; q < kPacks; ++q) {
    store(out + q * Pack::kWidth, load(out + q * Pack::kWidth) + scale * total[q]);
  }
}

/// out += a b and the like, sample by sample
HALFROLL_WIDE void add_samples(const double* a, const double* b, int count, double* out) {
  for (int i = 0; i < count; i += Pack::kWidth) store(out + i, load(out + i) + load(a + i) * load(b + i));
}

/// matrix[pair] += w slope_e slope_f for all pairs of a row's entries; ids: their places.
HALFROLL_WIDE void add_outer(const double* slopes, const double* weight, const int* ids, int entries, int count,
                             double* matrix) {
  for (int e = 0; e < entries; ++e) {
    for (int i = 0; i < count; i += Pack::kWidth) {
      const Pack left = load(weight + i) * load(slopes + e * count + i);
      for (int f = 0; f <= e; ++f) {
        const int high = std::max(ids[e], ids[f]), low = std::min(ids[e], ids[f]);
        double* out = matrix + (high * (high + 1) / 2 + low) * count + i;
        store(out, load(out) + left * load(slopes + f * count + i));
      }
    }
  }
}

}  // namespace

HALFROLL_WIDE void PieceSystem::multiply(const Ends& x, Ends& out) const {
  Pack in[kAxes][kPacks] = {}, result[kAxes][kPacks] = {};
  double across[kAxes][kOrder] = {};
  for (int a = 0; a < kAxes; ++a) {
    for (int i = 0; i < kOrder; ++i) in[a][i / Pack::kWidth].v[i % Pack::kWidth] = x(i, a);
  }
  for (int a = 0; a < kAxes; ++a) {
    for (int b = 0; b <= a; ++b) {
      for (int i = 0; i < kOrder; ++i) {
        const Pack factor = splat(x(i, a));
        Pack dot = splat(0.0);
        for (int q = 0; q < kPacks; ++q) {
          const Pack entries = load(&block[a][b][i * kRow + q * Pack::kWidth]);
          dot += entries * in[b][q];
          if (a != b) result[b][q] += factor * entries;
        }
        across[a][i] += sum(dot);
      }
    }
  }
  for (int a = 0; a < kAxes; ++a) {
    for (int i = 0; i < kOrder; ++i) out(i, a) = across[a][i] + result[a][i / Pack::kWidth].v[i % Pack::kWidth];
  }
}

PieceAssembly::PieceAssembly(const Constraints& constraints, const SampleTable& table)
    : constraints_(constraints), table_(table) {
  const auto before = [](const Entry& a, const Entry& b) {
    return a.axis != b.axis ? a.axis < b.axis : a.order < b.order;
  };
  const auto same = [](const Entry& a, const Entry& b) { return a.axis == b.axis && a.order == b.order; };
  for (const Row& row : constraints.rows()) entries_.insert(entries_.end(), row.entries.begin(), row.entries.end());
  std::sort(entries_.begin(), entries_.end(), before);
  entries_.erase(std::unique(entries_.begin(), entries_.end(), same), entries_.end());
  const auto find = [&](const Entry& entry) {
    return static_cast<int>(std::lower_bound(entries_.begin(), entries_.end(), entry, before) - entries_.begin());
  };
  for (const Row& row : constraints.rows()) {
    rows_.emplace_back();
    for (const Entry& entry : row.entries) rows_.back().push_back(find(entry));
  }
  if (!constraints.limits().vertical) {
    for (int e = 0; e < constraints.dynamic_entries(); ++e) dynamic_.push_back(find(dynamic_entry(e)));
  }
}

void PieceAssembly::assemble(const FlatSamples& flat, const std::vector<Eigen::MatrixXd>& slopes, double duration,
                             const Eigen::MatrixXd& stiff, const Eigen::MatrixXd& force, const Eigen::MatrixXd& curved,
                             PieceSystem& out) {
  out = {};
  powers_[0] = 1.0;
  for (int d = 1; d < kSampled; ++d) powers_[d] = powers_[d - 1] / duration;
  weigh_rows(slopes, stiff, force, curved);
  if (curved.size() > 0 && !dynamic_.empty()) {
    curvature(constraints_, flat, curved, hessians_);
    for (int e = 0; e < constraints_.dynamic_entries(); ++e) {
      for (int f = 0; f <= e; ++f) {
        matrix_.col(pair(dynamic_[e], dynamic_[f])) += hessians_.col(dynamic_pair(e, f));
      }
    }
  }
  carry_time(flat, out);
  carry_axes(out);
}

void PieceAssembly::weigh_rows(const std::vector<Eigen::MatrixXd>& slopes, const Eigen::MatrixXd& stiff,
                               const Eigen::MatrixXd& force, const Eigen::MatrixXd& curved) {
  const int count = table_.count(), entries = static_cast<int>(entries_.size());
  matrix_.setZero(count, entries * (entries + 1) / 2);
  gradient_.setZero(count, entries);
  pull_.setZero(count, entries);
  for (int r = 0; r < static_cast<int>(rows_.size()); ++r) {
    const double* slope = slopes[r].data();
    add_outer(slope, stiff.col(r).data(), rows_[r].data(), static_cast<int>(rows_[r].size()), count, matrix_.data());
    for (int e : rows_[r]) {
      add_samples(slope, force.col(r).data(), count, gradient_.col(e).data());
      if (curved.size() > 0) add_samples(slope, curved.col(r).data(), count, pull_.col(e).data());
      slope += count;
    }
  }
}

/// A longer piece at the same tau-derivatives: q = T^-r Q, so dq/dlog T = -r q.
void PieceAssembly::carry_time(const FlatSamples& flat, PieceSystem& out) {
  const int entries = static_cast<int>(entries_.size());
  Eigen::VectorXd product(table_.count());
  for (int e = 0; e < entries; ++e) {
    const auto [axis, order] = entries_[e];
    const double scale = powers_[order];
    product = -order * pull_.col(e);
    for (int f = 0; f < entries; ++f) {
      if (entries_[f].order == 0) continue;
      product -=
          entries_[f].order * matrix_.col(pair(e, f)).cwiseProduct(flat[entries_[f].order].col(entries_[f].axis));
    }
    add_combination(table_.rows(order), product.data(), scale, table_.count(), out.by_time[axis]);
    add_combination(table_.rows(order), gradient_.col(e).data(), scale, table_.count(), out.gradient[axis]);
    add_combination(table_.rows(order), pull_.col(e).data(), scale, table_.count(), out.pull[axis]);
    out.time_time -= order * product.dot(flat[order].col(axis));
    out.time_gradient -= order * gradient_.col(e).dot(flat[order].col(axis));
  }
}

/// block[a][b] = sum over entries e of a, f of b, and samples: h_e M_ef h_f'
void PieceAssembly::carry_axes(PieceSystem& out) {
  const int entries = static_cast<int>(entries_.size()), count = table_.count();
  inner_.resize(count * kRow);
  for (int e = 0; e < entries; ++e) {
    for (int b = 0; b <= entries_[e].axis; ++b) {
      std::fill(inner_.begin(), inner_.end(), 0.0);
      bool any = false;
      for (int f = 0; f < entries; ++f) {
        if (entries_[f].axis != b) continue;
        any = true;
        const double scale = powers_[entries_[e].order] * powers_[entries_[f].order];
        add_weighted_rows(table_.rows(entries_[f].order), matrix_.col(pair(e, f)).data(), scale, count, inner_.data());
      }
      if (any) add_product(table_.rows(entries_[e].order), inner_.data(), count, out.block[entries_[e].axis][b]);
    }
  }
}

}  // namespace halfroll::planner
