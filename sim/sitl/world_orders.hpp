// What a person does to the simulated world while it flies: a gust, a link cut. Why: asked for over MAVLink like all
// else, but of component 25, the world, which a real vehicle does not have.
//
//   USER_2 (31011)  gust: p1, p2, p3 velocity [m/s] in the wire's axes, p4 time to rise, p5 to hold [s]
//   USER_3 (31012)  cut: p1 link (0 A, 1 B, 2 C), p2 for how long [s] of vehicle time
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "link/codec.hpp"
#include "sim/model.hpp"

namespace halfroll::sitl {

inline constexpr std::uint8_t kWorldComponent = 25;

class WorldOrders {
 public:
  explicit WorldOrders(std::uint8_t system) : system_(system) {}

  /// Obeys what a datagram orders at t_us of vehicle time, and answers it.
  std::vector<link::TxFrame> hear(const link::Datagram& datagram, std::uint64_t t_us, sim::Model& model);
  /// Whether nothing passes a link, either way; all links at once never are.
  bool is_cut(std::uint8_t link, std::uint64_t t_us) const {
    return link < link::kLinkCount && t_us < cut_until_us_[link];
  }

 private:
  link::CommandResult obey(const link::Command& command, std::uint64_t t_us, sim::Model& model);
  link::CommandResult blow(const link::Command& command, std::uint64_t t_us, sim::Model& model);
  link::CommandResult cut(const link::Command& command, std::uint64_t t_us);

  std::uint8_t system_;
  std::uint8_t sequence_ = 0;
  std::size_t next_gust_ = 0;
  std::array<std::uint64_t, link::kLinkCount> cut_until_us_ = {};
  std::array<std::array<link::Parser, 9>, link::kLinkCount> parsers_ = {};
};

}  // namespace halfroll::sitl
