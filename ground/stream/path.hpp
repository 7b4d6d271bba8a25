// A path as a table over its own time, 1 ms apart. Why: what is streamed is looked up, at any instant, in bounded time.
#pragma once
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace halfroll::stream {

inline constexpr double kTableStep = 0.001;   // [s], time stamps are whole milliseconds
inline constexpr double kSigmaWindow = 0.06;  // [s], the sign of the thrust is free this close to an event of sigma

using Row3 = std::array<double, 3>;
/// Position to snap (rows) of x, y, z [m] in W and yaw [rad] (columns).
using Derivatives = std::array<std::array<double, 4>, 5>;

/// Before its start and after its end it is at rest.
class Path {
 public:
  /// Two rows at least in both tables; rates: of the body [rad/s], that the exact inverse dynamics need, in its own
  /// components; sigma_events: when the thrust turns over, upright before the first; turns: when aerobatics are on.
  Path(std::vector<Derivatives> derivatives, std::vector<Row3> rates, std::vector<double> sigma_events, bool leads_nose,
       std::vector<std::pair<double, double>> turns);

  double duration() const { return static_cast<double>(derivatives_.size() - 1) * kTableStep; }
  Derivatives at(double t) const;  // linear between rows
  Row3 rate_at(double t) const;
  Row3 rate_change_at(double t) const;
  double sigma_at(double t) const;
  /// Position feedback turns the attitude the shortest way (references.cpp); not while the path turns over.
  bool leads_nose_at(double t) const;
  bool is_near_sigma_event(double t) const;

  const std::vector<Derivatives>& derivatives() const { return derivatives_; }
  const std::vector<Row3>& rates() const { return rates_; }
  const std::vector<double>& sigma_events() const { return sigma_events_; }
  bool leads_nose() const { return leads_nose_; }
  const std::vector<std::pair<double, double>>& turns() const { return turns_; }

 private:
  std::vector<Derivatives> derivatives_;
  std::vector<Row3> rates_, rate_changes_;
  std::vector<double> sigma_events_;
  bool leads_nose_;
  std::vector<std::pair<double, double>> turns_;
};

}  // namespace halfroll::stream
