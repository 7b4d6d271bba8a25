// Flat ground. Why: flights begin and end standing; without it there is no takeoff, no landing, no arming at rest.
//
// The local origin is where the centre of mass is while the vehicle stands: the ground lies one leg height below it,
// less what the feet sink in under the weight, so that a vehicle at rest has p_z = 0 exactly.
#pragma once
#include <array>

#include "sim/rigid_body.hpp"

namespace halfroll::sim {

/// Four feet below the arms and, so that a vehicle on its back lies still too, four points as high above.
inline constexpr int kContactPoints = 8;

/// Where each touching point sticks to the ground, and how hard the ground was met so far.
struct Contact {
  struct Point {
    bool touching = false;
    Eigen::Vector2d anchor = Eigen::Vector2d::Zero();  // world x, y
  };
  std::array<Point, kContactPoints> points = {};
  bool any_touching = false;
  double hardest_impact = 0.0;  // [m/s], downwards, of a point that touched down
  bool crashed = false;         // met the ground faster than Plant::crash_speed, or on its back
};

/// Height of the ground in W.
inline double ground_z(const Plant& plant) {
  const double stiffness_per_mass = plant.contact_frequency * plant.contact_frequency / 4;
  return -plant.leg_height + plant.gravity / (4 * stiffness_per_mass);
}

/// Push of the ground: spring and damper upwards, never downwards; sideways spring and damper to the anchor, at most
/// friction times the push. `plant.mass` stands for the vehicle's own, whatever it carries.
Load ground_load(const Plant& plant, const Contact& contact, const RigidBody& body);

/// Set the anchor of a point that has just touched down, drag along that of a sliding one, lift that of a free one;
/// note impacts.
void settle(const Plant& plant, Contact& contact, const RigidBody& body);

}  // namespace halfroll::sim
