"""The autopilot as a value: the same library as the SITL, from Python."""

from __future__ import annotations

import numpy as np
import pytest
from flying import airborne, command, new

from halfroll import _dialect


@pytest.mark.parametrize("vehicle", ["mit-vp", "mit-fp"])
def test_it_takes_off_holds_and_lands_by_itself(vehicle: str) -> None:
    autopilot, world = airborne(vehicle)
    assert autopilot.mode == "Hold"
    assert world.p_WB == pytest.approx([0.0, 0.0, 3.0], abs=0.1)
    assert command(autopilot, _dialect.MAV_CMD_NAV_LAND) == [0]
    autopilot.fly(world, 15000)
    assert abs(world.p_WB[2]) < 0.01
    assert not autopilot.armed


def test_disarmed_rotors_stay_still_whatever_the_link_says() -> None:
    autopilot, world = new()
    autopilot.fly(world, 500)
    gcs = _dialect.MAVLink(None, srcSystem=1, srcComponent=191)
    full = _dialect.MAVLink_set_attitude_target_message(0, 1, 1, 0, [1, 0, 0, 0], 0, 0, 0, 1.0)
    assert command(autopilot, _dialect.MAV_CMD_DO_SET_MODE, 1, 6) == [0]
    for _ in range(50):
        out = autopilot.step(world.gyro, world.accelerometer, world.pose, rx=full.pack(gcs))
        assert list(out.thrust) == [0.0] * 4


def test_many_steps_at_once_are_the_same_steps() -> None:
    one, world = airborne()
    many, twin = one.copy(), world.copy()
    imu, poses = [], []
    for _ in range(300):
        pose = twin.pose
        fresh = pose is not None and pose.t_us == one.t_us + 1000  # the batch dates poses to their own step
        imu.append(np.concatenate([twin.gyro, twin.accelerometer]))
        poses.append(np.concatenate([pose.p_WB, pose.q_WB]) if fresh else np.full(7, np.nan))
        out = one.step(imu[-1][:3], imu[-1][3:], pose if fresh else None)
        twin.step(out.thrust)
    thrusts = many.step_many(np.array(imu), np.array(poses))
    assert thrusts.shape == (300, 4)
    assert np.array_equal(thrusts[-1], np.array(out.thrust, dtype=np.float32))
    assert many.same_state(one)


def test_a_copy_flies_the_same_future() -> None:
    autopilot, world = airborne()
    twin, same_world = autopilot.copy(), world.copy()
    assert twin.same_state(autopilot)
    autopilot.fly(world, 2000)
    assert not twin.same_state(autopilot)
    twin.fly(same_world, 2000)
    assert twin.same_state(autopilot)
    assert np.array_equal(world.p_WB, same_world.p_WB)


def test_a_wrong_shape_is_a_value_error() -> None:
    autopilot, _ = new()
    with pytest.raises(ValueError, match=r"\(N, 6\)"):
        autopilot.step_many(np.zeros((4, 5)))


def test_rotor_commands_stay_inside_the_limits_after_any_sensor_reading() -> None:
    autopilot, _ = airborne()
    rng = np.random.default_rng(5)
    wild = rng.normal(size=(2000, 6)) * 1000.0
    wild[::7] = np.nan
    thrusts = autopilot.step_many(wild)
    assert np.isfinite(thrusts).all()
    assert thrusts.min() >= -3.0
    assert thrusts.max() <= 3.0
