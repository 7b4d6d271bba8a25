"""Motion capture that comes by MAVLink: the three messages, their clocks, and who is believed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from flying import airborne, command, new

from halfroll import _dialect, _firmware
from halfroll.wire import frames

Pose = tuple[int, np.ndarray, np.ndarray]  # stamp [us], position and quaternion on the wire
SENDER = _dialect.MAVLink(None, srcSystem=1, srcComponent=197)
UNKNOWN = [math.nan] + [0.0] * 20


def odometry(pose: Pose, frame: int = _dialect.MAV_FRAME_LOCAL_NED) -> bytes:
    stamp, p, q = pose
    fields = (frame, _dialect.MAV_FRAME_BODY_FRD, *map(float, p), list(map(float, q)), 0, 0, 0, 0, 0, 0)
    message = _dialect.MAVLink_odometry_message(stamp, *fields, UNKNOWN, UNKNOWN)
    return bytes(message.pack(SENDER))


def att_pos_mocap(pose: Pose) -> bytes:
    stamp, p, q = pose
    message = _dialect.MAVLink_att_pos_mocap_message(stamp, list(map(float, q)), *map(float, p), UNKNOWN)
    return bytes(message.pack(SENDER))


def vision_position_estimate(pose: Pose) -> bytes:
    stamp, p, (w, x, y, z) = pose
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(2 * (w * y - z * x))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    message = _dialect.MAVLink_vision_position_estimate_message(stamp, *map(float, p), roll, pitch, yaw, UNKNOWN)
    return bytes(message.pack(SENDER))


class Room:
    """A tracker that sees the truth at 100 Hz and sends it 12 ms later, on its own clock or on the vehicle's."""

    def __init__(self, pack: Callable[[Pose], bytes], clock_us: int = 0, shift: tuple[float, float, float] = (0, 0, 0)):
        self._pack, self._clock_us, self._shift = pack, clock_us, np.array(shift)
        self._on_the_way: list[tuple[int, bytes]] = []

    def see(self, autopilot: _firmware.Autopilot, world: _firmware.World) -> bytes:
        now = autopilot.t_us + 1000
        if now % 10000 == 0:
            p, q = frames.to_wire(world.p_WB + self._shift), frames.to_wire(world.q_WB)
            self._on_the_way.append((now + 12000, self._pack((now + self._clock_us, p, q))))
        if self._on_the_way and self._on_the_way[0][0] <= now:
            return self._on_the_way.pop(0)[1]
        return b""

    def fly(self, autopilot: _firmware.Autopilot, world: _firmware.World, seconds: float, own: bool = False) -> None:
        for _ in range(int(seconds * 1000)):
            rx = self.see(autopilot, world)
            pose = world.pose if own else None
            world.step(autopilot.step(world.gyro, world.accelerometer, pose, rx=rx, link=1).thrust)


@pytest.mark.parametrize("pack", [odometry, att_pos_mocap, vision_position_estimate])
def test_it_takes_off_and_hovers_by_poses_that_come_by_link_alone(pack: Callable[[Pose], bytes]) -> None:
    autopilot, world = new()
    room = Room(pack)
    room.fly(autopilot, world, 1.0)
    assert autopilot.estimate.position_valid
    assert command(autopilot, _dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 2.0) == [0]
    assert command(autopilot, _dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0) == [0]
    room.fly(autopilot, world, 6.0)
    assert world.p_WB == pytest.approx([0.0, 0.0, 2.0], abs=0.05)
    assert autopilot.estimate.p_WB == pytest.approx(world.p_WB, abs=0.005)
    assert autopilot.estimate.aiding == _firmware.Aiding.POSE


@pytest.mark.parametrize("clock_us", [1_700_000_000_000_000, -(10**9)])
def test_a_stamp_of_another_clock_counts_from_its_arrival(clock_us: int) -> None:
    autopilot, world = airborne()
    Room(odometry, clock_us=max(clock_us, -autopilot.t_us // 2)).fly(autopilot, world, 3.0)
    assert autopilot.estimate.position_valid
    assert autopilot.estimate.p_WB == pytest.approx(world.p_WB, abs=0.02)


def test_the_vehicle_s_own_motion_capture_goes_before_any_by_link() -> None:
    autopilot, world = airborne()
    Room(odometry, shift=(5.0, 0.0, 0.0)).fly(autopilot, world, 2.0, own=True)
    assert autopilot.estimate.resets == 0
    assert autopilot.estimate.p_WB == pytest.approx(world.p_WB, abs=0.01)


def test_when_its_own_falls_silent_the_link_takes_over_with_a_jump_that_is_counted() -> None:
    autopilot, world = airborne()
    Room(odometry, shift=(5.0, 0.0, 0.0)).fly(autopilot, world, 3.0)
    assert autopilot.estimate.resets == 1
    assert autopilot.estimate.p_WB == pytest.approx(np.add(world.p_WB, [5.0, 0.0, 0.0]), abs=0.02)


def test_poses_by_link_can_be_switched_off() -> None:
    setup = _firmware.vehicle_setup("mit-vp")
    setup.params["EST_SENSORS"] = 31 - 2
    autopilot, world = _firmware.Autopilot(setup.vehicle, setup.params), _firmware.World(setup.plant, "nominal", 3)
    Room(odometry).fly(autopilot, world, 1.0)
    assert not autopilot.estimate.position_valid


def test_a_pose_in_a_frame_that_is_not_understood_is_dropped_and_said() -> None:
    autopilot, world = new()
    rx = odometry((1000, np.zeros(3), np.array([1.0, 0, 0, 0])), frame=_dialect.MAV_FRAME_BODY_FRD)
    out = autopilot.step(world.gyro, world.accelerometer, rx=rx, link=1)
    parser = _dialect.MAVLink(None)
    heard = [m for _, _, frame in out.tx for m in parser.parse_buffer(bytes(frame)) or []]
    assert "Command: pose dropped (frame 12)" in [m.text for m in heard if m.get_type() == "STATUSTEXT"]
