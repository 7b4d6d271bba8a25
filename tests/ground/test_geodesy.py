"""The local formula against the Earth itself: geocentric coordinates and a tangent plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint, global_from_local, local_from_global

ORIGINS = [DEFAULT_ORIGIN, GeoPoint(-35.363262, 149.165237, 584.0), GeoPoint(0.0, -179.9999, 0.0)]


def geocentric(point: GeoPoint) -> np.ndarray:
    lat, lon = math.radians(point.lat_deg), math.radians(point.lon_deg)
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
    horizontal = (n + point.alt) * math.cos(lat)
    return np.array(
        [horizontal * math.cos(lon), horizontal * math.sin(lon), (n * (1 - e2) + point.alt) * math.sin(lat)]
    )


def tangent_plane(origin: GeoPoint, point: GeoPoint) -> np.ndarray:
    """North, west, up of the plane that touches the ellipsoid at the origin."""
    lat, lon = math.radians(origin.lat_deg), math.radians(origin.lon_deg)
    up = np.array([math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)])
    west = np.array([math.sin(lon), -math.cos(lon), 0.0])
    offset = geocentric(point) - geocentric(origin)
    return np.array([np.dot(np.cross(west, up), offset), np.dot(west, offset), np.dot(up, offset)])


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("position", [(100.0, 0.0, 0.0), (0.0, 100.0, 0.0), (-70.0, 70.0, 0.0), (0.0, 0.0, 50.0)])
def test_within_100_m_the_formula_is_the_tangent_plane_to_2_mm(
    origin: GeoPoint, position: tuple[float, float, float]
) -> None:
    point = global_from_local(origin, position)
    np.testing.assert_allclose(tangent_plane(origin, point), position, atol=0.002)


def test_at_1_km_the_tangent_plane_is_8_cm_lower() -> None:
    # The plane leaves the Earth's curve by d²/2R; so both sides must use the formula, not a library.
    point = global_from_local(DEFAULT_ORIGIN, (1000.0, 0.0, 0.0))
    assert tangent_plane(DEFAULT_ORIGIN, point)[2] == pytest.approx(-0.0785, abs=0.001)


@given(st.sampled_from(ORIGINS), *[st.floats(-5000, 5000)] * 3)
def test_there_and_back_is_the_same_place(origin: GeoPoint, n: float, w: float, u: float) -> None:
    back = local_from_global(origin, global_from_local(origin, (n, w, u)))
    np.testing.assert_allclose(back, (n, w, u), atol=1e-7)


def test_a_larger_longitude_is_to_the_east() -> None:
    east = DEFAULT_ORIGIN._replace(lon_deg=DEFAULT_ORIGIN.lon_deg + 0.001)
    assert local_from_global(DEFAULT_ORIGIN, east)[1] == pytest.approx(-75.5, abs=0.1)


def test_a_metre_across_the_date_line_is_a_metre() -> None:
    origin = GeoPoint(10.0, 179.999999, 0.0)
    point = global_from_local(origin, (0.0, -1.0, 0.0))
    assert point.lon_deg < 0
    assert local_from_global(origin, point)[1] == pytest.approx(-1.0, abs=1e-6)
