#include "sim/world.hpp"

#include <tuple>

#include "sim/airframe.hpp"
#include "sim/wide.hpp"

namespace halfroll::sim {
namespace {

double spin_of(const Model& model, const PerRotor& speed) {
  if (model.spin <= 0.0) return 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum -= kTorqueSign[i] * speed[i];  // a rotor turns against its drag torque
  return model.spin * sum;
}

Surroundings surroundings(const Model& model, const World& world) {
  Surroundings around;
  around.wind_W = world.wind.velocity_W;
  around.air = air_coefficients(model, world.rotors.speed);
  around.spin = spin_of(model, world.rotors.speed);
  around.near_ground = world.body.p_WB.z() < model.ground_reach;
  return around;
}

RotorCondition condition_of(const Model& model, const World& world) {
  RotorCondition condition;
  if (model.plant.battery_full_V > 0.0) {
    condition.speed_ceiling = speed_ceiling(model, world.battery);
    condition.sound = false;
  }
  if (!model.has_faults) return condition;
  const double t_s = 1e-6 * static_cast<double>(world.t_us);
  for (const Fault& fault : model.scenario.faults) {
    if (!fault.active(t_s)) continue;
    switch (fault.kind) {
      case Fault::Kind::kWeakRotor: condition.share[fault.rotor] *= fault.share; break;
      case Fault::Kind::kStuckRotor: condition.stuck[fault.rotor] = true; break;
      case Fault::Kind::kDeadRotor: condition.dead[fault.rotor] = true; break;
      default: continue;
    }
    condition.sound = false;
  }
  return condition;
}

/// The frame's own place and motion; the sensors sit in its middle, off the common centre of mass if there is a load.
Truth truth_of(const Model& model, const World& world, const Surroundings& around, const BodyLoad& rotors) {
  const RigidBody& body = world.body;
  const Load felt = felt_load(model, around, world.contact, rotors, body);
  const Eigen::Matrix3d R_WB = rotation(body.q_WB);
  Truth truth;
  truth.t_us = world.t_us;
  truth.p_W = body.p_WB;
  truth.v_W = body.v_WB;
  truth.q_WB = body.q_WB;
  truth.w_B = body.w_WB_B;
  truth.specific_force_B = R_WB.transpose() * felt.force_W * model.inertia.per_mass();
  if (model.scenario.payload.mass > 0.0) {
    const Vec3d lever = -model.centre, w = body.w_WB_B;
    truth.p_W += R_WB * lever;
    truth.v_W += R_WB * w.cross(lever);
    truth.specific_force_B += model.inertia.turned(w, felt.torque_B).cross(lever) + w.cross(w.cross(lever));
  }
  truth.nominal_rotor_speed_rad_s = model.plant.rotor_speed_rad_s;
  for (std::size_t i = 0; i < 4; ++i) {
    truth.rotor_speed_rad_s[i] = model.plant.rotor_speed_rad_s * world.rotors.speed[i];
  }
  return truth;
}

void measure(const Model& model, World& world, const Surroundings& around, const BodyLoad& rotors) {
  world.readings = read(model.scenario, world.random, world.sensors, truth_of(model, world, around, rotors));
}

void measure(const Model& model, World& world) {
  measure(model, world, surroundings(model, world), rotor_load(model, world.rotors.thrust));
}

/// Forces along up and torques at the beginning, middle and end of a substep.
struct RotorLoads {
  BodyLoad begin, middle, end;
  const BodyLoad& at(Moment moment) const {
    return moment == Moment::kBegin ? begin : moment == Moment::kMiddle ? middle : end;
  }
};

/// One step of the integrator under load_of(body, rotors).
template <typename LoadOf>
void integrate(const Model& model, RigidBody& body, const RotorLoads& rotors, const LoadOf& load_of) {
  const double weight = model.inertia.mass() * model.plant.gravity;
  rk4(
      model.inertia, body,
      [&](const RigidBody& at, Moment moment) {
        Load sum = load_of(at, rotors.at(moment));
        sum.force_W.z() -= weight;
        return sum;
      },
      kSubstep);
}

/// `around` and `load`, what the rotors give, are as the substep begins, afterwards as it ends.
void substep(const Model& model, World& world, int number, const RotorCondition& condition, Surroundings& around,
             BodyLoad& load) {
  const ThrustHistory thrust = advance(model.rotors, world.rotors, number, condition);
  RotorLoads rotors = {load, rotor_load(model, thrust.middle), rotor_load(model, thrust.end)};
  if (model.rotors.ideal) rotors.begin = rotors.end;
  load = rotors.end;
  around.near_ground = world.body.p_WB.z() < model.ground_reach;
  if (model.air_moves_blades) around.air = air_coefficients(model, world.rotors.speed);
  const double before = around.spin, after = spin_of(model, world.rotors.speed);
  around.spin = 0.5 * (after + before);
  around.spin_rate = (after - before) / kSubstep;
  if (around.near_ground || world.contact.any_touching) {
    integrate(model, world.body, rotors, [&](const RigidBody& body, const BodyLoad& given) {
      return felt_load(model, around, world.contact, given, body);
    });
    settle(model.plant, world.contact, world.body);
  } else if (model.plain) {
    integrate(model, world.body, rotors,
              [&](const RigidBody& body, const BodyLoad& given) { return plain_load(model, around, given, body); });
  } else {
    integrate(model, world.body, rotors,
              [&](const RigidBody& body, const BodyLoad& given) { return airborne_load(model, around, given, body); });
  }
  around.spin = after;
  around.spin_rate = 0.0;
}

}  // namespace

World start(const Model& model, std::uint64_t seed, const RigidBody& body, const Rotors& rotors) {
  World world;
  world.random.seed = seed;
  world.body = body;
  world.rotors = rotors;
  world.wind = model.wind.start(world.random);
  world.battery = full_battery(model);
  world.sensors = make_sensors(model.scenario, world.random);
  settle(model.plant, world.contact, world.body);
  world.contact.hardest_impact = 0.0;
  measure(model, world);
  return world;
}

World start(const Model& model, std::uint64_t seed, const RigidBody& body) {
  return start(model, seed, body, steady(model.plant, {}));
}

HALFROLL_WIDE void step(const Model& model, World& world, const RotorCommands& commands) {
  issue(world.rotors, commands);
  const RotorCondition condition = condition_of(model, world);
  Surroundings around = surroundings(model, world);
  BodyLoad load = rotor_load(model, world.rotors.thrust);
  for (int number = 0; number < kSubsteps; ++number) substep(model, world, number, condition, around, load);
  if (model.plant.battery_full_V > 0.0) {
    drain(model, world.battery, rotor_power(model, world.rotors.thrust), kSubsteps * kSubstep);
  }
  world.t_us += kStepUs;
  if (model.wind.blows()) model.wind.advance(world.wind, world.random, world.t_us);
  around.wind_W = world.wind.velocity_W;
  around.near_ground = world.body.p_WB.z() < model.ground_reach;
  measure(model, world, around, load);
}

void restart_clock(const Model& model, World& world) {
  world.t_us = 0;
  world.sensors.poses.clear();
  world.sensors.fixes.clear();
  measure(model, world);
}

bool same_state(const World& a, const World& b) {
  const auto state = [](const World& w) {
    const auto& [p, v, q, rate] = w.body;
    const auto& s = w.sensors;
    return std::tie(w.t_us, w.random.seed, p, v, q, rate, w.rotors.pitch, w.rotors.speed, w.rotors.thrust,
                    w.rotors.blade_moving, w.rotors.issued, w.rotors.newest, w.wind.velocity_W, w.wind.along,
                    w.wind.across, w.wind.vertical, w.battery.charge, w.battery.voltage, s.gyro_bias,
                    s.accelerometer_bias, s.rotor_angle, s.attitude_wander, s.gps_wander, s.barometer_drift,
                    s.magnetometer_bias, w.readings.imu, w.contact.crashed, w.contact.hardest_impact);
  };
  const auto same_point = [](const Contact::Point& x, const Contact::Point& y) {
    return x.touching == y.touching && x.anchor == y.anchor;
  };
  const auto same_poses = [](const auto& x, const auto& y) {
    return x.sent == y.sent && x.delivered == y.delivered && x.due_us == y.due_us &&
           std::equal(x.samples.begin(), x.samples.end(), y.samples.begin(),
                      [](const auto& c, const auto& d) { return c.t_us == d.t_us && c.p_WB == d.p_WB; });
  };
  return state(a) == state(b) &&
         std::equal(a.contact.points.begin(), a.contact.points.end(), b.contact.points.begin(), same_point) &&
         same_poses(a.sensors.poses, b.sensors.poses) && same_poses(a.sensors.fixes, b.sensors.fixes);
}

}  // namespace halfroll::sim
