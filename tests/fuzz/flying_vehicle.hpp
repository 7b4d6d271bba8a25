// A closed loop in which anybody may say anything. Copied for each input, so that all begin alike.
#pragma once
#include <memory>

#include "frames.hpp"
#include "sim/sitl/checked.hpp"
#include "sim/sitl/scenario_file.hpp"
#include "sim/sitl/sensed.hpp"
#include "sim/sitl/vehicle_file.hpp"
#include "sim/world.hpp"

namespace halfroll::fuzz {

using sitl::fail;

class FlyingVehicle {
 public:
  explicit FlyingVehicle(const Boot& boot = {})
      : setup_(sitl::make_vehicle("mit-vp", {})), autopilot_(setup_.vehicle, setup_.params, boot) {
    model_ = std::make_shared<const sim::Model>(setup_.plant, sitl::make_scenario("ideal"));
    world_ = sim::start(*model_, 1);
  }

  /// A millisecond in which these bytes came.
  void step(const Bytes& bytes = {}, link::Endpoint from = {1, 0}) {
    const link::Datagram datagram{from, bytes.data(), bytes.size()};
    Inputs in = sitl::sensed(world_);
    in.link.rx = &datagram;
    in.link.rx_count = bytes.empty() ? 0 : 1;
    in.link.wall_us = world_.t_us;
    in.link.stored = stored_;
    const Outputs out = sitl::checked_step(autopilot_, in);
    stored_ = {out.link.store.slot, true};
    sim::step(*model_, world_, out.rotors);
  }
  void fly(int steps) {
    for (int n = 0; n < steps; ++n) step();
  }

  /// From the ground to hover at this height [m].
  void take_off(float height = 10.F) {
    step(command(MAV_CMD_NAV_TAKEOFF, 0.F, 0.F, height));
    step(command(MAV_CMD_COMPONENT_ARM_DISARM, 1.F));
    fly(12000);
    if (autopilot_.mode() != Mode::kHold) fail("the hovering vehicle does not hover", 0);
  }

  const Autopilot& autopilot() const { return autopilot_; }
  const sim::World& world() const { return world_; }

 private:
  sitl::VehicleSetup setup_;
  Autopilot autopilot_;
  std::shared_ptr<const sim::Model> model_;
  sim::World world_;
  link::StorageResult stored_;
};

}  // namespace halfroll::fuzz
