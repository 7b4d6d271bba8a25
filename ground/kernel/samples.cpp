#include "samples.hpp"

#include "pack.hpp"

namespace halfroll::planner {

SampleTable::SampleTable(int count, bool rates)
    : intervals_(rates ? count - 1 : count), derivatives_(rates ? kSampled : kGiven) {
  for (int d = 0; d < derivatives_; ++d) {
    tables_[d].resize(count, kOrder);
    rows_[d].assign(count * kRow, 0.0);
    for (int i = 0; i < count; ++i) {
      const BasisRow row = hermite_row(static_cast<double>(i) / intervals_, d);
      tables_[d].row(i) = row;
      std::copy_n(row.data(), kOrder, &rows_[d][i * kRow]);
    }
  }
}

HALFROLL_WIDE void sample_piece(const Ends& ends, double duration, const SampleTable& table, FlatSamples& flat) {
  const int count = table.count();
  double power = 1.0;
  for (int d = 0; d < table.derivatives(); ++d, power /= duration) {
    flat[d].resize(count, kAxes);
    const double* basis = table[d].data();
    double* out = flat[d].data();
    for (int i = 0; i < count; i += Pack::kWidth) {
      Pack total[kAxes] = {};
      for (int q = 0; q < kOrder; ++q) {
        const Pack h = load(basis + q * count + i);
        for (int a = 0; a < kAxes; ++a) total[a] += splat(ends(q, a)) * h;
      }
      for (int a = 0; a < kAxes; ++a) store(out + a * count + i, power * total[a]);
    }
  }
}

}  // namespace halfroll::planner
