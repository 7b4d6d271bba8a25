// Gyro and accelerometer: bias, bias walk, noise, vibration, range, converter steps - in this order, as in the part.
#pragma once
#include "sim/sensors.hpp"

namespace halfroll::sim {

Imu read_imu(const Scenario& scenario, const Random& random, Sensors& sensors, const Truth& truth);

}  // namespace halfroll::sim
