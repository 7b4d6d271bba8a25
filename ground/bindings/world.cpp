// The simulated world for Python.
#include "bound_world.hpp"
#include "core/attitude.hpp"
#include "core/mixer.hpp"
#include "core/rotor.hpp"

namespace halfroll::bindings {
namespace {

/// The attitude loop alone, on the true state: law, mixer, motor lag inverse, world.
py::array_t<double> turn_to(BoundWorld& world, const Quad& q_WD, float thrust, const Vehicle& vehicle,
                            const Params& params, py::ssize_t steps) {
  py::array_t<double> truth({steps, py::ssize_t{13}});
  double* row = truth.mutable_data();
  py::gil_scoped_release release;
  RotorLagInverse motors;
  Reference reference;
  reference.q_WD = to_quat(q_WD);
  reference.thrust = thrust;
  for (py::ssize_t i = 0; i < steps; ++i, row += 13) {
    const sim::RigidBody& body = world.world().body;
    const Quat q_WB = to_quat(body.q_WB.cast<float>());
    const Wrench wrench = attitude_wrench(q_WB, body.w_WB_B.cast<float>(), reference, vehicle, params);
    world.step(motors.step(allocate(wrench, vehicle).rotors, vehicle, params));
    world.show(row);
  }
  return truth;
}

void bind_setup(py::module_& m) {
  py::class_<sim::Plant>(m, "Plant", "The simulated vehicle, SI.")
      .def_readwrite("gravity", &sim::Plant::gravity)
      .def_readwrite("mass", &sim::Plant::mass)
      .def_readwrite("inertia", &sim::Plant::inertia)
      .def_readwrite("arm", &sim::Plant::arm)
      .def_readwrite("ideal_rotors", &sim::Plant::ideal_rotors)
      .def_readwrite("thrust_min", &sim::Plant::thrust_min)
      .def_readwrite("thrust_max", &sim::Plant::thrust_max);
  py::class_<sim::Scenario>(m, "Scenario", "Air, sensors, loads and faults of a world.");
  m.def("scenario_setup", &sitl::make_scenario, "name"_a = "nominal", "settings"_a = std::vector<std::string>{},
        "A shipped scenario with settings like 'wind.mean_m_s.0=3' over it. ValueError says what is wrong.");
}

/// The world's integrator alone.
std::pair<Eigen::Vector4d, Eigen::Vector3d> free_rotation(const Eigen::Vector3d& inertia, const Eigen::Vector4d& q_WB,
                                                          const Eigen::Vector3d& w_WB_B, double h, std::size_t steps) {
  const sim::Inertia moments(1.0, inertia);
  sim::RigidBody body;
  body.q_WB = q_WB;
  body.w_WB_B = w_WB_B;
  for (std::size_t i = 0; i < steps; ++i) {
    sim::rk4(moments, body, [](const sim::RigidBody&, sim::Moment) { return sim::Load{}; }, h);
  }
  return {body.q_WB, body.w_WB_B};
}

}  // namespace

void bind_world(py::module_& m) {
  bind_setup(m);
  m.def("free_rotation", &free_rotation, "inertia"_a, "q_WB"_a, "w_WB_B"_a, "h"_a, "steps"_a,
        "The world's integrator on a body that nothing pushes: (q, w) after so many steps of h seconds.");
  py::class_<BoundWorld>(m, "World",
                         "The simulated world (double precision): rotors, air, rigid body, ground, sensors.")
      .def(py::init([](const sim::Plant& plant, const std::string& scenario, std::uint64_t seed) {
             return BoundWorld(plant, sitl::make_scenario(scenario), seed);
           }),
           "plant"_a, "scenario"_a = "nominal", "seed"_a = 0)
      .def(py::init<const sim::Plant&, const sim::Scenario&, std::uint64_t>(), "plant"_a, "scenario"_a, "seed"_a = 0)
      .def(
          "step", [](BoundWorld& w, const std::array<float, 4>& thrust) { w.step(RotorCommands{thrust}); }, "thrust"_a,
          "Advance 1 ms under four rotor commands [N].")
      .def("step_many", &BoundWorld::step_many, "thrusts"_a,
           "thrusts (N, 4) -> truth (N, 13): p, v, q [w, x, y, z], w after each millisecond.")
      .def("turn_to", &turn_to, "q_WD"_a, "thrust"_a, "vehicle"_a, "params"_a, "steps"_a,
           "The attitude loop alone, on the true state: turn to q_WD under a thrust [N]; truth (N, 13) as step_many.")
      .def("place", &BoundWorld::place, "p_WB"_a, "v_WB"_a, "q_WB"_a, "w_WB_B"_a, "thrust"_a,
           "Start again at time 0 from this state, rotors settled at these thrusts; the seed stays.")
      .def(
          "copy", [](const BoundWorld& w) { return w; }, "A snapshot: flies the same future.")
      .def(
          "restore", [](BoundWorld& w, const BoundWorld& snapshot) { w = snapshot; }, "snapshot"_a,
          "Be again what was copied.")
      .def(
          "same_state", [](const BoundWorld& a, const BoundWorld& b) { return sim::same_state(a.world(), b.world()); },
          "other"_a)
      .def_property_readonly("t_us", [](const BoundWorld& w) { return w.world().t_us; })
      .def_property_readonly("p_WB", [](const BoundWorld& w) { return w.world().body.p_WB; })
      .def_property_readonly("v_WB", [](const BoundWorld& w) { return w.world().body.v_WB; })
      .def_property_readonly("q_WB", [](const BoundWorld& w) { return w.world().body.q_WB; })
      .def_property_readonly("w_WB_B", [](const BoundWorld& w) { return w.world().body.w_WB_B; })
      .def_property_readonly("rotor_thrust", [](const BoundWorld& w) { return w.world().rotors.thrust; })
      .def_property_readonly("wind_W", [](const BoundWorld& w) { return w.world().wind.velocity_W; })
      .def_property_readonly("battery_V", [](const BoundWorld& w) { return w.world().battery.voltage; })
      .def_property_readonly("battery_charge", [](const BoundWorld& w) { return w.world().battery.charge; })
      .def_property_readonly("crashed", [](const BoundWorld& w) { return w.world().contact.crashed; })
      .def_property_readonly("gyro", [](const BoundWorld& w) { return w.world().readings.imu.w_WB_B; })
      .def_property_readonly("accelerometer",
                             [](const BoundWorld& w) { return w.world().readings.imu.specific_force_B; })
      .def_property_readonly("pose", [](const BoundWorld& w) { return w.world().readings.pose; });
}

}  // namespace halfroll::bindings
