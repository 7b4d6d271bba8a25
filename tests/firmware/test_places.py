"""Origin, home and position on earth agree with each other and with the local frame, to 2 cm within a kilometre."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from session import Session

from halfroll import _firmware

A, E2 = 6378137.0, 6.69437999014e-3
GPS_GLOBAL_ORIGIN, HOME_POSITION, GLOBAL_POSITION_INT, LOCAL_POSITION = 49, 242, 33, 32
SET_ORIGIN, REQUEST_MESSAGE, SET_HOME = 611, 512, 179
CLOSE_M = 0.02

near = st.floats(-700.0, 700.0)
heights = st.floats(0.0, 300.0)


def metres_per_degree(lat_deg: float, alt: float) -> tuple[float, float]:
    s = math.sin(math.radians(lat_deg))
    north = A * (1 - E2) / (1 - E2 * s * s) ** 1.5 + alt
    east = (A / math.sqrt(1 - E2 * s * s) + alt) * math.cos(math.radians(lat_deg))
    return math.radians(north), math.radians(east)


class Placed(Session):
    """Standing wherever it is put, on sensors of our own making."""

    def put(self, x: float, y: float, z: float) -> None:
        for _ in range(400):
            t_us = self.autopilot.t_us + 1000
            pose = _firmware.PoseFix(t_us, [x, y, z], [1, 0, 0, 0]) if t_us % 10000 == 0 else None
            out = self.autopilot.step([0.0] * 3, [0.0, 0.0, 9.81], pose)
            for link, _, sent in out.tx:
                if link == 0:
                    self.heard += [(self.t_ms, m) for m in self._theirs.parse_buffer(sent) or ()]

    def place(self, origin: tuple[float, float, float]) -> None:
        lat, lon, alt = origin
        frame = self._ours.command_int_encode(
            1, 1, 0, SET_ORIGIN, 0, 0, 0, 0, 0, 0, round(lat * 1e7), round(lon * 1e7), alt
        )
        self.autopilot.service(frame.pack(self._ours))

    def asked(self, message: int) -> None:
        frame = self._ours.command_long_encode(1, 1, REQUEST_MESSAGE, 0, message, 0, 0, 0, 0, 0, 0)
        for link, _, sent in self.autopilot.service(frame.pack(self._ours)):
            if link == 0:
                self.heard += [(self.t_ms, m) for m in self._theirs.parse_buffer(bytes(sent)) or ()]


@pytest.mark.parametrize(
    "origin",
    [(47.397742, 8.545594, 488.0), (-35.363262, 149.165237, 584.0), (0.0001, -179.9, 0.0), (64.1, -21.9, 50.0)],
)
@settings(max_examples=10)
@given(x=near, y=near, z=heights)
def test_every_message_about_a_place_means_the_same_place(
    origin: tuple[float, float, float], x: float, y: float, z: float
) -> None:
    flight = Placed()
    flight.place(origin)
    flight.put(x, y, z)
    for message in (GPS_GLOBAL_ORIGIN, HOME_POSITION, GLOBAL_POSITION_INT, LOCAL_POSITION):
        flight.asked(message)
    told = flight.last("GPS_GLOBAL_ORIGIN")
    assert (told.latitude, told.longitude) == (round(origin[0] * 1e7), round(origin[1] * 1e7))
    assert told.altitude == round(origin[2] * 1e3)
    north, east = metres_per_degree(told.latitude * 1e-7, told.altitude * 1e-3)

    def local(lat: int, lon: int, alt_mm: int) -> tuple[float, float, float]:
        dlat, dlon = (lat - told.latitude) * 1e-7, (lon - told.longitude) * 1e-7
        return dlat * north, -dlon * east, (alt_mm - told.altitude) * 1e-3

    position, home, here = (
        flight.last("GLOBAL_POSITION_INT"),
        flight.last("HOME_POSITION"),
        flight.last("LOCAL_POSITION_NED"),
    )
    assert local(position.lat, position.lon, position.alt) == pytest.approx((x, y, z), abs=CLOSE_M)
    assert (here.x, -here.y, -here.z) == pytest.approx((x, y, z), abs=CLOSE_M)
    at_home = (home.x, -home.y, -home.z)
    assert local(home.latitude, home.longitude, home.altitude) == pytest.approx(at_home, abs=CLOSE_M)
    assert position.relative_alt * 1e-3 == pytest.approx(z - at_home[2], abs=CLOSE_M)


def test_a_home_that_is_given_comes_back_as_the_same_integers() -> None:
    flight = Placed()
    flight.put(0.0, 0.0, 0.0)
    lat, lon = 473984123, 85461234
    frame = flight._ours.command_int_encode(1, 1, 0, SET_HOME, 0, 0, 0, 0, 0, 0, lat, lon, 490.123)
    flight.autopilot.service(frame.pack(flight._ours))
    flight.asked(HOME_POSITION)
    home = flight.last("HOME_POSITION")
    assert (home.latitude, home.longitude, home.altitude) == (lat, lon, 490123)
