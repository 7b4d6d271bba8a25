"""The estimator with everything the simulated world can do to its sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from flying import airborne

from halfroll import _firmware


@dataclass
class Errors:
    """Root mean square and worst over a stretch of flight, against the truth."""

    attitude_deg: float
    velocity: float
    position: float
    worst_position: float


def hovered(autopilot: _firmware.Autopilot, world: _firmware.World, seconds: float) -> Errors:
    squares = []
    for _ in range(int(seconds * 100)):
        autopilot.fly(world, 10)
        e = autopilot.estimate  # of the millisecond before this truth: at hover no difference
        turn = _firmware.multiply(_firmware.conjugate(e.q_WB), np.asarray(world.q_WB, dtype=np.float32))
        angle = 2.0 * np.degrees(np.arctan2(np.linalg.norm(turn[1:]), abs(turn[0])))
        v, p = np.linalg.norm(world.v_WB - e.v_WB), np.linalg.norm(world.p_WB - e.p_WB)
        squares.append([angle**2, v**2, p**2])
    rms = np.sqrt(np.mean(squares, axis=0))
    return Errors(*rms, np.sqrt(np.max(squares, axis=0)[2]))


@pytest.mark.parametrize("scenario", ["nominal", "windy", "full"])
def test_in_a_laboratory_it_is_good_to_a_centimetre_a_degree_and_5_cm_per_second(scenario: str) -> None:
    autopilot, world = airborne(scenario=scenario)
    errors = hovered(autopilot, world, 20.0)
    print(f"{scenario}: {errors}")
    assert errors.attitude_deg < 1.0
    assert errors.velocity < 0.05
    assert errors.position < 0.01
    assert autopilot.estimate.resets == 0


def test_outdoors_it_takes_off_and_hovers_by_satellites_barometer_and_compass() -> None:
    autopilot, world = airborne(scenario="outdoor")
    assert autopilot.estimate.aiding == _firmware.Aiding.SATELLITES
    errors = hovered(autopilot, world, 60.0)
    print(f"outdoor: {errors}")
    assert autopilot.mode == "Hold"
    assert autopilot.estimate.position_valid
    assert errors.worst_position < 2.0  # satellites wander 0.3 m across and 0.5 m in height
    assert errors.attitude_deg < 3.0
    assert np.linalg.norm(world.p_WB - [0.0, 0.0, 3.0]) < 2.5
