// The world as Python holds it: a plant, a scenario and the state.
#pragma once
#include "bindings.hpp"
#include "sim/world.hpp"

namespace halfroll::bindings {

class BoundWorld {
 public:
  BoundWorld(const sim::Plant& plant, const std::string& scenario, std::uint64_t seed)
      : plant_(plant), scenario_(named(scenario)), world_(sim::start(plant_, scenario_, seed)) {}

  void step(const std::array<float, 4>& thrust) {
    world_ = sim::step(plant_, scenario_, world_, RotorCommands{thrust});
  }

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

}  // namespace halfroll::bindings
