// What must hold after every step holds after every step; and whoever looks for it sees when it does not.
#include <doctest/doctest.h>

#include <limits>
#include <string>

#include "../link/command_frame.hpp"
#include "sim/sitl/checked.hpp"
#include "sim/sitl/scenario_file.hpp"
#include "sim/sitl/sensed.hpp"
#include "sim/sitl/vehicle_file.hpp"
#include "sim/world.hpp"

namespace {

using namespace halfroll;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

using client::command;

/// A vehicle in its world; each step is checked, and ends the test with words if it breaks anything.
class Flight {
 public:
  Flight(const std::string& vehicle, const std::string& scenario)
      : setup_(sitl::make_vehicle(vehicle, {})),
        autopilot_(setup_.vehicle, setup_.params),
        model_(setup_.plant, sitl::make_scenario(scenario, {})),
        world_(sim::start(model_, 7)) {}

  template <class Spoil>
  void fly(int steps, const Spoil& spoil) {
    for (int n = 0; n < steps; ++n) {
      Inputs in = sitl::sensed(world_);
      spoil(in);
      step(in);
    }
  }
  void fly(int steps) {
    fly(steps, [](Inputs&) {});
  }
  void hear(const client::Bytes& bytes) {
    const link::Datagram datagram{{1, 0}, bytes.data(), bytes.size()};
    Inputs in = sitl::sensed(world_);
    in.link.rx = &datagram;
    in.link.rx_count = 1;
    step(in);
  }
  void take_off() {
    fly(3000);
    hear(command(MAV_CMD_NAV_TAKEOFF, 0.F, 5.F));
    hear(command(MAV_CMD_COMPONENT_ARM_DISARM, 1.F));
    fly(9000);
    REQUIRE(world_.body.p_WB.z() > 3.0);
  }
  const Autopilot& autopilot() const { return autopilot_; }

 private:
  void step(Inputs& in) {
    in.link.wall_us = world_.t_us;
    sim::step(model_, world_, sitl::checked_step(autopilot_, in).rotors);
  }

  sitl::VehicleSetup setup_;
  Autopilot autopilot_;
  sim::Model model_;
  sim::World world_;
};

}  // namespace

TEST_CASE("a flight in rough air with poor sensors breaks no invariant in any step") {
  for (const char* vehicle : {"mit-vp", "mit-fp", "race-5in"}) {
    CAPTURE(vehicle);
    Flight flight(vehicle, "windy");
    flight.take_off();
    flight.hear(command(MAV_CMD_NAV_LAND, 0.F));
    flight.fly(20000);
    CHECK(!flight.autopilot().armed());
  }
}

TEST_CASE("sensors that say no numbers break no invariant") {
  Flight flight("mit-vp", "ideal");
  flight.take_off();
  for (const float bad : {kNaN, std::numeric_limits<float>::infinity(), 3e38F, 1e-42F}) {
    CAPTURE(bad);
    Flight hurt = flight;
    hurt.fly(30, [&](Inputs& in) { in.measured.imu.w_WB_B.x() = bad; });
    hurt.fly(30, [&](Inputs& in) { in.measured.imu.specific_force_B.z() = bad; });
    hurt.fly(30, [&](Inputs& in) {
      if (in.measured.pose) in.measured.pose->p_WB.y() = bad;
    });
    hurt.fly(30, [&](Inputs& in) {
      if (in.measured.pose) in.measured.pose->q_WB.w = bad;
    });
    hurt.fly(30, [&](Inputs& in) { in.battery.state_of_charge = bad; });
    hurt.fly(500);
  }
}

TEST_CASE("what is broken is named") {
  const sitl::VehicleSetup setup = sitl::make_vehicle("mit-vp", {});
  const auto broken = [](const Vehicle& vehicle, const Params& params) {
    Autopilot autopilot(vehicle, params);
    Inputs in;
    in.measured.imu.specific_force_B = {0.F, 0.F, 9.81F};
    autopilot.step(in);
    const char* what = autopilot.broken_invariant();
    return std::string(what == nullptr ? "nothing" : what);
  };
  CHECK(broken(setup.vehicle, setup.params) == "nothing");
  for (const ParamInfo& info : kParamTable) {
    Params params = setup.params;
    params.*info.member = info.most + std::max(1.F, 1e-3F * std::abs(info.most));
    CHECK(broken(setup.vehicle, params) == info.id);
  }
}
