// Sensors as rows of numbers. Why: thousands of steps from Python should cost what they cost in C++.
#pragma once
#include <cmath>

#include "bindings.hpp"

namespace halfroll::bindings {

using FloatRows = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// imu (N, 6): rate, specific force; poses (N, 7): position, quaternion, NaN where none came. Read without the GIL.
class Recording {
 public:
  Recording(const FloatRows& imu, const std::optional<FloatRows>& poses) : imu_(imu), poses_(poses) {
    if (imu.ndim() != 2 || imu.shape(1) != 6) throw py::value_error("imu must have shape (N, 6)");
    if (poses && (poses->ndim() != 2 || poses->shape(1) != 7 || poses->shape(0) != imu.shape(0))) {
      throw py::value_error("poses must have shape (N, 7), a row for each row of imu");
    }
  }

  py::ssize_t size() const { return imu_.shape(0); }

  /// What came in millisecond i, which is at t_us; a pose is of that instant.
  Measurements at(py::ssize_t i, std::uint64_t t_us) const {
    Measurements measured;
    const float* sample = imu_.data() + 6 * i;
    measured.imu = {Vec3(sample), Vec3(sample + 3)};
    const float* pose = poses_ ? poses_->data() + 7 * i : nullptr;
    if (pose != nullptr && !std::isnan(*pose)) {
      measured.pose.emplace();
      measured.pose->t_us = t_us;
      measured.pose->p_WB = Vec3(pose);
      measured.pose->q_WB = {pose[3], pose[4], pose[5], pose[6]};
    }
    return measured;
  }

 private:
  FloatRows imu_;
  std::optional<FloatRows> poses_;
};

}  // namespace halfroll::bindings
