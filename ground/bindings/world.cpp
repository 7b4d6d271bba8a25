// The simulated world for Python.
#include "bound_world.hpp"

namespace halfroll::bindings {

void bind_world(py::module_& m) {
  py::class_<sim::Plant>(m, "Plant", "The simulated vehicle, SI.")
      .def_readwrite("mass", &sim::Plant::mass)
      .def_readwrite("inertia", &sim::Plant::inertia)
      .def_readwrite("arm", &sim::Plant::arm)
      .def_readwrite("ideal_rotors", &sim::Plant::ideal_rotors)
      .def_readwrite("thrust_min", &sim::Plant::thrust_min)
      .def_readwrite("thrust_max", &sim::Plant::thrust_max);

  py::class_<BoundWorld>(m, "World", "The simulated world (double precision): rotors, rigid body, ground, sensors.")
      .def(py::init<const sim::Plant&, const std::string&, std::uint64_t>(), "plant"_a, "scenario"_a = "nominal",
           "seed"_a = 0)
      .def("step", &BoundWorld::step, "thrust"_a, "Advance 1 ms under four rotor commands [N].")
      .def("step_many", &BoundWorld::step_many, "thrusts"_a,
           "thrusts (N, 4) -> truth (N, 13): p, v, q [w, x, y, z], w after each millisecond.")
      .def("place", &BoundWorld::place, "p_WB"_a, "v_WB"_a, "q_WB"_a, "w_WB_B"_a, "thrust"_a,
           "Start again at time 0 from this state, rotors settled at these thrusts.")
      .def("copy", [](const BoundWorld& w) { return w; })
      .def_property_readonly("t_us", [](const BoundWorld& w) { return w.world().t_us; })
      .def_property_readonly("p_WB", [](const BoundWorld& w) { return w.world().body.p_WB; })
      .def_property_readonly("v_WB", [](const BoundWorld& w) { return w.world().body.v_WB; })
      .def_property_readonly("q_WB", [](const BoundWorld& w) { return w.world().body.q_WB; })
      .def_property_readonly("w_WB_B", [](const BoundWorld& w) { return w.world().body.w_WB_B; })
      .def_property_readonly("rotor_thrust", [](const BoundWorld& w) { return w.world().rotors.thrust; })
      .def_property_readonly("gyro", [](const BoundWorld& w) { return w.world().readings.imu.w_WB_B; })
      .def_property_readonly("accelerometer",
                             [](const BoundWorld& w) { return w.world().readings.imu.specific_force_B; })
      .def_property_readonly("pose", [](const BoundWorld& w) { return w.world().readings.pose; });
}

}  // namespace halfroll::bindings
