#include "link/streams.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"

namespace halfroll::link {
namespace {

constexpr std::int32_t kOff = -1;
constexpr std::uint64_t kNever = ~std::uint64_t{0};
constexpr float kFastestUs = 2500.F;

std::int32_t default_interval_us(std::size_t row, std::size_t link) {
  const float rate_hz = kStreams[row].rate_hz[link];
  return rate_hz > 0.F ? static_cast<std::int32_t>(std::lround(1e6F / rate_hz)) : kOff;
}

std::optional<std::size_t> row_of(std::uint32_t id) {
  for (std::size_t i = 0; i < kStreamCount; ++i) {
    if (kStreams[i].id == id) return i;
  }
  return std::nullopt;
}

/// A stream's own place among the milliseconds, so that slow ones do not all come in one step. Those of 100 Hz and more
/// keep the first: attitude and position of one sample belong together, and in lockstep they precede the question.
std::uint64_t phase_us(std::size_t link, std::size_t row, std::int32_t interval_us) {
  constexpr std::int32_t kFast = 10000;
  if (interval_us <= kFast) return 0;
  return (1U + (3U * row + 5U * link) % 9U) * kStepUs;
}

/// The same attitude, with the sign that continues `before`.
Quat continued(const Quat& q, const Quat& before) { return dot(q, before) < 0.F ? Quat{-q.w, -q.x, -q.y, -q.z} : q; }

void send_all_modes(Endpoint to, const VehicleStatus& status, Outbox& outbox) {
  for (int index = 1; index <= kWireModeCount; ++index) outbox.send(to, Telemetry{msg::kAvailableModes, status, index});
}

}  // namespace

Streams::Streams() {
  for (std::size_t link = 0; link < kLinkCount; ++link) {
    for (std::size_t row = 0; row < kStreamCount; ++row) {
      interval_us_[link][row] = default_interval_us(row, link);
      due_us_[link][row] = interval_us_[link][row] > 0 ? phase_us(link, row, interval_us_[link][row]) : kNever;
    }
  }
}

void Streams::step(VehicleStatus status, Outbox& outbox) {
  q_shown_ = continued(status.estimate.q_WB, q_shown_);
  status.estimate.q_WB = q_shown_;
  next_step_us_ = status.t_us + kStepUs;
  show_changes(status, outbox);
  for (std::size_t link = 0; link < kLinkCount; ++link) {
    if (status.t_us < next_due_us_[link]) continue;
    const Endpoint to = everyone_on(static_cast<int>(link));
    next_due_us_[link] = kNever;
    for (std::size_t row = 0; row < kStreamCount; ++row) {
      if (due_us_[link][row] <= status.t_us) {
        if (kStreams[row].id == msg::kAvailableModes) {
          send_all_modes(to, status, outbox);
        } else {
          outbox.send(to, Telemetry{kStreams[row].id, status, 1, static_cast<int>(link)});
        }
        due_us_[link][row] += static_cast<std::uint64_t>(interval_us_[link][row]);
        if (due_us_[link][row] < next_step_us_) schedule(link, row, next_step_us_);  // time has jumped
      }
      next_due_us_[link] = std::min(next_due_us_[link], due_us_[link][row]);
    }
  }
}

/// The first time from from_us on that is a whole number of intervals past the stream's phase.
void Streams::schedule(std::size_t link, std::size_t row, std::uint64_t from_us) {
  const std::int32_t interval_us = interval_us_[link][row];
  if (interval_us <= 0) {
    due_us_[link][row] = kNever;
    return;
  }
  const auto interval = static_cast<std::uint64_t>(interval_us);
  const std::uint64_t phase = phase_us(link, row, interval_us);
  const std::uint64_t count = from_us <= phase ? 0 : (from_us - phase + interval - 1) / interval;
  due_us_[link][row] = phase + count * interval;
}

void Streams::show_changes(const VehicleStatus& status, Outbox& outbox) {
  const Shown now{static_cast<std::uint32_t>(status.mode) | static_cast<std::uint32_t>(status.system_status) << 8U |
                      (status.armed ? 1U << 16U : 0U),
                  status.landed, status.origin, status.home, status.mission};
  const Shown before = shown_.value_or(now);
  shown_ = now;
  const auto show = [&](std::uint32_t id) { outbox.send(kToAll, Telemetry{id, status}); };
  if (now.heartbeat != before.heartbeat) show(msg::kHeartbeat);
  if ((now.heartbeat & 0xFFU) != (before.heartbeat & 0xFFU)) show(msg::kCurrentMode);
  if (now.landed != before.landed) show(msg::kExtendedSysState);
  if (!(now.origin == before.origin)) show(msg::kGpsGlobalOrigin);
  if (!(now.home == before.home)) show(msg::kHomePosition);
  if (!(now.mission == before.mission)) show(msg::kMissionCurrent);
}

void Streams::service(std::uint64_t wall_us, const VehicleStatus& status, Outbox& outbox) {
  show_changes(status, outbox);
  if (status.t_us != standing_at_us_) {  // time passes: step sends them
    standing_at_us_ = status.t_us;
    heartbeat_wall_us_ = wall_us;
  }
  if (wall_us < heartbeat_wall_us_ + 1000000) return;
  heartbeat_wall_us_ = wall_us;
  outbox.send(kToAll, Telemetry{msg::kHeartbeat, status});
}

CommandResult Streams::set_interval(int link, std::uint32_t id, float interval_us) {
  constexpr float kSlowestUs = 2e9F;
  const std::optional<std::size_t> row = row_of(id);
  if (!row || link < 0 || link >= kLinkCount) return CommandResult::kDenied;
  const auto l = static_cast<std::size_t>(link);
  std::int32_t& interval = interval_us_[l][*row];
  if (interval_us == -1.F) {
    interval = kOff;
  } else if (interval_us == 0.F) {
    interval = default_interval_us(*row, static_cast<std::size_t>(link));
  } else if (interval_us >= kFastestUs && interval_us <= kSlowestUs) {
    interval = static_cast<std::int32_t>(interval_us);
  } else {
    return CommandResult::kDenied;
  }
  schedule(l, *row, next_step_us_);
  next_due_us_[l] = std::min(next_due_us_[l], due_us_[l][*row]);
  return CommandResult::kAccepted;
}

std::optional<std::int32_t> Streams::interval_us(int link, std::uint32_t id) const {
  const std::optional<std::size_t> row = row_of(id);
  if (!row || link < 0 || link >= kLinkCount) return std::nullopt;
  return interval_us_[static_cast<std::size_t>(link)][*row];
}

CommandResult Streams::can_send(std::uint32_t id, float parameter, const VehicleStatus& status) const {
  const auto answer = [](bool good) { return good ? CommandResult::kAccepted : CommandResult::kDenied; };
  const auto whole_up_to = [&](float most) {
    return parameter >= 0.F && parameter <= most && parameter == std::floor(parameter);
  };
  if (id == msg::kMessageInterval) return answer(whole_up_to(65535.F) && row_of(static_cast<std::uint32_t>(parameter)));
  if (id == msg::kAvailableModes) return answer(whole_up_to(kWireModeCount));
  if (id == msg::kHomePosition && !status.home) return CommandResult::kDenied;
  return answer(row_of(id).has_value());
}

void Streams::send_requested(Endpoint to, std::uint32_t id, float parameter, VehicleStatus status,
                             Outbox& outbox) const {
  if (can_send(id, parameter, status) != CommandResult::kAccepted) return;
  if (id == msg::kMessageInterval) {
    const auto asked = static_cast<std::uint16_t>(parameter);
    outbox.send(to, MessageInterval{asked, interval_us(to.link, asked).value_or(0)});
  } else if (id == msg::kAvailableModes) {
    if (parameter == 0.F) return send_all_modes(to, status, outbox);
    outbox.send(to, Telemetry{id, status, static_cast<int>(parameter)});
  } else {
    status.estimate.q_WB = continued(status.estimate.q_WB, q_shown_);
    outbox.send(to, Telemetry{id, status, 1, to.link});
  }
}

}  // namespace halfroll::link
