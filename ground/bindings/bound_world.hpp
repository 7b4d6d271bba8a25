// The world as Python holds it: a model and the state.
#pragma once
#include "recording.hpp"
#include "sim/sitl/scenario_file.hpp"
#include "sim/world.hpp"

namespace halfroll::bindings {

class BoundWorld {
 public:
  BoundWorld(const sim::Plant& plant, const sim::Scenario& scenario, std::uint64_t seed)
      : model_(plant, scenario), world_(sim::start(model_, seed)) {}

  void step(const RotorCommands& commands) { sim::step(model_, world_, commands); }

  /// thrusts (N, 4) -> truth (N, 13): position, velocity, quaternion [w, x, y, z], body rate after each millisecond.
  py::array_t<double> step_many(const FloatRows& thrusts) {
    if (thrusts.ndim() != 2 || thrusts.shape(1) != 4) throw py::value_error("thrusts must have shape (N, 4)");
    const py::ssize_t steps = thrusts.shape(0);
    py::array_t<double> truth({steps, py::ssize_t{13}});
    const float* f = thrusts.data();
    double* row = truth.mutable_data();
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < steps; ++i, f += 4, row += 13) {
      step(RotorCommands{{f[0], f[1], f[2], f[3]}});
      show(row);
    }
    return truth;
  }

  /// Position, velocity, quaternion, body rate: 13 numbers.
  void show(double* row) const {
    Eigen::Map<Eigen::Matrix<double, 13, 1>> out(row);
    out << world_.body.p_WB, world_.body.v_WB, world_.body.q_WB, world_.body.w_WB_B;
  }

  const sim::Model& model() const { return model_; }
  const sim::World& world() const { return world_; }
  void place(const Eigen::Vector3d& p, const Eigen::Vector3d& v, const Eigen::Vector4d& q, const Eigen::Vector3d& w,
             const std::array<float, 4>& thrust) {
    const sim::Rotors rotors = sim::steady(model_.plant, RotorCommands{thrust});
    world_ = sim::start(model_, world_.random.seed, {p, v, q, w}, rotors);
  }

 private:
  sim::Model model_;
  sim::World world_;
};

}  // namespace halfroll::bindings
