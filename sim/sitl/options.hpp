// The command line of halfroll-sitl.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "link/frames.hpp"
#include "link/signing.hpp"
#include "sim/scenario.hpp"

namespace halfroll::sitl {

struct Options {
  int instance = 0;
  std::string vehicle = "mit-vp";
  std::vector<std::string> settings;                       // "key=number", for vehicle_file
  std::vector<std::string> world_settings;                 // the same, of the world's vehicle alone
  std::string scenario_name = "nominal", scenario_called;  // called: in log and output; empty: by its name
  std::vector<std::string> scenario_settings;              // "key=number", for scenario_file
  sim::Scenario scenario;
  std::uint64_t seed = 0;
  bool lockstep = false;
  double speed = 1.0;  // times real time; 0 is as fast as it goes, the default in lockstep
  bool px4_identity = false;
  link::Origin origin{473977420, 85455940, 488000};
  std::string storage;                 // directory; empty: nothing outlives the process
  std::string log;                     // ULog file; empty: none
  std::string replay;                  // ULog file to fly again; empty: fly anew
  std::vector<std::string> arguments;  // that make the same vehicle in the same world
  std::string board, board_port;  // command of a board, or its serial port; empty: the firmware flies in this process
  bool board_beside = false;      // and in this process, too, to compare every bit
  std::uint16_t port_offboard = 0, peer_offboard = 0, port_gcs = 0, peer_gcs = 0;
  std::uint16_t port_companion = 0, peer_companion = 0;
  std::array<link::SigningPolicy, link::kLinkCount> signing = {};  // links A, B, C
  std::optional<link::SigningKey> signing_key;
  std::string bind = "127.0.0.1";
  std::optional<double> duration;  // [s] of vehicle time
  bool help = false, version = false;
};

/// Throws BadOption: one sentence that names option and value.
Options parse_options(const std::vector<std::string>& arguments);

std::string help_text();

}  // namespace halfroll::sitl
