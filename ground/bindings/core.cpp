// firmware/core for Python: quaternions, vehicle, parameters, attitude law, mixer, outer loop.
#include "bindings.hpp"
#include "core/attitude.hpp"
#include "core/mixer.hpp"
#include "core/outer_loop.hpp"
#include "core/quaternion.hpp"
#include "core/setpoint.hpp"

namespace halfroll::bindings {
namespace {

void bind_values(py::module_& m) {
  py::enum_<RotorKind>(m, "RotorKind")
      .value("VARIABLE_PITCH", RotorKind::kVariablePitch)
      .value("FIXED_PITCH", RotorKind::kFixedPitch);

  py::class_<Vehicle>(m, "Vehicle", "What the firmware knows of the vehicle. SI; inertia (3,) about body axes.")
      .def(py::init<>())
      .def_readwrite("mass", &Vehicle::mass)
      .def_readwrite("inertia", &Vehicle::inertia)
      .def_readwrite("arm", &Vehicle::arm)
      .def_readwrite("yaw_coefficient", &Vehicle::yaw_coefficient)
      .def_readwrite("rotor_kind", &Vehicle::rotor_kind)
      .def_readwrite("thrust_min", &Vehicle::thrust_min)
      .def_readwrite("thrust_max", &Vehicle::thrust_max)
      .def_readwrite("rotor_lag", &Vehicle::rotor_lag)
      .def_readwrite("rotor_lag_down", &Vehicle::rotor_lag_down);

  py::class_<FlatReference>(m, "FlatReference", "A point of a trajectory in W: (3,) vectors, SI; yaw in radians.")
      .def(py::init([](const Vec3& position, const Vec3& velocity, const Vec3& acceleration, const Vec3& jerk,
                       const Vec3& snap, float yaw, float yaw_rate, float yaw_acceleration) {
             return FlatReference{position, velocity, acceleration, jerk, snap, yaw, yaw_rate, yaw_acceleration};
           }),
           py::kw_only(), "position"_a, "velocity"_a = Vec3(Vec3::Zero()), "acceleration"_a = Vec3(Vec3::Zero()),
           "jerk"_a = Vec3(Vec3::Zero()), "snap"_a = Vec3(Vec3::Zero()), "yaw"_a = 0.F, "yaw_rate"_a = 0.F,
           "yaw_acceleration"_a = 0.F)
      .def_readwrite("position", &FlatReference::position)
      .def_readwrite("velocity", &FlatReference::velocity)
      .def_readwrite("acceleration", &FlatReference::acceleration)
      .def_readwrite("yaw", &FlatReference::yaw);

  py::class_<Setpoint>(m, "Setpoint", "Attitude, body rates and signed thrust [N] wanted at t_us.")
      .def_readonly("t_us", &Setpoint::t_us)
      .def_property_readonly("q_WD", [](const Setpoint& s) { return from_quat(s.q_WD); })
      .def_readonly("w_WD_D", &Setpoint::w_WD_D)
      .def_readonly("dw_WD_D", &Setpoint::dw_WD_D)
      .def_readonly("thrust", &Setpoint::thrust);

  py::class_<PoseFix>(m, "PoseFix", "A pose from outside, sampled at t_us.")
      .def(py::init([](std::uint64_t t_us, const Vec3& p_WB, const Quad& q_WB, const Vec3& position_deviation,
                       const Vec3& attitude_deviation) {
             PoseFix fix;
             fix.t_us = t_us;
             fix.p_WB = p_WB;
             fix.q_WB = to_quat(q_WB);
             fix.position_deviation = position_deviation;
             fix.attitude_deviation = attitude_deviation;
             return fix;
           }),
           "t_us"_a, "p_WB"_a, "q_WB"_a, py::kw_only(), "position_deviation"_a = Vec3(Vec3::Zero()),
           "attitude_deviation"_a = Vec3(Vec3::Zero()))
      .def_readonly("t_us", &PoseFix::t_us)
      .def_readonly("p_WB", &PoseFix::p_WB)
      .def_property_readonly("q_WB", [](const PoseFix& p) { return from_quat(p.q_WB); });

  py::enum_<Aiding>(m, "Aiding", "What keeps an estimate from drifting.")
      .value("NONE", Aiding::kNone)
      .value("POSE", Aiding::kPose)
      .value("SATELLITES", Aiding::kSatellites);

  py::class_<Estimate>(m, "Estimate", "What the autopilot believes of its motion.")
      .def_property_readonly("q_WB", [](const Estimate& e) { return from_quat(e.q_WB); })
      .def_readonly("w_WB_B", &Estimate::w_WB_B)
      .def_readonly("p_WB", &Estimate::p_WB)
      .def_readonly("v_WB", &Estimate::v_WB)
      .def_readonly("attitude_valid", &Estimate::attitude_valid)
      .def_readonly("position_valid", &Estimate::position_valid)
      .def_readonly("aiding", &Estimate::aiding)
      .def_readonly("resets", &Estimate::resets)
      .def_readonly("attitude_deviation", &Estimate::attitude_deviation)
      .def_readonly("velocity_deviation", &Estimate::velocity_deviation)
      .def_readonly("position_deviation", &Estimate::position_deviation);
}

void bind_params(py::module_& m) {
  py::class_<ParamInfo>(m, "ParamInfo", "One row of the parameter table.")
      .def_readonly("id", &ParamInfo::id)
      .def_readonly("default", &ParamInfo::default_value)
      .def_readonly("least", &ParamInfo::least)
      .def_readonly("most", &ParamInfo::most)
      .def_readonly("unit", &ParamInfo::unit)
      .def_readonly("flags", &ParamInfo::flags)
      .def_readonly("meaning", &ParamInfo::meaning);
  m.def(
      "parameter_table", [] { return std::vector<ParamInfo>(kParamTable.begin(), kParamTable.end()); },
      "All parameters in MAVLink index order.");

  const auto index_of = [](const std::string& id) {
    const int index = find_param(id.c_str());
    if (index < 0) throw py::key_error("no parameter " + id);
    return index;
  };
  py::class_<Params>(m, "Params", "Current parameter values by MAVLink id.")
      .def(py::init<>())
      .def(
          "__getitem__",
          [index_of](const Params& p, const std::string& id) {
            return p.*kParamTable[static_cast<std::size_t>(index_of(id))].member;
          },
          "id"_a)
      .def(
          "__setitem__",
          [index_of](Params& p, const std::string& id, float wanted) {
            const ParamInfo& info = kParamTable[static_cast<std::size_t>(index_of(id))];
            if (!(wanted >= info.least && wanted <= info.most)) {
              throw py::value_error(id + " must be between " + std::to_string(info.least) + " and " +
                                    std::to_string(info.most));
            }
            p.*info.member = wanted;  // read-only ones too: that flag is for the link
          },
          "id"_a, "wanted"_a)
      .def("copy", [](const Params& p) { return p; });
}

struct BoundOuterLoop {
  BoundOuterLoop(const Vehicle& vehicle, const Params& given) : loop(vehicle), params(given) {}

  Setpoint step(std::uint64_t t_us, const Quad& q_WB, const Vec3& w_WB_B, const Vec3& p_WB, const Vec3& v_WB,
                const FlatReference& at_sample, const FlatReference& now, const Vec3& lead_acceleration,
                const Vec3& lead_rate, float mid_age, float sigma, bool sigma_event_near, bool on_ground) {
    const Estimate state{to_quat(q_WB), w_WB_B, p_WB, v_WB, true, true};
    return loop.step(
        {t_us, state, at_sample, now, lead_acceleration, lead_rate, mid_age, sigma, sigma_event_near, on_ground},
        params);
  }

  OuterLoop loop;
  Params params;
};

void bind_kernels(py::module_& m) {
  m.def(
      "multiply", [](const Quad& a, const Quad& b) { return from_quat(to_quat(a) * to_quat(b)); }, "a"_a, "b"_a,
      "Hamilton product of two quaternions (4,), [w, x, y, z].");
  m.def("conjugate", [](const Quad& q) { return from_quat(conj(to_quat(q))); }, "q"_a);
  m.def(
      "rotate", [](const Quad& q, const Vec3& v) { return rotate(to_quat(q), v); }, "q"_a, "v"_a,
      "R(q) v: body components to world for q_WB.");

  m.def(
      "attitude_wrench",
      [](const Quad& q_WB, const Vec3& w_WB_B, const Quad& q_WD, const Vec3& w_WD_D, const Vec3& dw_WD_D, float thrust,
         const Vehicle& vehicle, const Params& params) {
        const Wrench wrench =
            attitude_wrench(to_quat(q_WB), w_WB_B, {to_quat(q_WD), w_WD_D, dw_WD_D, thrust}, vehicle, params);
        return std::make_tuple(wrench.thrust, wrench.torque);
      },
      "q_WB"_a, "w_WB_B"_a, "q_WD"_a, "w_WD_D"_a, "dw_WD_D"_a, "thrust"_a, "vehicle"_a, "params"_a,
      "Attitude law (Eq 22, corrected): (thrust [N], torque (3,) [N m]).");
  m.def(
      "allocate",
      [](float thrust, const Vec3& torque, const Vehicle& vehicle) {
        const Allocation given = allocate({thrust, torque}, vehicle);
        return std::make_tuple(given.rotors.thrust,
                               std::array<bool, 3>{given.cut.tilt, given.cut.thrust, given.cut.yaw});
      },
      "thrust"_a, "torque"_a, "vehicle"_a,
      "Four rotor thrusts inside the limits, and which of (roll/pitch torque, thrust, yaw torque) was cut.");

  py::class_<BoundOuterLoop>(m, "OuterLoop", "Outer loop (Eqs 6-19), the one the firmware flies: call every 10 ms.")
      .def(py::init<const Vehicle&, const Params&>(), "vehicle"_a, "params"_a)
      .def(
          "reset", [](BoundOuterLoop& self, const Quad& q_WB) { self.loop.reset(to_quat(q_WB)); }, "q_WB"_a,
          "Forget errors and chart; continue from this attitude.")
      .def("copy", [](const BoundOuterLoop& self) { return self; })
      .def("step", &BoundOuterLoop::step, py::kw_only(), "t_us"_a, "q_WB"_a, "w_WB_B"_a, "p_WB"_a, "v_WB"_a,
           "at_sample"_a, "now"_a, "lead_acceleration"_a = Vec3(Vec3::Zero()), "lead_rate"_a = Vec3(Vec3::Zero()),
           "mid_age"_a = 0.F, "sigma"_a = 1.F, "sigma_event_near"_a = false, "on_ground"_a = false,
           "State (when sampled), the plan at the sample and now, and the plan's leads -> Setpoint.");
}

}  // namespace

void bind_core(py::module_& m) {
  bind_values(m);
  bind_params(m);
  bind_kernels(m);
}

}  // namespace halfroll::bindings
