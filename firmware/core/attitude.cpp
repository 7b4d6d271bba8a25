#include "core/attitude.hpp"

#include "core/quaternion.hpp"

namespace halfroll {

// q and -q are one attitude, hence the sign of q_e0: the short way is taken, and it is never 0, so a body that points
// exactly the wrong way still turns. The last two terms cancel gyroscopic and moving-target torques exactly.
Wrench attitude_wrench(const Quat& q_WB, const Vec3& w_WB_B, const Reference& reference, const Vehicle& vehicle,
                       const Params& params) {
  const Vec3& inertia = vehicle.inertia;
  const float wn = params.att_natural_frequency;
  const Vec3 kp = 2.F * wn * wn * inertia;                  // Eq 22: Kp = 2 J wn^2
  const Vec3 kd = 2.F * params.att_damping * wn * inertia;  //        Kd = 2 zeta wn J

  const Quat q_BD = normalised(conj(q_WB) * reference.q_WD);  // Eq 21: q_e = q* q_d
  if (params.attitude_law == 1.F) {                           // as printed: turns away from its reference
    return {reference.thrust, -q_BD.w * kp.cwiseProduct(vec(q_BD)) - kd.cwiseProduct(w_WB_B - reference.w_WD_D)};
  }
  const float sign = q_BD.w < 0.F ? -1.F : 1.F;
  const Vec3 w_WD_B = rotate(q_BD, reference.w_WD_D);
  const Vec3 dw_WD_B = rotate(q_BD, reference.dw_WD_D);
  const Vec3 momentum = inertia.cwiseProduct(w_WB_B);
  return {reference.thrust, sign * kp.cwiseProduct(vec(q_BD)) - kd.cwiseProduct(w_WB_B - w_WD_B) +
                                w_WB_B.cross(momentum) + inertia.cwiseProduct(dw_WD_B - w_WB_B.cross(w_WD_B))};
}

}  // namespace halfroll
