#include "sim/contact.hpp"

#include <algorithm>
#include <cmath>

namespace halfroll::sim {
namespace {

double stiffness(const Plant& plant) { return plant.mass * plant.contact_frequency * plant.contact_frequency / 4; }
double damping(const Plant& plant) { return plant.mass * plant.contact_frequency * plant.contact_damping / 2; }

Vec3d point_B(const Plant& plant, int i) {
  const double r = plant.foot_radius, z = i < 4 ? -plant.leg_height : plant.leg_height;
  switch (i % 4) {  // in the order of the rotors
    case 0: return {0, r, z};
    case 1: return {-r, 0, z};
    case 2: return {0, -r, z};
    default: return {r, 0, z};
  }
}

bool out_of_reach(const Plant& plant, const RigidBody& body) {
  return body.p_WB.z() > ground_z(plant) + plant.leg_height + plant.foot_radius;
}

}  // namespace

Load ground_load(const Plant& plant, const Contact& contact, const RigidBody& body) {
  Load sum;
  if (out_of_reach(plant, body)) return sum;
  const double k = stiffness(plant), c = damping(plant);
  const Eigen::Matrix3d R_WB = rotation(body.q_WB);
  for (int i = 0; i < kContactPoints; ++i) {
    const Contact::Point& point = contact.points[static_cast<std::size_t>(i)];
    const Vec3d arm_B = point_B(plant, i);
    const Vec3d p_W = body.p_WB + R_WB * arm_B;
    const double depth = ground_z(plant) - p_W.z();
    if (depth <= 0.0) continue;
    const Vec3d v_W = body.v_WB + R_WB * body.w_WB_B.cross(arm_B);
    const double push = std::max(0.0, k * depth - c * v_W.z());
    Eigen::Vector2d grip = -c * v_W.head<2>();
    if (point.touching) grip -= k * (p_W.head<2>() - point.anchor);
    const double most = plant.friction * push, asked = grip.norm();
    if (asked > most) grip *= most / asked;
    const Vec3d force_W(grip.x(), grip.y(), push);
    sum.force_W += force_W;
    sum.torque_B += arm_B.cross(R_WB.transpose() * force_W);
  }
  return sum;
}

void settle(const Plant& plant, Contact& contact, const RigidBody& body) {
  const bool touched = contact.any_touching;
  contact.any_touching = false;
  if (out_of_reach(plant, body)) {
    if (touched) contact.points = {};
    return;
  }
  const Eigen::Matrix3d R_WB = rotation(body.q_WB);
  for (int i = 0; i < kContactPoints; ++i) {
    Contact::Point& point = contact.points[static_cast<std::size_t>(i)];
    const Vec3d arm_B = point_B(plant, i);
    const Vec3d p_W = body.p_WB + R_WB * arm_B;
    const double depth = ground_z(plant) - p_W.z();
    const Eigen::Vector2d stretch = p_W.head<2>() - point.anchor;
    const double longest = plant.friction * std::max(0.0, depth), length = stretch.norm();
    if (depth <= 0.0) {
      point = Contact::Point{};
    } else if (!point.touching) {
      point = {true, p_W.head<2>()};
      const double speed = -(body.v_WB + R_WB * body.w_WB_B.cross(arm_B)).z();
      contact.hardest_impact = std::max(contact.hardest_impact, speed);
      contact.crashed = contact.crashed || speed > plant.crash_speed || i >= 4;
    } else if (length > longest) {  // sliding: the spring keeps pulling with full friction
      point.anchor += stretch * (1.0 - longest / length);
    }
    contact.any_touching = contact.any_touching || point.touching;
  }
}

}  // namespace halfroll::sim
