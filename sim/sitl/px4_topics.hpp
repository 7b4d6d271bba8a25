// The topics of a flight log that PX4 has, too: its names, fields, units and axes. Why: Flight Review and PlotJuggler
// layouts know them. Body axes forward-right-down, world north-east-down; thrusts as shares of the largest.
#pragma once
#include "link/frames.hpp"
#include "sim/plant.hpp"
#include "sim/sitl/ulog.hpp"

namespace halfroll::sitl {

struct FlightRecord;

class Px4Topics {
 public:
  /// Tells `ulog` the topics. thrust_reference [N]: of full thrust, VEH_T_REF.
  Px4Topics(Ulog& ulog, const sim::Plant& plant, const link::Origin& origin, float thrust_reference, int system_id);

  /// Each topic when it is due, at its own rate.
  void add(Ulog& ulog, const FlightRecord& record);

 private:
  void add_attitude(Ulog& ulog, const FlightRecord& record) const;
  void add_position(Ulog& ulog, const FlightRecord& record) const;
  void add_battery(Ulog& ulog, const FlightRecord& record);
  void add_status(Ulog& ulog, const FlightRecord& record);

  link::Origin origin_;
  float thrust_max_, thrust_reference_;
  bool reversible_;
  double capacity_Ah_;
  std::uint8_t system_id_;
  Ulog::Topic attitude_, rates_, attitude_truth_, rates_truth_, attitude_setpoint_, rates_setpoint_, sensors_, motors_;
  Ulog::Topic position_, position_truth_, global_, outputs_, battery_, status_;
  int last_mode_ = -1, last_armed_ = -1;
  std::uint64_t armed_us_ = 0;
};

}  // namespace halfroll::sitl
