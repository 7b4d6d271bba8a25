// What halfroll-sitl is made of: hash, vehicle table, command line.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "link/sha256.hpp"
#include "sim/sitl/bad_option.hpp"
#include "sim/sitl/options.hpp"
#include "sim/sitl/scenario_file.hpp"
#include "sim/sitl/status_text.hpp"
#include "sim/sitl/vehicle_file.hpp"

using namespace halfroll;
using namespace halfroll::sitl;

namespace {

std::string sha256(const std::string& text) {
  link::Sha256 hash;
  hash.add(text.data(), text.size());
  return hash.hex().data();
}

template <typename Act>
std::string complaint(const Act& act) {
  try {
    act();
  } catch (const BadOption& wrong) {
    return wrong.what();
  }
  return "";
}

std::string vehicle_complaint(const std::string& setting, const std::string& name = "mit-vp") {
  return complaint([&] { make_vehicle(name, {setting}); });
}

std::string option_complaint(const std::vector<std::string>& words) {
  return complaint([&] { parse_options(words); });
}

bool says(const std::string& sentence, const std::string& words) { return sentence.find(words) != std::string::npos; }

}  // namespace

TEST_CASE("SHA-256 agrees with the vectors of FIPS 180") {
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256(std::string(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("a float is hashed as four bytes, lowest first") {
  link::Sha256 hash;
  hash.add_float(1.5F);
  CHECK(std::string(hash.hex().data()) == sha256(std::string("\x00\x00\xc0\x3f", 4)));
}

TEST_CASE("firmware and world are built from the same shipped numbers") {
  const VehicleSetup vp = make_vehicle("mit-vp", {}), fp = make_vehicle("mit-fp", {});
  CHECK(vp.plant.mass == 0.571);
  CHECK(vp.vehicle.mass == 0.571F);
  CHECK(vp.plant.inertia == sim::Vec3d(0.00365, 0.00365, 0.0068));
  CHECK(vp.plant.rotor_delay == 0.003);
  CHECK(vp.params.thrust_reference == 12.0F);
  CHECK(vp.plant.rotor_kind == RotorKind::kVariablePitch);
  CHECK(fp.vehicle.rotor_kind == RotorKind::kFixedPitch);
  CHECK(fp.params.att_natural_frequency == 10.0F);
}

TEST_CASE("a setting replaces a number of the vehicle or a parameter") {
  const VehicleSetup setup =
      make_vehicle("mit-vp", {"rotor.thrust_max_N=2.5", "params.ATT_WN=12", "rotor.kind=fixed-pitch",
                              "rotor.thrust_min_N=0.1", "mass_kg=0.5", "mass_kg=0.6"});
  CHECK(setup.plant.thrust_max == 2.5);
  CHECK(setup.params.thrust_reference == 10.0F);
  CHECK(setup.params.att_natural_frequency == 12.0F);
  CHECK(setup.vehicle.rotor_kind == RotorKind::kFixedPitch);
  CHECK(setup.plant.mass == 0.6);  // the last one counts
}

TEST_CASE("a bad setting is refused with key, number and limit") {
  CHECK(says(vehicle_complaint("rotor.thrust=2"), "rotor.thrust: no such key"));
  CHECK(says(vehicle_complaint("mass_kg=heavy"), "'heavy' is not a number"));
  CHECK(says(vehicle_complaint("mass_kg=nan"), "not a number"));
  CHECK(says(vehicle_complaint("mass_kg="), "not a number"));
  CHECK(says(vehicle_complaint("mass_kg"), "write key=number"));
  CHECK(says(vehicle_complaint("mass_kg=-1"), "-1 is outside 0.001 to 1000"));
  CHECK(says(vehicle_complaint("rotor.delay_s=0.5"), "0.5 is outside 0 to 0.063"));
  CHECK(says(vehicle_complaint("params.NO_SUCH=1"), "no parameter NO_SUCH"));
  CHECK(says(vehicle_complaint("params.ATT_WN=1000"), "1000 is outside 1 to 60"));
  CHECK(says(vehicle_complaint("params.VEH_T_REF=1"), "read-only"));
  CHECK(says(vehicle_complaint("mass_kg=1", "glider"), "shipped are mit-fp, mit-vp"));
}

TEST_CASE("a vehicle that cannot exist or hover is refused") {
  CHECK(says(vehicle_complaint("mass_kg=2"), "cannot hover"));
  CHECK(says(vehicle_complaint("rotor.thrust_min_N=3"), "must be below rotor.thrust_max_N"));
  CHECK(says(vehicle_complaint("rotor.kind=1"), "cannot push down"));
  CHECK(says(vehicle_complaint("inertia_kg_m2.2=0.0074"), "no body has inertia"));
}

TEST_CASE("every shipped scenario is one, and a setting replaces a number of it") {
  for (const char* name : {"faults", "full", "ideal", "nominal", "outdoor", "windy"}) make_scenario(name);
  CHECK(make_scenario("nominal").effects.drag);
  CHECK(make_scenario("nominal").mocap.delay_us == 10000);
  CHECK(make_scenario("windy").wind.gusts[0].velocity.y() == 2.0);
  CHECK(make_scenario("faults").faults[0].kind == sim::Fault::Kind::kWeakRotor);
  CHECK(make_scenario("faults").faults[0].rotor == 1);  // the second one
  const sim::Scenario s =
      make_scenario("ideal", {"wind.mean_m_s.1=3", "fault.2.kind=dead-rotor", "fault.2.at_s=4", "mocap.rate_hz=250"});
  CHECK(s.wind.mean == sim::Vec3d(0, 3, 0));
  CHECK(s.faults[2].kind == sim::Fault::Kind::kDeadRotor);
  CHECK(s.mocap.period_us == 4000);
}

TEST_CASE("a bad setting of a scenario is refused with key, number and limit") {
  const auto wrong = [](const std::string& setting) { return complaint([&] { make_scenario("ideal", {setting}); }); };
  CHECK(says(wrong("wind.mean=3"), "wind.mean: no such key; there are effects.drag"));
  CHECK(says(wrong("wind.mean_m_s.0=fast"), "'fast' is not a number"));
  CHECK(says(wrong("wind.mean_m_s.0=80"), "80 is outside -50 to 50"));
  CHECK(says(wrong("wind.mean_m_s.3=1"), "there are 3, counted from 0"));
  CHECK(says(wrong("fault.9.kind=1"), "there are 8, counted from 0"));
  CHECK(says(wrong("mocap.rate_hz"), "write key=number"));
}

TEST_CASE("options have the documented defaults") {
  const Options o = parse_options({});
  CHECK(o.port_offboard == 14580);
  CHECK(o.peer_offboard == 14540);
  CHECK(o.port_gcs == 18570);
  CHECK(o.peer_gcs == 14550);
  CHECK(o.port_companion == 14280);
  CHECK(o.peer_companion == 14030);
  CHECK(o.speed == 1.0);
  CHECK(o.vehicle == "mit-vp");
  CHECK(o.scenario_name == "nominal");
  CHECK(o.scenario_called == "nominal");
  CHECK(parse_options({"--lockstep"}).speed == 0.0);
  CHECK(parse_options({"--lockstep", "--speed", "1"}).speed == 1.0);
}

TEST_CASE("options are taken with a space or an equals sign, --set as often as wanted") {
  const Options o = parse_options({"--instance=3", "--set", "mass_kg=1", "--set=arm_m=0.2", "--origin", "-33.5,151,12",
                                   "--seed", "9007199254740993", "--port-gcs", "9000", "--identity", "px4"});
  CHECK(o.port_offboard == 14583);
  CHECK(o.port_gcs == 9000);
  CHECK(o.settings == std::vector<std::string>{"mass_kg=1", "arm_m=0.2"});
  CHECK(o.origin.lat_degE7() == -335000000);
  CHECK(o.origin.alt_mm() == 12000);
  CHECK(o.seed == 9007199254740993U);  // all 64 bits, no detour through floating point
  CHECK(o.px4_identity);
}

TEST_CASE("a bad option is refused with its name") {
  CHECK(says(option_complaint({"--sped", "1"}), "--sped: no such option"));
  CHECK(says(option_complaint({"fast"}), "'fast' is not an option"));
  CHECK(says(option_complaint({"--speed"}), "needs a value: --speed X"));
  CHECK(says(option_complaint({"--speed", "fast"}), "--speed 'fast' is not a number"));
  CHECK(says(option_complaint({"--speed", "-1"}), "outside 0 to 1000"));
  CHECK(says(option_complaint({"--seed", "1.5"}), "not a whole number"));
  CHECK(says(option_complaint({"--lockstep=1"}), "takes no value"));
  CHECK(says(option_complaint({"--scenario", "storm"}), "there are faults, full, ideal, nominal, outdoor, windy"));
  CHECK(says(option_complaint({"--identity", "apm"}), "write px4 or generic"));
  CHECK(says(option_complaint({"--origin", "1,2"}), "latitude,longitude,altitude"));
  CHECK(says(option_complaint({"--port-gcs", "70000"}), "outside 0 to 65535"));
  CHECK(says(option_complaint({"--instance", "10"}), "above 9: give --port"));
}

TEST_CASE("instances beyond 9 fly on ports given by hand") {
  const Options o = parse_options({"--instance", "10", "--port-offboard", "1", "--peer-offboard", "2", "--port-gcs",
                                   "3", "--peer-gcs", "4", "--port-companion", "5", "--peer-companion", "6"});
  CHECK(o.instance == 10);
  CHECK(o.port_gcs == 3);
}

TEST_CASE("a STATUSTEXT on its way out is read for the log, any other frame is not") {
  link::TxFrame frame;
  const std::vector<std::uint8_t> bytes = {0xFD, 7,   0,   0,   0,   1,   1,   253,  0,   0,
                                           4,    'M', 'o', 'd', 'e', ':', ' ', 0xAA, 0xBB};
  std::copy(bytes.begin(), bytes.end(), frame.bytes.begin());
  const auto text = said(frame);
  REQUIRE(text);
  CHECK(text->severity == 4);
  CHECK(text->line == "Mode: ");
  frame.bytes[7] = 0;
  CHECK_FALSE(said(frame));
}
