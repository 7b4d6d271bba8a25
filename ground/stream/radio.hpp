// The wire between ground and vehicle, one way. Why: a flight over a link that delays and loses must be as repeatable
// as any other: what happens to frame i is a function of the seed and i.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sim/random.hpp"

namespace halfroll::stream {

struct RadioSetup {
  double delay_s = 0.0;   // of every frame, in whole milliseconds
  double jitter_s = 0.0;  // up to so much more, uniform
  double loss = 0.0;      // share of frames that never arrive
};

template <class Frame>
class Radio {
 public:
  Radio(const RadioSetup& setup, sim::Random random, sim::Stream stream)
      : setup_(setup), random_(random), stream_(stream) {}

  void send(std::uint64_t t_us, const Frame& frame) {
    const auto [fate, late, unused1, unused2] = random_.uniforms(stream_, sent_++);
    if (fate < setup_.loss) return;
    const double delay_ms = std::round(1e3 * (setup_.delay_s + late * setup_.jitter_s));
    under_way_.push_back({t_us + 1000 * static_cast<std::uint64_t>(delay_ms), frame});
  }

  /// Calls use(frame) for what has arrived by t_us, in order of arrival.
  template <class Use>
  void deliver(std::uint64_t t_us, Use&& use) {
    while (!under_way_.empty()) {
      const auto first = std::min_element(under_way_.begin(), under_way_.end(),
                                          [](const auto& a, const auto& b) { return a.due_us < b.due_us; });
      if (first->due_us > t_us) return;
      const Frame frame = first->frame;
      under_way_.erase(first);
      use(frame);
    }
  }

 private:
  struct UnderWay {
    std::uint64_t due_us;
    Frame frame;
  };
  RadioSetup setup_;
  sim::Random random_;
  sim::Stream stream_;
  std::uint64_t sent_ = 0;
  std::vector<UnderWay> under_way_;
};

}  // namespace halfroll::stream
