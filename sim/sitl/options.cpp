#include "sim/sitl/options.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <functional>

#include "sim/sitl/numbers.hpp"
#include "sim/sitl/scenario_file.hpp"

namespace halfroll::sitl {
namespace {

constexpr int kPortsByInstance = 9;  // 14540 + 10 would be the GCS's port

struct Given {  // what has defaults that depend on other options
  std::optional<double> speed;
  std::optional<std::uint16_t> port_offboard, peer_offboard, port_gcs, peer_gcs, port_companion, peer_companion;
};

struct Row {
  const char* name;
  const char* argument;  // nullptr: a switch
  const char* meaning;
  std::function<void(Options&, Given&, const std::string&)> take;
};

std::uint64_t whole(const std::string& what, const std::string& text, double most) {
  const double x = number(what, text, 0.0, most);
  const auto n = static_cast<std::uint64_t>(x);
  if (static_cast<double>(n) != x) throw BadOption(what + " '" + text + "' is not a whole number");
  return n;
}

std::uint16_t port(const std::string& what, const std::string& text) {
  const std::uint64_t n = whole(what, text, 65535);
  if (n == 0) throw BadOption(what + " 0 is not a UDP port");
  return static_cast<std::uint16_t>(n);
}

std::uint64_t seed_of(const std::string& text) {
  if (text.empty() || text.size() > 19) throw BadOption("--seed '" + text + "' is not a whole number below 1e19");
  std::uint64_t n = 0;
  for (const char c : text) {
    if (std::isdigit(static_cast<unsigned char>(c)) == 0)
      throw BadOption("--seed '" + text + "' is not a whole number");
    n = 10 * n + static_cast<std::uint64_t>(c - '0');
  }
  return n;
}

void take_origin(Options& o, const std::string& text) {
  const std::size_t first = text.find(','), second = text.find(',', first + 1);
  if (first == std::string::npos || second == std::string::npos) {
    throw BadOption("--origin " + text + ": write latitude,longitude,altitude in degrees and metres");
  }
  const auto scaled = [](double x, double factor) { return static_cast<std::int32_t>(std::nearbyint(x * factor)); };
  const double latitude = number("--origin latitude", text.substr(0, first), -89.9, 89.9);
  const double longitude = number("--origin longitude", text.substr(first + 1, second - first - 1), -180, 180);
  const double altitude = number("--origin altitude", text.substr(second + 1), -500, 9000);
  o.origin = link::Origin(scaled(latitude, 1e7), scaled(longitude, 1e7), scaled(altitude, 1e3));
}

void take_identity(Options& o, const std::string& name) {
  if (name != "px4" && name != "generic") throw BadOption("--identity " + name + ": write px4 or generic");
  o.px4_identity = name == "px4";
}

void take_signing(Options& o, const std::string& text) {
  constexpr std::array<const char*, 4> kPolicies = {"off", "require", "accept", "trusted"};
  std::string rest = text;
  for (link::SigningPolicy& policy : o.signing) {
    const std::string word = rest.substr(0, rest.find(','));
    const auto* found = std::find(kPolicies.begin(), kPolicies.end(), word);
    if (found == kPolicies.end()) {
      throw BadOption("--signing " + text + ": write off, require, accept or trusted, for all links or as A,B,C");
    }
    policy = static_cast<link::SigningPolicy>(found - kPolicies.begin());
    if (rest.size() > word.size()) rest = rest.substr(word.size() + 1);
  }
}

void take_signing_key(Options& o, const std::string& path) {
  link::SigningKey key{};
  struct stat state = {};
  if (::stat(path.c_str(), &state) == 0 && (state.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    throw BadOption("--signing-key " + path +
                    ": others may use the file, whoever has the key flies the vehicle: chmod 600 " + path);
  }
  std::ifstream file(path);
  std::string digits;
  file.width(2 * key.size() + 1);  // and not whatever has no end
  if (!(file >> digits)) throw BadOption("--signing-key " + path + " cannot be read or is empty");
  if (digits.size() != 2 * key.size() || digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) {
    throw BadOption("--signing-key " + path + ": the key is 64 hexadecimal digits");
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(std::stoi(digits.substr(2 * i, 2), nullptr, 16));
  }
  o.signing_key = key;
}

void check_signing(const Options& o) {
  for (const link::SigningPolicy policy : o.signing) {
    if (policy == link::SigningPolicy::kRequire && !o.signing_key) {
      throw BadOption("--signing require needs a key: --signing-key FILE");
    }
  }
}

const std::vector<Row>& rows() {
  using S = const std::string&;
  static const std::vector<Row> table = {
      {"instance", "N", "adds N to system id and ports (0)",
       [](Options& o, Given&, S s) { o.instance = static_cast<int>(whole("--instance", s, 249)); }},
      {"vehicle", "NAME", "shipped vehicle (mit-vp)", [](Options& o, Given&, S s) { o.vehicle = s; }},
      {"set", "KEY=NUMBER", "replace a number of the vehicle, or params.NAME; repeatable",
       [](Options& o, Given&, S s) { o.settings.push_back(s); }},
      {"scenario", "NAME", "shipped scenario: air, sensors, faults (nominal)",
       [](Options& o, Given&, S s) { o.scenario_name = s; }},
      {"scenario-set", "KEY=NUMBER", "replace a number of the scenario; repeatable",
       [](Options& o, Given&, S s) { o.scenario_settings.push_back(s); }},
      {"scenario-called", "NAME", "what log and output call it (its name)",
       [](Options& o, Given&, S s) { o.scenario_called = s; }},
      {"seed", "S", "of everything random (0)", [](Options& o, Given&, S s) { o.seed = seed_of(s); }},
      {"lockstep", nullptr, "every 10 ms wait for the ground station's TIMESYNC",
       [](Options& o, Given&, S) { o.lockstep = true; }},
      {"speed", "X", "times real time, 0 as fast as it goes (1; 0 in lockstep)",
       [](Options&, Given& g, S s) { g.speed = number("--speed", s, 0, 1000); }},
      {"identity", "NAME", "px4 or generic: autopilot type in the heartbeat (generic)",
       [](Options& o, Given&, S s) { take_identity(o, s); }},
      {"origin", "LAT,LON,ALT", "local origin, degrees and metres (47.397742,8.545594,488)",
       [](Options& o, Given&, S s) { take_origin(o, s); }},
      {"storage", "DIR", "keep parameters and mission here (nowhere)", [](Options& o, Given&, S s) { o.storage = s; }},
      {"signing", "POLICY", "of links A,B,C: off, require, accept, trusted (off)",
       [](Options& o, Given&, S s) { take_signing(o, s); }},
      {"signing-key", "FILE", "key for --signing, 64 hexadecimal digits (none)",
       [](Options& o, Given&, S s) { take_signing_key(o, s); }},
      {"log", "FILE.ulg", "write truth, estimate, references and rotor commands (none)",
       [](Options& o, Given&, S s) { o.log = s; }},
      {"board", "COMMAND", "fly the firmware of a board: a program that speaks by its standard input and output",
       [](Options& o, Given&, S s) { o.board = s; }},
      {"board-port", "DEVICE:BAUD", "fly the firmware of a board at a serial port",
       [](Options& o, Given&, S s) { o.board_port = s; }},
      {"board-beside", nullptr, "fly it in this process, too, and count the bits that differ",
       [](Options& o, Given&, S) { o.board_beside = true; }},
      {"port-offboard", "PORT", "our port of the offboard link (14580 + N)",
       [](Options&, Given& g, S s) { g.port_offboard = port("--port-offboard", s); }},
      {"peer-offboard", "PORT", "its default peer (14540 + N)",
       [](Options&, Given& g, S s) { g.peer_offboard = port("--peer-offboard", s); }},
      {"port-gcs", "PORT", "our port of the GCS link (18570 + N)",
       [](Options&, Given& g, S s) { g.port_gcs = port("--port-gcs", s); }},
      {"peer-gcs", "PORT", "its default peer (14550 + N)",
       [](Options&, Given& g, S s) { g.peer_gcs = port("--peer-gcs", s); }},
      {"port-companion", "PORT", "our port of the companion link (14280 + N)",
       [](Options&, Given& g, S s) { g.port_companion = port("--port-companion", s); }},
      {"peer-companion", "PORT", "its default peer (14030 + N)",
       [](Options&, Given& g, S s) { g.peer_companion = port("--peer-companion", s); }},
      {"bind", "ADDRESS", "listen here (127.0.0.1)", [](Options& o, Given&, S s) { o.bind = s; }},
      {"duration", "S", "stop after so many seconds of vehicle time (never)",
       [](Options& o, Given&, S s) { o.duration = number("--duration", s, 0, 1e9); }},
      {"help", nullptr, "this text", [](Options& o, Given&, S) { o.help = true; }},
      {"version", nullptr, "name and version", [](Options& o, Given&, S) { o.version = true; }},
  };
  return table;
}

const Row& find_row(const std::string& name) {
  for (const Row& row : rows()) {
    if (name == row.name) return row;
  }
  throw BadOption("--" + name + ": no such option; --help lists them");
}

void settle_ports(Options& o, const Given& g) {
  const bool all_given =
      g.port_offboard && g.peer_offboard && g.port_gcs && g.peer_gcs && g.port_companion && g.peer_companion;
  if (o.instance > kPortsByInstance && !all_given) {
    throw BadOption("--instance " + std::to_string(o.instance) +
                    " is above 9: give --port-NAME and --peer-NAME of offboard, gcs and companion yourself");
  }
  const auto shifted = [&](int port0) { return static_cast<std::uint16_t>(port0 + o.instance); };
  o.port_offboard = g.port_offboard.value_or(shifted(14580));
  o.peer_offboard = g.peer_offboard.value_or(shifted(14540));
  o.port_gcs = g.port_gcs.value_or(shifted(18570));
  o.peer_gcs = g.peer_gcs.value_or(shifted(14550));
  o.port_companion = g.port_companion.value_or(shifted(14280));  // PX4's second onboard link
  o.peer_companion = g.peer_companion.value_or(shifted(14030));
}

}  // namespace

Options parse_options(const std::vector<std::string>& arguments) {
  Options options;
  Given given;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "-h") {
      options.help = true;
      continue;
    }
    if (word.rfind("--", 0) != 0) throw BadOption("'" + word + "' is not an option; --help lists them");
    const std::size_t equals = word.find('=');
    const Row& row = find_row(word.substr(2, equals == std::string::npos ? equals : equals - 2));
    if (row.argument == nullptr) {
      if (equals != std::string::npos) throw BadOption("--" + std::string(row.name) + " takes no value");
      row.take(options, given, "");
    } else if (equals != std::string::npos) {
      row.take(options, given, word.substr(equals + 1));
    } else if (i + 1 < arguments.size()) {
      row.take(options, given, arguments[++i]);
    } else {
      throw BadOption(word + " needs a value: " + word + " " + row.argument);
    }
  }
  options.scenario = make_scenario(options.scenario_name, options.scenario_settings);
  if (options.scenario_called.empty()) options.scenario_called = options.scenario_name;
  options.speed = given.speed.value_or(options.lockstep ? 0.0 : 1.0);
  settle_ports(options, given);
  check_signing(options);
  return options;
}

std::string help_text() {
  std::string text =
      "halfroll-sitl [options]\n"
      "The autopilot and a simulated vehicle, reachable over MAVLink/UDP.\n\n";
  for (const Row& row : rows()) {
    std::string left = "  --" + std::string(row.name) + (row.argument ? " " + std::string(row.argument) : "");
    left.resize(left.size() < 24 ? 24 : left.size() + 1, ' ');
    text += left + row.meaning + "\n";
  }
  return text + "\nExit code: 0 done, 2 bad option, 3 port in use, or the board is lost.\n";
}

}  // namespace halfroll::sitl
