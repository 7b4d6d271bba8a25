"""Motion capture falls silent in flight: down by dead reckoning, and on again when it returns."""

from __future__ import annotations

import pytest
from flying import airborne, command

from halfroll import _dialect, _firmware


def fly_blind(autopilot: _firmware.Autopilot, world: _firmware.World, seconds: float) -> float:
    """Steps without poses; the fastest fall [m/s]."""
    fastest = 0.0
    for _ in range(int(seconds * 1000)):
        world.step(autopilot.step(world.gyro, world.accelerometer).thrust)
        fastest = min(fastest, world.v_WB[2])
    return -fastest


def test_without_a_position_it_lands_slowly_and_disarms() -> None:
    autopilot, world = airborne(scenario="ideal")
    fastest = fly_blind(autopilot, world, 12.0)
    assert fastest < 1.0
    assert abs(world.p_WB[2]) < 0.02
    assert not autopilot.armed


@pytest.mark.parametrize("vehicle", ["mit-vp", "mit-fp"])
def test_a_position_that_returns_is_taken_up_without_a_jump(vehicle: str) -> None:
    autopilot, world = airborne(vehicle)
    fly_blind(autopilot, world, 2.0)
    assert autopilot.mode == "Land"
    height = world.p_WB[2]
    autopilot.fly(world, 1500)
    assert world.p_WB[2] < height + 0.1
    autopilot.fly(world, 15000)
    assert abs(world.p_WB[2]) < 0.02
    assert not autopilot.armed


def test_who_entered_offboard_is_part_of_the_state() -> None:
    autopilot, _ = airborne()
    twin = autopilot.copy()
    assert command(autopilot, _dialect.MAV_CMD_DO_SET_MODE, 1, 6) == [0]
    assert not twin.same_state(autopilot)
