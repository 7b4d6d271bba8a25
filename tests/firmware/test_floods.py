"""More than a link can carry: the loop's work stays bounded, and what was lost is counted."""

from __future__ import annotations

import numpy as np
from session import Session, hovering

from halfroll import _dialect as dialect


def status_after(flight: Session) -> object:
    flight.run(600)
    return flight.last("SYS_STATUS")


def test_frames_that_are_missing_are_counted_on_their_link() -> None:
    flight = Session()
    flight.run(10)
    for _ in range(50):
        flight.heartbeat()
        flight._ours.seq = (flight._ours.seq + 2) % 256  # one in three never comes
    flight.heartbeat()
    status = status_after(flight)
    assert abs(status.drop_rate_comm - 10000 * 100 / 151) < 150
    assert status.errors_comm == 0


def test_a_frame_with_a_wrong_checksum_is_counted() -> None:
    flight = Session()
    flight.run(10)
    w = flight.world
    broken = bytearray(flight._ours.heartbeat_encode(6, 8, 0, 0, 0).pack(flight._ours))
    broken[-1] ^= 1
    flight.autopilot.step(w.gyro, w.accelerometer, w.pose, rx=bytes(broken))
    assert status_after(flight).errors_comm == 1


def test_a_flood_is_passed_over_and_the_flight_does_not_notice() -> None:
    calm, flooded = hovering(height=5.0), hovering(height=5.0)
    frame = dialect.MAVLink_param_request_read_message(1, 1, b"ATT_WN", -1).pack(flooded._ours)
    answers = 0
    for _ in range(1000):
        w = flooded.world
        out = flooded.autopilot.step(w.gyro, w.accelerometer, w.pose, rx=frame * 90)  # 3.5 kB each millisecond
        answers += sum(1 for link, _, sent in out.tx if link == 0 and sent[7] == 22)
        w.step(out.thrust)
        w = flooded.world
        out = flooded.autopilot.step(w.gyro, w.accelerometer, w.pose, rx=frame * 1000)
        assert not [1 for link, _, sent in out.tx if link == 0 and sent[7] == 22]
        w.step(out.thrust)
    assert answers >= 1000 * 50
    calm.run(2000)
    assert np.array_equal(calm.world.p_WB, flooded.world.p_WB)
    assert status_after(flooded).errors_count4 == 65535  # as much as fits
