// The autopilot for Python: one step, many steps, and the bytes of its links.
#include <atomic>
#include <set>
#include <thread>

#include "autopilot.hpp"
#include "bound_world.hpp"
#include "sim/sitl/checked.hpp"
#include "sim/sitl/sensed.hpp"
#include "sim/sitl/vehicle_file.hpp"

namespace halfroll::bindings {
namespace {

/// Bytes by link and endpoint slot.
using Packet = std::tuple<int, int, py::bytes>;

std::vector<Packet> packets(const LinkOutputs& out) {
  std::vector<Packet> sent;
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    sent.emplace_back(frame.to.link, frame.to.slot,
                      py::bytes(reinterpret_cast<const char*>(frame.bytes.data()), frame.size));
  }
  return sent;
}

struct BoundOutputs {
  std::array<float, 4> thrust;
  std::vector<Packet> tx;
};

/// A datagram as C++ wants it, as long as the Python bytes live.
link::Datagram datagram(const std::string& bytes, int link, int slot) {
  return {{static_cast<std::uint8_t>(link), static_cast<std::uint8_t>(slot)},
          reinterpret_cast<const std::uint8_t*>(bytes.data()),
          bytes.size()};
}

Boot boot_as(bool px4_identity) {
  Boot boot;
  boot.px4_identity = px4_identity;
  return boot;
}

Params at_speed(Params params, float simulation_speed) {
  params.simulation_speed = simulation_speed;
  return params;
}

class BoundAutopilot {
 public:
  BoundAutopilot(const Vehicle& vehicle, const Params& params, bool px4_identity, float simulation_speed)
      : autopilot_(vehicle, at_speed(params, simulation_speed), boot_as(px4_identity)) {}

  BoundOutputs step(const Vec3& w_WB_B, const Vec3& specific_force_B, const std::optional<PoseFix>& pose,
                    const py::bytes& rx, int link, int slot, std::uint64_t wall_us, float state_of_charge) {
    Inputs in;
    in.battery.state_of_charge = state_of_charge;
    in.measured.imu = {w_WB_B, specific_force_B};
    in.measured.pose = pose;
    const std::string bytes = rx;
    const link::Datagram received = datagram(bytes, link, slot);
    in.link = link_inputs(received, wall_us);
    const Outputs out = sitl::step(autopilot_, in);
    storing_ = out.link.store.slot;
    return {out.rotors.thrust, packets(out.link)};
  }

  std::vector<Packet> service(const py::bytes& rx, int link, int slot, std::uint64_t wall_us) {
    const std::string bytes = rx;
    const link::Datagram received = datagram(bytes, link, slot);
    const LinkOutputs out = autopilot_.service(link_inputs(received, wall_us));
    storing_ = out.store.slot;
    return packets(out);
  }

  /// Rotor thrusts (N, 4).
  py::array_t<float> step_many(const FloatRows& imu, const std::optional<FloatRows>& poses) {
    const Recording recording(imu, poses);
    py::array_t<float> thrusts({recording.size(), py::ssize_t{4}});
    float* thrust = thrusts.mutable_data();
    py::gil_scoped_release release;
    Inputs in;
    for (py::ssize_t i = 0; i < recording.size(); ++i, thrust += 4) {
      in.measured = recording.at(i, autopilot_.t_us() + kStepUs);
      const Outputs out = sitl::step(autopilot_, in);
      std::copy(out.rotors.thrust.begin(), out.rotors.thrust.end(), thrust);
    }
    return thrusts;
  }

  /// The loop of the SITL without its links: N milliseconds of autopilot and world, each answering the other.
  void fly(BoundWorld& world, std::size_t steps) {
    const link::Datagram nothing;
    for (std::size_t i = 0; i < steps; ++i) {
      Inputs in = sitl::sensed(world.world());
      in.link = link_inputs(nothing, autopilot_.t_us());
      const Outputs out = sitl::step(autopilot_, in);
      storing_ = out.link.store.slot;
      world.step(out.rotors);
    }
  }

  const Autopilot& autopilot() const { return autopilot_; }

  bool storage_works = true;

 private:
  /// Storage exists only in the shells; here a write succeeds or fails at once.
  LinkInputs link_inputs(const link::Datagram& received, std::uint64_t wall_us) {
    LinkInputs in;
    in.rx = &received;
    in.rx_count = received.size == 0 ? 0 : 1;
    in.wall_us = wall_us;
    in.stored = {storing_, storage_works};
    storing_ = link::StorageSlot::kNone;
    return in;
  }

  Autopilot autopilot_;
  link::StorageSlot storing_ = link::StorageSlot::kNone;
};

/// Flies pair by pair, in as many threads as wanted; no pair knows of another, so the bits do not depend on threads.
void run_batch(const std::vector<BoundAutopilot*>& autopilots, const std::vector<BoundWorld*>& worlds,
               std::size_t steps, std::size_t threads) {
  if (autopilots.size() != worlds.size()) {
    throw py::value_error(std::to_string(autopilots.size()) + " autopilots for " + std::to_string(worlds.size()) +
                          " worlds: give one each");
  }
  if (std::set(autopilots.begin(), autopilots.end()).size() < autopilots.size() ||
      std::set(worlds.begin(), worlds.end()).size() < worlds.size()) {
    throw py::value_error("an autopilot or world is listed twice; give copies");
  }
  py::gil_scoped_release release;
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < autopilots.size(); i = next++) autopilots[i]->fly(*worlds[i], steps);
  };
  const std::size_t wanted = threads > 0 ? threads : std::thread::hardware_concurrency();
  std::vector<std::thread> others;
  for (std::size_t n = 1; n < std::min(wanted, autopilots.size()); ++n) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

}  // namespace

void bind_flight(py::module_& m) {
  py::class_<sitl::VehicleSetup>(m, "VehicleSetup", "A vehicle as firmware, world and parameters see it.")
      .def_readonly("name", &sitl::VehicleSetup::name)
      .def_readonly("vehicle", &sitl::VehicleSetup::vehicle)
      .def_readonly("plant", &sitl::VehicleSetup::plant)
      .def_readonly("params", &sitl::VehicleSetup::params);
  m.def("vehicle_setup", &sitl::make_vehicle, "name"_a = "mit-vp", "settings"_a = std::vector<std::string>{},
        "A shipped vehicle with settings like 'rotor.thrust_max_N=2.5' over it. ValueError says what is wrong.");

  py::class_<BoundOutputs>(m, "Outputs", "Rotor commands (4,) [N], and frames to send as (link, slot, bytes).")
      .def_readonly("thrust", &BoundOutputs::thrust)
      .def_readonly("tx", &BoundOutputs::tx);

  py::class_<BoundAutopilot>(m, "Autopilot", "The firmware itself, the same library as halfroll-sitl.")
      .def(py::init<const Vehicle&, const Params&, bool, float>(), "vehicle"_a, "params"_a, py::kw_only(),
           "px4_identity"_a = false, "simulation_speed"_a = 1.F)
      .def("step", &BoundAutopilot::step, "w_WB_B"_a, "specific_force_B"_a, "pose"_a = std::nullopt, py::kw_only(),
           "rx"_a = py::bytes(""), "link"_a = 0, "slot"_a = 0, "wall_us"_a = 0, "state_of_charge"_a = 1.F,
           "Advance 1 ms: sensors and received bytes in, Outputs out.")
      .def("service", &BoundAutopilot::service, "rx"_a, "link"_a = 0, "slot"_a = 0, "wall_us"_a = 0,
           "Answer the link while no time passes; frames as (link, slot, bytes).")
      .def("step_many", &BoundAutopilot::step_many, "imu"_a, "poses"_a = std::nullopt,
           "N steps: imu (N, 6) [rad/s, m/s^2], poses (N, 7) or None (NaN rows: none) -> rotor thrusts (N, 4) [N].")
      .def("fly", &BoundAutopilot::fly, "world"_a, "steps"_a, py::call_guard<py::gil_scoped_release>(),
           "N milliseconds of closed loop with a World; the links hear nothing meanwhile.")
      .def(
          "copy", [](const BoundAutopilot& a) { return std::make_unique<BoundAutopilot>(a); },
          "A snapshot: with a World's it flies the same future.")
      .def(
          "restore", [](BoundAutopilot& a, const BoundAutopilot& snapshot) { a = snapshot; }, "snapshot"_a,
          "Be again what was copied.")
      .def(
          "same_state",
          [](const BoundAutopilot& a, const BoundAutopilot& b) { return a.autopilot().same_state(b.autopilot()); },
          "other"_a)
      .def_property_readonly(
          "broken_invariant", [](const BoundAutopilot& a) { return a.autopilot().broken_invariant(); },
          "What does not hold that must after every step, in words, or None.")
      .def_property_readonly(
          "state_checksum", [](const BoundAutopilot& a) { return a.autopilot().state_checksum(); },
          "One number of all that it remembers: equal states have equal ones, on any processor.")
      .def_readwrite("storage_works", &BoundAutopilot::storage_works, "Whether the writes that it asks for succeed.")
      .def_property_readonly("t_us", [](const BoundAutopilot& a) { return a.autopilot().t_us(); })
      .def_property_readonly("armed", [](const BoundAutopilot& a) { return a.autopilot().armed(); })
      .def_property_readonly("on_ground", [](const BoundAutopilot& a) { return a.autopilot().on_ground(); })
      .def_property_readonly("mode", [](const BoundAutopilot& a) { return mode_name(a.autopilot().mode()); })
      .def_property_readonly("estimate", [](const BoundAutopilot& a) { return a.autopilot().estimate(); })
      .def_property_readonly("params", [](const BoundAutopilot& a) { return a.autopilot().params(); });

  const py::object world = m.attr("World");
  world.attr("run_batch") = py::staticmethod(py::cpp_function(
      &run_batch, py::name("run_batch"), py::scope(world), "autopilots"_a, "worlds"_a, "steps"_a, "threads"_a = 0,
      "Fly each autopilot in the world beside it for so many milliseconds, in parallel (threads 0: one a core) and "
      "without the GIL. The bits are those of Autopilot.fly."));
}

}  // namespace halfroll::bindings
