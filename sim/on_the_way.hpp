// Samples between exposure and delivery. Why: what a tracking system or a receiver says is already old when it arrives,
// never out of order.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace halfroll::sim {

template <typename Sample, std::size_t kMost>
struct OnTheWay {
  std::array<Sample, kMost> samples = {};  // ring
  std::array<std::uint64_t, kMost> due_us = {};
  std::size_t sent = 0, delivered = 0;

  /// The oldest is lost if more than kMost are on the way.
  void send(const Sample& sample, std::uint64_t due) {
    if (sent - delivered == kMost) ++delivered;
    samples[sent % kMost] = sample;
    due_us[sent % kMost] = due;
    ++sent;
  }

  /// At most one a millisecond.
  std::optional<Sample> deliver(std::uint64_t t_us) {
    if (delivered == sent || t_us < due_us[delivered % kMost]) return std::nullopt;
    return samples[delivered++ % kMost];
  }

  void clear() { delivered = sent; }
};

}  // namespace halfroll::sim
