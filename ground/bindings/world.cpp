// The simulated world for Python.
#include "sim/world.hpp"

#include "bindings.hpp"

namespace halfroll::bindings {
namespace {

class BoundWorld {
 public:
  BoundWorld(const sim::Plant& plant, const std::string& scenario, std::uint64_t seed)
      : plant_(plant), scenario_(named(scenario)), world_(sim::start(plant_, scenario_, seed)) {}

  void step(const std::array<float, 4>& thrust) { world_ = sim::step(plant_, scenario_, world_, RotorCommands{thrust}); }

  /// thrusts (N, 4) -> truth (N, 13): position, velocity, quaternion [w, x, y, z], body rate after each millisecond.
  py::array_t<double> step_many(const py::array_t<float, py::array::c_style | py::array::forcecast>& thrusts) {
    if (thrusts.ndim() != 2 || thrusts.shape(1) != 4) throw py::value_error("thrusts must have shape (N, 4)");
    const py::ssize_t steps = thrusts.shape(0);
    py::array_t<double> truth({steps, py::ssize_t{13}});
    const float* f = thrusts.data();
    double* row = truth.mutable_data();
    for (py::ssize_t i = 0; i < steps; ++i, f += 4, row += 13) {
      step({f[0], f[1], f[2], f[3]});
      Eigen::Map<Eigen::Matrix<double, 13, 1>> out(row);
      out << world_.body.p_WB, world_.body.v_WB, world_.body.q_WB, world_.body.w_WB_B;
    }
    return truth;
  }

  const sim::World& world() const { return world_; }
  void place(const Eigen::Vector3d& p, const Eigen::Vector3d& v, const Eigen::Vector4d& q, const Eigen::Vector3d& w,
             const std::array<float, 4>& thrust) {
    world_ = sim::start(plant_, scenario_, 0, {p, v, q, w}, sim::steady(RotorCommands{thrust}));
  }

 private:
  static sim::Scenario named(const std::string& scenario) {
    const auto found = sim::find_scenario(scenario);
    if (!found) throw py::value_error("no scenario '" + scenario + "': ideal or nominal");
    return *found;
  }

  sim::Plant plant_;
  sim::Scenario scenario_;
  sim::World world_;
};

}  // namespace

void bind_world(py::module_& m) {
  py::class_<sim::Plant>(m, "Plant", "The simulated vehicle, SI.")
      .def_readwrite("mass", &sim::Plant::mass)
      .def_readwrite("inertia", &sim::Plant::inertia)
      .def_readwrite("arm", &sim::Plant::arm)
      .def_readwrite("ideal_rotors", &sim::Plant::ideal_rotors)
      .def_readwrite("thrust_min", &sim::Plant::thrust_min)
      .def_readwrite("thrust_max", &sim::Plant::thrust_max);

  py::class_<BoundWorld>(m, "World", "The simulated world (double precision): rotors, rigid body, ground, sensors.")
      .def(py::init<const sim::Plant&, const std::string&, std::uint64_t>(), "plant"_a, "scenario"_a = "nominal", "seed"_a = 0)
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
      .def_property_readonly("accelerometer", [](const BoundWorld& w) { return w.world().readings.imu.specific_force_B; })
      .def_property_readonly("pose", [](const BoundWorld& w) { return w.world().readings.pose; });
}

}  // namespace halfroll::bindings
