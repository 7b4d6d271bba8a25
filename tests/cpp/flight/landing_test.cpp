#include "core/landing.hpp"

#include <doctest/doctest.h>

using namespace halfroll;

TEST_CASE("rising leaves the ground, resting without enough thrust to fly is landing") {
  LandedDetector detector;
  Estimate e;
  detector.step(e, 0.F, 5.6F, false);
  CHECK(detector.step(e, 5.6F, 5.6F, true));
  e.p_WB.z() = 0.2F;
  CHECK_FALSE(detector.step(e, 5.8F, 5.6F, true));
  for (int i = 0; i < 20; ++i) CHECK_FALSE(detector.step(e, 2.F, 5.6F, true));
  bool landed = false;
  for (int i = 0; i < 10; ++i) landed = detector.step(e, 2.F, 5.6F, true);
  CHECK(landed);
}

TEST_CASE("hovering is not landing, however still") {
  LandedDetector detector;
  Estimate e;
  detector.step(e, 0.F, 5.6F, false);
  e.p_WB.z() = 1.F;
  for (int i = 0; i < 1000; ++i) CHECK_FALSE(detector.step(e, 5.6F, 5.6F, true));
}

TEST_CASE("in the air, lift that would let it land makes it fall, whatever its speed was") {
  for (float speed = -1.F; speed < 3.F; speed += 0.01F) {
    LandedDetector detector;
    Estimate e;
    detector.step(e, 0.F, 1.F, false);
    e.p_WB.z() = 1.F;
    e.v_WB.z() = speed;
    for (int i = 0; i < 100; ++i) {
      e.v_WB.z() -= 0.4F * kGravity * kReferenceDt;
      CHECK_FALSE(detector.step(e, 0.599F, 1.F, true));
    }
  }
}

TEST_CASE("an inverted hover is not a landing: its thrust is negative, its lift is not") {
  LandedDetector detector;
  Estimate e;
  detector.step(e, 0.F, 5.6F, false);
  e.p_WB.z() = 10.F;
  const float thrust = -5.6F, up_z = -1.F;
  for (int i = 0; i < 1000; ++i) CHECK_FALSE(detector.step(e, thrust * up_z, 5.6F, true));
}
