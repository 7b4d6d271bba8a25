// The estimator by itself for Python: what the oracle is compared with.
#include "core/estimator.hpp"

#include <algorithm>

#include "recording.hpp"

namespace halfroll::bindings {
namespace {

class BoundEstimator {
 public:
  explicit BoundEstimator(const Params& params) : params_(params) {}

  Estimate step(const Vec3& w_WB_B, const Vec3& specific_force_B, const std::optional<PoseFix>& pose, bool flying) {
    Measurements measured;
    measured.imu = {w_WB_B, specific_force_B};
    measured.pose = pose;
    const Estimate estimate = estimator_.step(t_us_, measured, flying, params_);
    t_us_ += kStepUs;
    return estimate;
  }
  /// Positions (N, 3).
  py::array_t<float> step_many(const FloatRows& imu, const std::optional<FloatRows>& poses, bool flying) {
    const Recording recording(imu, poses);
    py::array_t<float> positions({recording.size(), py::ssize_t{3}});
    float* position = positions.mutable_data();
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < recording.size(); ++i, position += 3, t_us_ += kStepUs) {
      const Vec3 p_WB = estimator_.step(t_us_, recording.at(i, t_us_), flying, params_).p_WB;
      std::copy(p_WB.begin(), p_WB.end(), position);
    }
    return positions;
  }
  const Estimator& estimator() const { return estimator_; }

 private:
  Params params_;
  Estimator estimator_;
  std::uint64_t t_us_ = 0;
};

}  // namespace

void bind_estimator(py::module_& m) {
  py::class_<BoundEstimator>(m, "Estimator", "The estimator of the firmware; its first step is at time 0.")
      .def(py::init<const Params&>(), "params"_a)
      .def("step", &BoundEstimator::step, "w_WB_B"_a, "specific_force_B"_a, "pose"_a = std::nullopt, py::kw_only(),
           "flying"_a = true, "Advance 1 ms: gyro [rad/s], accelerometer [m/s^2], perhaps a pose -> Estimate.")
      .def("step_many", &BoundEstimator::step_many, "imu"_a, "poses"_a = std::nullopt, py::kw_only(), "flying"_a = true,
           "N steps: imu (N, 6), poses (N, 7) or None (NaN rows: none) -> positions (N, 3) [m].")
      .def_property_readonly(
          "covariance", [](const BoundEstimator& e) { return e.estimator().covariance().matrix(); },
          "(15, 15) of attitude error in W, velocity, position, gyro bias, accelerometer bias; every 10 ms and when a "
          "measurement has been taken in it is that of now.")
      .def_property_readonly("gyro_bias", [](const BoundEstimator& e) { return e.estimator().gyro_bias(); })
      .def_property_readonly("accelerometer_bias",
                             [](const BoundEstimator& e) { return e.estimator().accelerometer_bias(); })
      .def_property_readonly("used", [](const BoundEstimator& e) { return e.estimator().health().used; })
      .def_property_readonly("rejected", [](const BoundEstimator& e) { return e.estimator().health().rejected; });
}

}  // namespace halfroll::bindings
