// Whose poses are believed: one sender at a time. Why: two motion captures never agree to the millimetre, and a filter
// that alternates between them flies neither.
#pragma once
#include <optional>

#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

/// A pose by link: its t_us is the sender's stamp, whatever clock that is.
struct LinkedPose {
  PoseFix pose;
  std::uint32_t source = 0;  // who sent it
};

class PoseSource {
 public:
  /// The pose to use in this millisecond. The vehicle's own motion capture goes before any by link, which are heard
  /// only when it has been silent for 0.2 s; among those by link the first is kept until it has been silent as long.
  /// EST_SENSORS switches either off. A linked pose is dated by its stamp if that is vehicle time (at most 20 ms ahead,
  /// 1 s behind), otherwise EST_POSE_DELAY before its arrival.
  std::optional<PoseFix> choose(std::uint64_t t_us, const std::optional<PoseFix>& own,
                                const std::optional<LinkedPose>& linked, const Params& params);

  auto state() const { return std::tie(own_us_, linked_us_, owner_, own_heard_, linked_heard_); }

 private:
  std::uint64_t own_us_ = 0, linked_us_ = 0;  // last heard
  std::uint32_t owner_ = 0;                   // of the poses by link
  bool own_heard_ = false, linked_heard_ = false;
};

}  // namespace halfroll
