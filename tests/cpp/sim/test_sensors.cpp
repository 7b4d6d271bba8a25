// Sensors: statistics of the noise, age of the poses, independence of the streams.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "sim/sitl/scenario_file.hpp"
#include "sim/world.hpp"

using namespace halfroll;
using namespace halfroll::sim;

namespace {

const Scenario kIdeal;
Scenario nominal() { return sitl::make_scenario("nominal"); }

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
  const Random random{seed};
  Sensors sensors = make_sensors(scenario, random);
  Truth truth;
  truth.specific_force_B = {0, 0, 9.81};
  truth.rotor_speed_rad_s.fill(500.0);
  truth.nominal_rotor_speed_rad_s = 500.0;
  for (int n = 0; n < milliseconds; ++n) {
    truth.t_us = static_cast<std::uint64_t>(n) * 1000;
    look(truth.t_us, read(scenario, random, sensors, truth));
  }
}

}  // namespace

TEST_CASE("noise has the deviation the scenario names") {
  Spread gyro, accelerometer, position, attitude;
  stand(nominal(), 5, 400000, [&](std::uint64_t, const Measurements& r) {
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
  stand(nominal(), 5, 2000000, [&](std::uint64_t, const Measurements& r) {
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
  Scenario late;
  late.mocap.delay_us = 23000;
  const Model model(Plant{}, late);
  RigidBody body;
  body.p_WB = {0, 0, 10};
  body.v_WB = {1, 0, 0};
  World w = start(model, 0, body);
  int delivered = 0;
  for (int n = 0; n < 500; ++n) {
    step(model, w, {});
    if (!w.readings.pose) continue;
    ++delivered;
    CHECK(w.readings.pose->t_us % 10000 == 0);
    CHECK(w.t_us - w.readings.pose->t_us == 23000);
    CHECK(w.readings.pose->p_WB.x() == doctest::Approx(1e-6 * static_cast<double>(w.readings.pose->t_us)));
  }
  CHECK(delivered == 48);
}

TEST_CASE("jitter delays by no more than it says, never out of order; dropouts lose their share") {
  Scenario rough;
  rough.mocap.delay_us = 5000;
  rough.mocap.jitter_us = 30000;
  rough.mocap.dropout = 0.2;
  std::uint64_t last = 0, latest = 0, earliest = 1000000;
  int delivered = 0;
  stand(rough, 3, 200000, [&](std::uint64_t t_us, const Measurements& r) {
    if (!r.pose) return;
    ++delivered;
    CHECK(r.pose->t_us >= last);
    last = r.pose->t_us;
    latest = std::max(latest, t_us - r.pose->t_us);
    earliest = std::min(earliest, t_us - r.pose->t_us);
  });
  CHECK(delivered == doctest::Approx(16000).epsilon(0.02));
  CHECK(earliest < 7000);
  CHECK(latest > 30000);
  CHECK(latest <= 36000);
}

TEST_CASE("outliers are as many and as far as the scenario says") {
  Scenario wrong;
  wrong.mocap.outlier = 0.05;
  wrong.mocap.outlier_size = 2.0;
  int far = 0, all = 0;
  Spread x;
  stand(wrong, 3, 400000, [&](std::uint64_t, const Measurements& r) {
    if (!r.pose) return;
    ++all;
    if (r.pose->p_WB.norm() > 0) ++far, x.add(r.pose->p_WB.x());
  });
  CHECK(far == doctest::Approx(0.05 * all).epsilon(0.1));
  CHECK(x.deviation() == doctest::Approx(2.0).epsilon(0.06));
}

TEST_CASE("lost motion capture says nothing, frozen motion capture the same thing with fresh stamps") {
  Scenario failing = nominal();
  failing.faults[0] = {Fault::Kind::kMocapLost, 1.0, 2.0};
  failing.faults[1] = {Fault::Kind::kMocapFrozen, 3.0, 4.0};
  std::vector<PoseFix> frozen;
  int lost = 0;
  stand(failing, 3, 5000, [&](std::uint64_t, const Measurements& r) {
    if (!r.pose) return;
    if (r.pose->t_us >= 1000000 && r.pose->t_us < 2000000) ++lost;
    if (r.pose->t_us >= 3000000 && r.pose->t_us < 4000000) frozen.push_back(*r.pose);
  });
  CHECK(lost == 0);
  REQUIRE(frozen.size() == 100);
  for (const PoseFix& pose : frozen) CHECK(pose.p_WB == frozen[0].p_WB);
  CHECK(frozen[99].t_us - frozen[0].t_us == 990000);
}

TEST_CASE("the ideal scenario shows the truth at once") {
  stand(sitl::make_scenario("ideal"), 9, 100, [](std::uint64_t t_us, const Measurements& r) {
    CHECK(r.imu.w_WB_B.norm() == 0.0F);
    CHECK(r.imu.specific_force_B.z() == 9.81F);
    CHECK(r.pose.has_value() == (t_us % 10000 == 0));
    if (r.pose) CHECK((r.pose->t_us == t_us && r.pose->q_WB == Quat{}));
    CHECK_FALSE(r.gps.has_value());
  });
}

TEST_CASE("a bias is drawn at switch-on and walks with the square root of time") {
  Scenario biased;
  biased.gyro.bias = 0.02;
  biased.gyro.bias_walk = 0.001;
  Spread at_first, walked;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    double first = 0, last = 0;
    stand(biased, seed, 10001, [&](std::uint64_t t_us, const Measurements& r) {
      if (t_us == 0) first = r.imu.w_WB_B.x();
      last = r.imu.w_WB_B.x();
    });
    at_first.add(first), walked.add(last - first);
  }
  CHECK(at_first.deviation() == doctest::Approx(0.02).epsilon(0.15));
  CHECK(walked.deviation() == doctest::Approx(0.001 * std::sqrt(10.0)).epsilon(0.15));
}

TEST_CASE("a reading is a whole number of converter steps and never beyond the range") {
  Scenario coarse;
  coarse.accelerometer.step = 0.5;
  coarse.accelerometer.range = 8.0;
  coarse.accelerometer.noise = 1.0;
  bool clipped = false;
  stand(coarse, 2, 1000, [&](std::uint64_t, const Measurements& r) {
    const float z = r.imu.specific_force_B.z(), x = r.imu.specific_force_B.x();
    CHECK(x == 0.5F * std::round(2.0F * x));
    CHECK(z <= 8.0F);
    clipped = clipped || z == 8.0F;
  });
  CHECK(clipped);
}

TEST_CASE("rotors shake the accelerometer at their own frequency") {
  Scenario shaken;
  shaken.accelerometer.vibration = 0.3;
  Spread x;
  int crossings = 0;
  double before = 0;
  stand(shaken, 2, 10000, [&](std::uint64_t, const Measurements& r) {
    const double now = r.imu.specific_force_B.x();
    x.add(now), crossings += before < 0 && now >= 0, before = now;
  });
  CHECK(crossings == doctest::Approx(10 * 500 / (2 * std::acos(-1.0))).epsilon(0.02));
  CHECK(x.deviation() > 0.0);
  CHECK(x.deviation() < 4 * 0.3);
}

TEST_CASE("GPS is late, wanders slowly, and knows how good it is; pressure drifts; the field points north and down") {
  const Scenario outdoor = sitl::make_scenario("outdoor");
  Spread height, east;
  stand(outdoor, 4, 2000000, [&](std::uint64_t t_us, const Measurements& r) {
    CHECK_FALSE(r.pose.has_value());
    if (r.gps) {
      CHECK(t_us - r.gps->t_us == 100000);
      CHECK(r.gps->horizontal_deviation == doctest::Approx(std::hypot(0.15, 0.3)));
      east.add(r.gps->p_WB.y());
    }
    if (r.barometer) height.add(r.barometer->height);
    if (r.magnetometer) CHECK(r.magnetometer->field_B.dot(Vec3(0.454F, 0.F, -0.891F)) > 0.9F);
  });
  CHECK(east.count == 19999);
  CHECK(east.deviation() == doctest::Approx(std::hypot(0.15, 0.3)).epsilon(0.35));  // 17 correlation times
  CHECK(height.count == 100000);
  CHECK(height.deviation() > 0.1);
}

TEST_CASE("adding a sensor does not change what the others say") {
  Scenario more = nominal();
  more.barometer = {20000, 0.1, 0.01};
  more.gps = sitl::make_scenario("outdoor").gps;
  more.mocap.outlier = 1e-9;
  std::vector<Imu> without, with;
  std::vector<PoseFix> poses_without, poses_with;
  stand(nominal(), 11, 500, [&](std::uint64_t, const Measurements& r) {
    without.push_back(r.imu);
    if (r.pose) poses_without.push_back(*r.pose);
  });
  stand(more, 11, 500, [&](std::uint64_t, const Measurements& r) {
    with.push_back(r.imu);
    if (r.pose) poses_with.push_back(*r.pose);
  });
  CHECK(without == with);
  REQUIRE(poses_without.size() == poses_with.size());
  for (std::size_t i = 0; i < poses_with.size(); ++i) CHECK(poses_with[i].p_WB == poses_without[i].p_WB);
}
