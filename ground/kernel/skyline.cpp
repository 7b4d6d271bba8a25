#include "skyline.hpp"

#include <algorithm>
#include <cmath>

namespace halfroll::planner {

Skyline::Skyline(std::vector<int> first) : first_(std::move(first)), offset_(first_.size()) {
  std::ptrdiff_t used = 0;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    offset_[i] = used - first_[i];
    used += static_cast<std::ptrdiff_t>(i) - first_[i] + 1;
  }
  entries_ = Eigen::VectorXd::Zero(used);
  factor_ = Eigen::VectorXd::Zero(used);
}

bool Skyline::factorise(double damping) {
  using Segment = Eigen::Map<const Eigen::VectorXd>;
  for (int i = 0; i < size(); ++i) {
    double* row = factor_.data() + offset_[i];
    const double* source = entries_.data() + offset_[i];
    for (int j = first_[i]; j < i; ++j) {
      const double* above = factor_.data() + offset_[j];
      const int from = std::max(first_[i], first_[j]);
      row[j] = (source[j] - Segment(row + from, j - from).dot(Segment(above + from, j - from))) / above[j];
    }
    const double pivot = source[i] + damping - Segment(row + first_[i], i - first_[i]).squaredNorm();
    if (!(pivot > 1e-14 * std::abs(source[i]))) return false;
    row[i] = std::sqrt(pivot);
  }
  return true;
}

Eigen::VectorXd Skyline::solve(const Eigen::VectorXd& b) const {
  using Segment = Eigen::Map<const Eigen::VectorXd>;
  Eigen::VectorXd x = b;
  for (int i = 0; i < size(); ++i) {
    const double* row = factor_.data() + offset_[i];
    const int f = first_[i];
    x[i] = (x[i] - Segment(row + f, i - f).dot(x.segment(f, i - f))) / row[i];
  }
  for (int i = size() - 1; i >= 0; --i) {
    const double* row = factor_.data() + offset_[i];
    const int f = first_[i];
    x[i] /= row[i];
    x.segment(f, i - f) -= x[i] * Segment(row + f, i - f);
  }
  return x;
}

}  // namespace halfroll::planner
