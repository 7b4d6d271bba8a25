// Orders to the simulated world, as frames of a client.
#include <limits>

#include "sim/sitl/scenario_file.hpp"
#include "sim/sitl/vehicle_file.hpp"
#include "sim/sitl/world_orders.hpp"
#include "sim/world.hpp"
#include "tests/cpp/link/client.hpp"

using namespace halfroll;
using sitl::WorldOrders;

namespace {

constexpr std::uint16_t kGust = 31011, kCut = 31012;
constexpr std::uint8_t kGcsLink = 1;
constexpr std::uint64_t kNowUs = 2000000;

sim::Model model_in(const char* scenario) {
  return {sitl::make_vehicle("mit-vp", {}).plant, sitl::make_scenario(scenario, {})};
}

client::Bytes command(std::uint16_t number, std::array<float, 5> p, std::uint8_t component = sitl::kWorldComponent) {
  mavlink_command_long_t m = {};
  m.command = number;
  m.target_system = 1;
  m.target_component = component;
  m.param1 = p[0], m.param2 = p[1], m.param3 = p[2], m.param4 = p[3], m.param5 = p[4];
  return client::frame(m, mavlink_msg_command_long_encode_status);
}

/// Results of the acknowledgements; sent by the world.
std::vector<int> answers(WorldOrders& orders, const client::Bytes& bytes, sim::Model& model,
                         std::uint8_t link = kGcsLink, std::uint64_t t_us = kNowUs) {
  std::vector<int> results;
  for (const link::TxFrame& frame : orders.hear({{link, 3}, bytes.data(), bytes.size()}, t_us, model)) {
    CHECK(frame.to == link::Endpoint{link, 3});
    CHECK(client::read(frame).compid == sitl::kWorldComponent);
    results.push_back(client::read<mavlink_command_ack_t>(frame, mavlink_msg_command_ack_decode).result);
  }
  return results;
}

const std::vector<int> kAccepted{MAV_RESULT_ACCEPTED}, kDenied{MAV_RESULT_DENIED}, kUnsupported{MAV_RESULT_UNSUPPORTED},
    kNoAnswer{};

sim::Vec3d wind_after(const sim::Model& model, sim::World world, int milliseconds) {
  for (int i = 0; i < milliseconds; ++i) sim::step(model, world, {});
  return world.wind.velocity_W;
}

}  // namespace

TEST_CASE("an ordered gust blows from when it was ordered, and passes") {
  sim::Model model = model_in("nominal");
  WorldOrders orders(1);
  CHECK(answers(orders, command(kGust, {3.F, 4.F, -1.F, 0.1F, 0.2F}), model, kGcsLink, 0) == kAccepted);
  const sim::World world = sim::start(model, 7);
  const sim::Vec3d full = wind_after(model, world, 200);
  CHECK(full.x() == doctest::Approx(3.0));
  CHECK(full.y() == doctest::Approx(-4.0));  // the wire's second axis points the other way
  CHECK(full.z() == doctest::Approx(1.0));
  CHECK(wind_after(model, world, 50).norm() == doctest::Approx(0.5 * full.norm()).epsilon(0.01));
  CHECK(wind_after(model, world, 401).norm() == doctest::Approx(0.0));
}

TEST_CASE("a gust that nobody could mean, or that pushes nothing, is denied") {
  sim::Model still = model_in("ideal"), model = model_in("nominal");
  WorldOrders orders(1);
  CHECK(answers(orders, command(kGust, {3.F, 0.F, 0.F, 0.1F, 1.F}), still) == kDenied);
  CHECK(answers(orders, command(kGust, {60.F, 0.F, 0.F, 0.1F, 1.F}), model) == kDenied);
  CHECK(answers(orders, command(kGust, {3.F, 0.F, 0.F, -1.F, 1.F}), model) == kDenied);
  CHECK(answers(orders, command(kGust, {std::numeric_limits<float>::quiet_NaN(), 0.F, 0.F, 0.1F, 1.F}), model) ==
        kDenied);
  CHECK_FALSE(model.wind.blows());
}

TEST_CASE("a link is cut for as long as was ordered, and only that one") {
  sim::Model model = model_in("nominal");
  WorldOrders orders(1);
  CHECK(answers(orders, command(kCut, {0.F, 1.5F}), model) == kAccepted);
  CHECK(orders.is_cut(0, kNowUs));
  CHECK(orders.is_cut(0, kNowUs + 1499999));
  CHECK_FALSE(orders.is_cut(0, kNowUs + 1500000));
  CHECK_FALSE(orders.is_cut(1, kNowUs));
  CHECK_FALSE(orders.is_cut(link::kAllLinks, kNowUs));
  for (const float nonsense : {-1.F, 0.5F, 3.F}) {
    CHECK(answers(orders, command(kCut, {nonsense, 1.F}), model) == kDenied);
  }
}

TEST_CASE("the world leaves the autopilot's commands, and what it does not know, alone") {
  sim::Model model = model_in("nominal");
  WorldOrders orders(1);
  CHECK(answers(orders, command(kGust, {3.F, 0.F, 0.F, 0.1F, 1.F}, 1), model) == kNoAnswer);
  CHECK(answers(orders, command(kGust, {3.F, 0.F, 0.F, 0.1F, 1.F}, 0), model) == kNoAnswer);
  CHECK(answers(orders, command(400, {1.F}), model) == kUnsupported);
  CHECK(answers(orders, command(kGust, {3.F, 0.F, 0.F, 0.1F, 1.F}), model, 0) == kNoAnswer);  // link A is not parsed
  CHECK_FALSE(model.wind.blows());
}
