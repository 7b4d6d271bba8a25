#include "sim/sitl/scenario_file.hpp"

#include <cmath>
#include <map>

#include "sim/sitl/numbers.hpp"

namespace halfroll::sitl {
namespace {

using Numbers = std::vector<std::pair<std::string, double>>;
using sim::Fault;
using sim::Scenario;

const std::map<std::string, Numbers>& shipped() {
#define SCENARIO(name, ...) {name, {__VA_ARGS__}},
  static const std::map<std::string, Numbers> scenarios = {
#include "scenarios/shipped_scenarios.inc"
  };
#undef SCENARIO
  return scenarios;
}

/// A key, what it may be, and where it goes. The last column is given the scenario and the n of "key.n".
struct Row {
  std::string key;
  double least, most;
  void (*put)(Scenario&, std::size_t, double);
};

std::uint64_t microseconds(double seconds) { return static_cast<std::uint64_t>(std::llround(1e6 * seconds)); }

/// Whole milliseconds, since sensors are read once in each; 0 Hz is never.
std::uint64_t period_us(double rate_hz) {
  return rate_hz > 0.0 ? 1000 * static_cast<std::uint64_t>(std::llround(1e3 / rate_hz)) : 0;
}

std::size_t axis(std::size_t n) { return n % 3; }

void add_inertial(std::vector<Row>& rows, const std::string& sensor, const std::string& unit,
                  const std::string& unit_walk, std::array<void (*)(Scenario&, std::size_t, double), 6> put) {
  const std::array<std::string, 6> keys = {"noise_" + unit, "bias_" + unit, "bias_walk_" + unit_walk,
                                           "range_" + unit, "step_" + unit, "vibration_" + unit};
  for (std::size_t i = 0; i < keys.size(); ++i) rows.push_back({sensor + "." + keys[i], 0.0, 1000.0, put[i]});
}

std::vector<Row> make_rows() {
  using N = std::size_t;
  using S = Scenario&;
  std::vector<Row> rows = {
      {"effects.drag", 0, 1, [](S s, N, double x) { s.effects.drag = x != 0.0; }},
      {"effects.rotor_drag", 0, 1, [](S s, N, double x) { s.effects.rotor_drag = x != 0.0; }},
      {"effects.inflow", 0, 1, [](S s, N, double x) { s.effects.inflow = x != 0.0; }},
      {"effects.gyroscopic", 0, 1, [](S s, N, double x) { s.effects.gyroscopic = x != 0.0; }},
      {"effects.ground_effect", 0, 1, [](S s, N, double x) { s.effects.ground_effect = x != 0.0; }},
      {"effects.governor", 0, 1, [](S s, N, double x) { s.effects.governor = x != 0.0; }},
      {"effects.stiction", 0, 1, [](S s, N, double x) { s.effects.stiction = x != 0.0; }},
      {"effects.battery", 0, 1, [](S s, N, double x) { s.effects.battery = x != 0.0; }},
      {"effects.physical_torque", 0, 1, [](S s, N, double x) { s.effects.physical_torque = x != 0.0; }},
      {"payload.mass_kg", 0, 100, [](S s, N, double x) { s.payload.mass = x; }},
      {"payload.position_m.N", -10, 10, [](S s, N n, double x) { s.payload.position[int(axis(n))] = x; }},
      {"wind.mean_m_s.N", -50, 50, [](S s, N n, double x) { s.wind.mean[int(axis(n))] = x; }},
      {"wind.turbulence_m_s.N", 0, 50, [](S s, N n, double x) { s.wind.intensity[int(axis(n))] = x; }},
      {"wind.turbulence_length_m.N", 0.1, 10000, [](S s, N n, double x) { s.wind.length[int(axis(n))] = x; }},
      {"wind.turbulence_speed_m_s", 0, 100, [](S s, N, double x) { s.wind.speed = x; }},
      {"wind.gust.N.at_s", 0, 1e6, [](S s, N n, double x) { s.wind.gusts[n].at_s = x; }},
      {"wind.gust.N.rise_s", 0.001, 1000, [](S s, N n, double x) { s.wind.gusts[n].rise_s = x; }},
      {"wind.gust.N.hold_s", 0, 1e6, [](S s, N n, double x) { s.wind.gusts[n].hold_s = x; }},
      {"wind.gust.N.velocity_m_s.0", -50, 50, [](S s, N n, double x) { s.wind.gusts[n].velocity.x() = x; }},
      {"wind.gust.N.velocity_m_s.1", -50, 50, [](S s, N n, double x) { s.wind.gusts[n].velocity.y() = x; }},
      {"wind.gust.N.velocity_m_s.2", -50, 50, [](S s, N n, double x) { s.wind.gusts[n].velocity.z() = x; }},
      {"mocap.rate_hz", 0, 1000, [](S s, N, double x) { s.mocap.period_us = period_us(x); }},
      {"mocap.delay_s", 0, 0.1, [](S s, N, double x) { s.mocap.delay_us = microseconds(x); }},
      {"mocap.jitter_s", 0, 0.1, [](S s, N, double x) { s.mocap.jitter_us = microseconds(x); }},
      {"mocap.position_noise_m", 0, 100, [](S s, N, double x) { s.mocap.position_noise = x; }},
      {"mocap.attitude_noise_deg", 0, 30, [](S s, N, double x) { s.mocap.attitude_noise = x * sim::kDegree; }},
      {"mocap.attitude_wander_deg", 0, 30, [](S s, N, double x) { s.mocap.attitude_wander = x * sim::kDegree; }},
      {"mocap.wander_time_s", 0.01, 1e4, [](S s, N, double x) { s.mocap.wander_time = x; }},
      {"mocap.dropout", 0, 1, [](S s, N, double x) { s.mocap.dropout = x; }},
      {"mocap.outlier", 0, 1, [](S s, N, double x) { s.mocap.outlier = x; }},
      {"mocap.outlier_size", 0, 100, [](S s, N, double x) { s.mocap.outlier_size = x; }},
      {"gps.rate_hz", 0, 50, [](S s, N, double x) { s.gps.period_us = period_us(x); }},
      {"gps.delay_s", 0, 0.2, [](S s, N, double x) { s.gps.delay_us = microseconds(x); }},
      {"gps.noise_xy_m", 0, 100, [](S s, N, double x) { s.gps.noise_xy = x; }},
      {"gps.noise_z_m", 0, 100, [](S s, N, double x) { s.gps.noise_z = x; }},
      {"gps.wander_xy_m", 0, 100, [](S s, N, double x) { s.gps.wander_xy = x; }},
      {"gps.wander_z_m", 0, 100, [](S s, N, double x) { s.gps.wander_z = x; }},
      {"gps.wander_time_s", 0.1, 1e5, [](S s, N, double x) { s.gps.wander_time = x; }},
      {"gps.velocity_noise_m_s", 0, 100, [](S s, N, double x) { s.gps.velocity_noise = x; }},
      {"barometer.rate_hz", 0, 1000, [](S s, N, double x) { s.barometer.period_us = period_us(x); }},
      {"barometer.noise_m", 0, 100, [](S s, N, double x) { s.barometer.noise = x; }},
      {"barometer.drift_m_s", 0, 100, [](S s, N, double x) { s.barometer.drift = x; }},
      {"magnetometer.rate_hz", 0, 1000, [](S s, N, double x) { s.magnetometer.period_us = period_us(x); }},
      {"magnetometer.noise", 0, 1, [](S s, N, double x) { s.magnetometer.noise = x; }},
      {"magnetometer.bias", 0, 1, [](S s, N, double x) { s.magnetometer.bias = x; }},
      {"fault.N.kind", 1, 6, [](S s, N n, double x) { s.faults[n].kind = static_cast<Fault::Kind>(int(x)); }},
      {"fault.N.at_s", 0, 1e6, [](S s, N n, double x) { s.faults[n].at_s = x; }},
      {"fault.N.until_s", 0, 1e6, [](S s, N n, double x) { s.faults[n].until_s = x; }},
      {"fault.N.rotor", 1, 4, [](S s, N n, double x) { s.faults[n].rotor = static_cast<N>(x) - 1; }},
      {"fault.N.share", 0, 2, [](S s, N n, double x) { s.faults[n].share = x; }},
  };
  add_inertial(rows, "gyro", "rad_s", "rad_s2",
               {[](S s, N, double x) { s.gyro.noise = x; }, [](S s, N, double x) { s.gyro.bias = x; },
                [](S s, N, double x) { s.gyro.bias_walk = x; }, [](S s, N, double x) { s.gyro.range = x; },
                [](S s, N, double x) { s.gyro.step = x; }, [](S s, N, double x) { s.gyro.vibration = x; }});
  add_inertial(
      rows, "accelerometer", "m_s2", "m_s3",
      {[](S s, N, double x) { s.accelerometer.noise = x; }, [](S s, N, double x) { s.accelerometer.bias = x; },
       [](S s, N, double x) { s.accelerometer.bias_walk = x; }, [](S s, N, double x) { s.accelerometer.range = x; },
       [](S s, N, double x) { s.accelerometer.step = x; }, [](S s, N, double x) { s.accelerometer.vibration = x; }});
  return rows;
}

const std::vector<Row>& rows() {
  static const std::vector<Row> table = make_rows();
  return table;
}

struct Found {
  const Row* row;
  std::size_t n = 0;
};

/// The row of a key; a number in the key stands where the row has N, unless a row has that very number there.
Found find(const std::string& what, const std::string& key) {
  for (const Row& row : rows()) {
    const std::size_t hole = row.key.find(".N");
    if (hole == std::string::npos) {
      if (row.key == key) return {&row};
      continue;
    }
    const std::string before = row.key.substr(0, hole + 1), after = row.key.substr(hole + 2);
    if (key.size() != row.key.size() || key.compare(0, before.size(), before) != 0) continue;
    const char digit = key[hole + 1];
    const std::size_t most = before == "fault."       ? Scenario::kFaults
                             : before == "wind.gust." ? sim::WindSetup::kGusts
                                                      : 3;
    if (digit < '0' || digit > '9' || key.compare(hole + 2, std::string::npos, after) != 0) continue;
    const auto n = static_cast<std::size_t>(digit - '0');
    if (n >= most) throw BadOption(what + ": there are " + std::to_string(most) + ", counted from 0");
    return {&row, n};
  }
  std::string keys;
  for (const Row& row : rows()) keys += (keys.empty() ? "" : ", ") + row.key;
  throw BadOption(what + ": no such key; there are " + keys);
}

double number_or_kind(const std::string& what, const Row& row, const std::string& text) {
  if (row.key == "fault.N.kind") {
    const char* const kinds[] = {"weak-rotor", "stuck-rotor", "dead-rotor", "mocap-lost", "mocap-frozen", "gps-lost"};
    for (int i = 0; i < 6; ++i) {
      if (text == kinds[i]) return i + 1;
    }
  }
  return number(what, text, row.least, row.most);
}

void check(const std::string& name, const Scenario& scenario) {
  if (scenario.mocap.period_us > 0 &&
      scenario.mocap.delay_us + scenario.mocap.jitter_us > 16 * scenario.mocap.period_us) {
    throw BadOption("scenario " + name + ": mocap.delay_s and jitter_s are more than 16 periods");
  }
  for (const Fault& fault : scenario.faults) {
    if (fault.kind != Fault::Kind::kNone && fault.until_s <= fault.at_s) {
      throw BadOption("scenario " + name + ": a fault must end after it begins, until_s " + shown(fault.until_s) +
                      " is not after at_s " + shown(fault.at_s));
    }
  }
}

}  // namespace

Scenario make_scenario(const std::string& name, const std::vector<std::string>& settings) {
  const auto found = shipped().find(name);
  if (found == shipped().end()) {
    throw BadOption("--scenario " + name + ": no such scenario; there are " + shipped_scenarios());
  }
  Scenario scenario;
  for (const auto& [key, x] : found->second) {
    const Found at = find("scenario " + name + ", " + key, key);
    at.row->put(scenario, at.n, x);
  }
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) throw BadOption("--scenario-set " + setting + ": write key=number");
    const std::string key = setting.substr(0, equals), what = "--scenario-set " + key;
    const Found at = find(what, key);
    at.row->put(scenario, at.n, number_or_kind(what, *at.row, setting.substr(equals + 1)));
  }
  check(name, scenario);
  return scenario;
}

std::string shipped_scenarios() {
  std::string names;
  for (const auto& [name, unused] : shipped()) names += (names.empty() ? "" : ", ") + name;
  return names;
}

}  // namespace halfroll::sitl
