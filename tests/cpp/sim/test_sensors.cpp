// Sensors: statistics of the noise, age of the poses.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "sim/world.hpp"

using namespace halfroll;
using namespace halfroll::sim;

namespace {

struct Spread {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double x) { sum += x, squares += x * x, ++count; }
  double mean() const { return sum / count; }
  double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
};

/// Calls `look` with each reading of a body at rest at the origin, one a millisecond.
template <typename Look>
void stand(const Scenario& scenario, std::uint64_t seed, int milliseconds, const Look& look) {
  Sensors sensors = make_sensors(scenario, seed);
  for (int n = 0; n < milliseconds; ++n) {
    const auto t_us = static_cast<std::uint64_t>(n) * 1000;
    look(t_us, read(scenario, sensors, t_us, RigidBody{}, Vec3d(0, 0, 9.81)));
  }
}

}  // namespace

TEST_CASE("normal numbers have mean 0, variance 1, no skew, and a normal share beyond 1 and 2 deviations") {
  Noise noise{1};
  double sum = 0, squares = 0, cubes = 0;
  int beyond_1 = 0, beyond_2 = 0;
  const int n = 400000;
  for (int i = 0; i < n; ++i) {
    const double x = noise.normal();
    sum += x, squares += x * x, cubes += x * x * x;
    beyond_1 += std::abs(x) > 1, beyond_2 += std::abs(x) > 2;
  }
  CHECK(std::abs(sum / n) < 0.006);  // 4 standard errors
  CHECK(squares / n == doctest::Approx(1).epsilon(0.01));
  CHECK(std::abs(cubes / n) < 0.02);
  CHECK(1.0 * beyond_1 / n == doctest::Approx(0.3173).epsilon(0.02));
  CHECK(1.0 * beyond_2 / n == doctest::Approx(0.0455).epsilon(0.03));
}

TEST_CASE("noise of the nominal scenario has the sizes it claims") {
  Spread gyro, accelerometer, position, attitude;
  stand(kNominal, 3, 400000, [&](std::uint64_t, const Measurements& r) {
    gyro.add(r.imu.w_WB_B.y());
    accelerometer.add(r.imu.specific_force_B.z() - 9.81F);
    if (r.pose) position.add(r.pose->p_WB.x()), attitude.add(2 * r.pose->q_WB.x);
  });
  CHECK(gyro.deviation() == doctest::Approx(0.01).epsilon(0.02));
  CHECK(accelerometer.deviation() == doctest::Approx(0.1).epsilon(0.02));
  CHECK(position.deviation() == doctest::Approx(0.001).epsilon(0.02));
  CHECK(attitude.deviation() == doctest::Approx(std::hypot(0.2, 0.03) * kDegree).epsilon(0.1));
  CHECK(std::abs(gyro.mean()) < 1e-4);
  CHECK(position.count == 39999);  // 100 Hz, one still on its way
}

TEST_CASE("the slow attitude error forgets itself within its correlation time") {
  std::vector<double> x;
  stand(kNominal, 5, 2000000, [&](std::uint64_t, const Measurements& r) {
    if (r.pose) x.push_back(r.pose->q_WB.z);
  });
  const auto correlation = [&](std::size_t lag) {
    double product = 0, square = 0;
    for (std::size_t i = 0; i + lag < x.size(); ++i) product += x[i] * x[i + lag], square += x[i] * x[i];
    return product / square;
  };
  CHECK(correlation(50) == doctest::Approx(std::exp(-1)).epsilon(0.2));  // 0.5 s
}

TEST_CASE("a pose is delivered late and carries the time it was taken") {
  const Plant plant;
  Scenario late = kIdeal;
  late.pose_delay_us = 23000;
  RigidBody body;
  body.p_WB = {0, 0, 10};
  body.v_WB = {1, 0, 0};
  World w = start(plant, late, 0, body);
  int delivered = 0;
  for (int n = 0; n < 500; ++n) {
    w = step(plant, late, w, {});
    if (!w.readings.pose) continue;
    ++delivered;
    CHECK(w.readings.pose->t_us % 10000 == 0);
    CHECK(w.t_us - w.readings.pose->t_us == 23000);
    CHECK(w.readings.pose->p_WB.x() == doctest::Approx(1e-6 * static_cast<double>(w.readings.pose->t_us)));
  }
  CHECK(delivered == 48);
}

TEST_CASE("the ideal scenario shows the truth at once") {
  stand(kIdeal, 9, 100, [](std::uint64_t t_us, const Measurements& r) {
    CHECK(r.imu.w_WB_B.norm() == 0.0F);
    CHECK(r.imu.specific_force_B.z() == 9.81F);
    CHECK(r.pose.has_value() == (t_us % 10000 == 0));
    if (r.pose) CHECK((r.pose->t_us == t_us && r.pose->q_WB == Quat{}));
  });
}
