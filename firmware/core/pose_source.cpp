#include "core/pose_source.hpp"

#include <algorithm>

namespace halfroll {
namespace {

constexpr std::uint64_t kSilentUs = 200000;
constexpr std::uint64_t kAheadUs = 20000, kBehindUs = 1000000;  // stamps that can be vehicle time
enum Sensor { kOwnPose = 1, kLinkedPose = 2 };

std::uint64_t taken_at(std::uint64_t stamp_us, std::uint64_t t_us, const Params& params) {
  const bool vehicle_time = stamp_us != 0 && stamp_us <= t_us + kAheadUs && stamp_us + kBehindUs >= t_us;
  if (vehicle_time) return std::min(stamp_us, t_us);
  const auto delay_us = static_cast<std::uint32_t>(1e6F * params.est_pose_delay);
  return t_us > delay_us ? t_us - delay_us : 0;
}

}  // namespace

std::optional<PoseFix> PoseSource::choose(std::uint64_t t_us, const std::optional<PoseFix>& own,
                                          const std::optional<LinkedPose>& linked, const Params& params) {
  const int used = static_cast<int>(params.est_sensors);
  if (own && (used & kOwnPose) != 0) {
    own_heard_ = true;
    own_us_ = t_us;
    return own;
  }
  if (!linked || (used & kLinkedPose) == 0) return std::nullopt;
  if (own_heard_ && t_us - own_us_ < kSilentUs) return std::nullopt;
  if (linked_heard_ && linked->source != owner_ && t_us - linked_us_ < kSilentUs) return std::nullopt;
  linked_heard_ = true;
  linked_us_ = t_us;
  owner_ = linked->source;
  PoseFix pose = linked->pose;
  pose.t_us = taken_at(pose.t_us, t_us, params);
  return pose;
}

}  // namespace halfroll
