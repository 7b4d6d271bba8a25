#include "sim/sitl/world_orders.hpp"

#include <cmath>

#include "link/frames.hpp"

namespace halfroll::sitl {
namespace {

constexpr std::uint16_t kGust = 31011, kCut = 31012;  // MAV_CMD_USER_2, USER_3
constexpr float kStrongest = 50.F, kLongestS = 1000.F;
constexpr float kRiseS = 0.3F;

bool between(float x, float least, float most) { return x >= least && x <= most; }  // NaN is not

}  // namespace

/// Link A carries the references, and its bytes are the autopilot's alone: no order is worth parsing them twice.
std::vector<link::TxFrame> WorldOrders::hear(const link::Datagram& datagram, std::uint64_t t_us, sim::Model& model) {
  std::vector<link::TxFrame> answers;
  const link::Endpoint from = datagram.from;
  if (from.link == 0 || from.link >= link::kLinkCount || from.slot >= parsers_[0].size()) return answers;
  parsers_[from.link][from.slot].parse(datagram, [&](const link::Received& received) {
    const auto* command = std::get_if<link::Command>(&received.message);
    const link::Address& target = received.header.target;
    if (command == nullptr || target.system != system_ || target.component != kWorldComponent) return;
    const link::CommandAck ack{received.header.sender, command->command, obey(*command, t_us, model)};
    answers.push_back(link::encode(ack, {system_, sequence_++, kWorldComponent}));
    answers.back().to = from;
  });
  return answers;
}

link::CommandResult WorldOrders::obey(const link::Command& command, std::uint64_t t_us, sim::Model& model) {
  if (command.is_int) return link::CommandResult::kUnsupported;
  if (command.command == kGust) return blow(command, t_us, model);
  if (command.command == kCut) return cut(command, t_us);
  return link::CommandResult::kUnsupported;
}

/// The oldest of the scenario's gusts gives way. Air that pushes nothing blows for nobody.
link::CommandResult WorldOrders::blow(const link::Command& command, std::uint64_t t_us, sim::Model& model) {
  const auto& p = command.p;
  const Vec3 velocity = link::from_wire(Vec3(p[0], p[1], p[2]));
  const float rise_s = p[3] == 0.F ? kRiseS : p[3];
  const bool fits = velocity.norm() <= kStrongest && between(rise_s, 1e-3F, kLongestS) && between(p[4], 0.F, kLongestS);
  if (!fits || !model.scenario.effects.drag) return link::CommandResult::kDenied;
  sim::WindSetup& wind = model.scenario.wind;
  wind.gusts[next_gust_] = {1e-6 * static_cast<double>(t_us), static_cast<double>(rise_s), static_cast<double>(p[4]),
                            velocity.cast<double>()};
  next_gust_ = (next_gust_ + 1) % wind.gusts.size();
  model.wind = sim::WindModel(wind);
  return link::CommandResult::kAccepted;
}

link::CommandResult WorldOrders::cut(const link::Command& command, std::uint64_t t_us) {
  const float index = command.p[0], seconds = command.p[1];
  if (!between(index, 0.F, static_cast<float>(link::kLinkCount - 1)) || index != std::floor(index) ||
      !between(seconds, 0.F, kLongestS)) {
    return link::CommandResult::kDenied;
  }
  cut_until_us_[static_cast<std::size_t>(index)] = t_us + static_cast<std::uint64_t>(1e6F * seconds);
  return link::CommandResult::kAccepted;
}

}  // namespace halfroll::sitl
