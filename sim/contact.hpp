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

/// Where each touching point sticks to the ground.
struct Contact {
  struct Point {
    bool touching = false;
    Eigen::Vector2d anchor = Eigen::Vector2d::Zero();  // world x, y
  };
  std::array<Point, kContactPoints> points = {};
};

/// Height of the ground in W.
double ground_z(const Plant& plant);

/// Push of the ground: spring and damper upwards, never downwards; sideways spring and damper to the anchor, at most
/// friction times the push.
Load ground_load(const Plant& plant, const Contact& contact, const RigidBody& body);

/// Set the anchor of a point that has just touched down, drag along that of a sliding one, lift that of a free one.
void settle(const Plant& plant, Contact& contact, const RigidBody& body);

}  // namespace halfroll::sim
