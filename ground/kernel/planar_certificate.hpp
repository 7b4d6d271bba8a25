// The proof for flight that turns over: in one vertical plane, any attitude, thrust of either sign, zero force
// included.
//
// Why apart from certificate.hpp: counted from upright, attitude has no meaning upside down, and at zero force the
// direction of the force is 0/0. In a plane attitude is one angle, whose rates do not change when the force is divided
// by anything positive, or by anything negative. So next to a reversal, at time t_e, force is divided by t - t_e:
//   F = (t - t_e) G,   G a polynomial that is not zero there;   thrust = s sgn(t - t_e) m (t - t_e) |G|
// and everything that rotors need is made of G and its derivatives by time. The coefficients that make F zero at t_e
// are zero but for rounding, and taken as zero.
#pragma once
#include "certificate.hpp"

namespace halfroll::planner {

/// A piece in the x-z plane, at constant yaw.
struct PlanarPiece {
  Coefficients path;
  double duration;
  double sign;  // of the thrust
  bool begins_at_reversal, ends_at_reversal;
  double speed_max = kNoLimit;
};

/// bound of the result: 0..3 rotor thrust, 4..7 how quickly it changes, 8..11 the command that it needs, 12 body rate,
/// 13 speed, 14 height. Other limits are not looked at.
Certificate certify_planar(const std::vector<PlanarPiece>& pieces, const Vehicle& vehicle, const Limits& limits);

}  // namespace halfroll::planner
