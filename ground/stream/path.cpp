#include "stream/path.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace halfroll::stream {
namespace {

/// The row at or before t, and how far on the way to the next.
struct Place {
  std::size_t below, above;
  double share;
};

Place place_of(double t, std::size_t rows) {
  const double row = std::min(std::max(t / kTableStep, 0.0), static_cast<double>(rows - 1));
  const std::size_t below = std::min(static_cast<std::size_t>(row + 1e-6), rows - 2);
  return {below, below + 1, row - static_cast<double>(below)};
}

template <std::size_t kSize>
std::array<double, kSize> between(const std::array<double, kSize>& a, const std::array<double, kSize>& b,
                                  double share) {
  std::array<double, kSize> mixed;
  for (std::size_t i = 0; i < kSize; ++i) mixed[i] = a[i] + share * (b[i] - a[i]);
  return mixed;
}

Row3 interpolated(const std::vector<Row3>& table, double t) {
  const Place place = place_of(t, table.size());
  return between(table[place.below], table[place.above], place.share);
}

/// Central differences, one-sided at the ends.
std::vector<Row3> changes_of(const std::vector<Row3>& table) {
  std::vector<Row3> changes(table.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 1, table.size() - 1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      changes[i][axis] =
          (table[after][axis] - table[before][axis]) / (static_cast<double>(after - before) * kTableStep);
    }
  }
  return changes;
}

}  // namespace

Path::Path(std::vector<Derivatives> derivatives, std::vector<Row3> rates, std::vector<double> sigma_events,
           bool leads_nose, std::vector<std::pair<double, double>> turns)
    : derivatives_(std::move(derivatives)),
      rates_(std::move(rates)),
      sigma_events_(std::move(sigma_events)),
      leads_nose_(leads_nose),
      turns_(std::move(turns)) {
  if (derivatives_.size() < 2 || rates_.size() < 2) throw std::invalid_argument("a path has two rows at least");
  rate_changes_ = changes_of(rates_);
}

Derivatives Path::at(double t) const {
  const Place place = place_of(t, derivatives_.size());
  const Derivatives &a = derivatives_[place.below], &b = derivatives_[place.above];
  Derivatives mixed;
  for (std::size_t order = 0; order < mixed.size(); ++order) mixed[order] = between(a[order], b[order], place.share);
  return mixed;
}

Row3 Path::rate_at(double t) const { return interpolated(rates_, t); }

Row3 Path::rate_change_at(double t) const { return interpolated(rate_changes_, t); }

double Path::sigma_at(double t) const {
  const auto passed = std::upper_bound(sigma_events_.begin(), sigma_events_.end(), t) - sigma_events_.begin();
  return passed % 2 == 0 ? 1.0 : -1.0;
}

bool Path::leads_nose_at(double t) const {
  const bool turning =
      std::any_of(turns_.begin(), turns_.end(), [t](const auto& turn) { return turn.first <= t && t <= turn.second; });
  return leads_nose_ && !turning && sigma_at(t) > 0.0;
}

bool Path::is_near_sigma_event(double t) const {
  return std::any_of(sigma_events_.begin(), sigma_events_.end(),
                     [t](double event) { return std::abs(t - event) < kSigmaWindow; });
}

}  // namespace halfroll::stream
