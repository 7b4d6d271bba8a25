"""What a viewer is given and what it makes of it, without a browser: logs, plans, references and figures."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import halfroll as hr
from halfroll.drawing import ON_PAPER
from halfroll.errors import InputError
from halfroll.planner.plan import Plan
from halfroll.viewer import colours
from halfroll.viewer.from_log import logged
from halfroll.viewer.listening import reference_at
from halfroll.viewer.moments import Moment, Recording, Setting, planned, roll_pitch_heading_deg, saturated
from halfroll.viewer.panels import columns, panels_of, status_html
from halfroll.viewer.sources import recording_of
from halfroll.viewer.stage import limit_marks, rotor_use, thrust_arrows, window
from halfroll.wire.told import ToldPlan, ToldReference, packed, unpacked

BOX = "tests/system/missions/box.plan"
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
numbers = st.floats(-1e3, 1e3)


def moment(t_s: float = 0.0, **known: object) -> Moment:
    return Moment(t_s, np.zeros(3), UPRIGHT, np.zeros(3), np.zeros(3), **known)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def box() -> Plan:
    return hr.plan(BOX)


# Plans and logs as moments


def test_a_plan_flies_through_its_waypoints_at_their_times(box):
    shown = planned(box, "box")
    assert shown.span == pytest.approx((0.0, box.T))
    for due, waypoint in zip(box.times_s, box.waypoints, strict=True):
        here = shown.at(due)
        assert here.p_WB == pytest.approx(waypoint.position, abs=0.01 * max(1.0, here.speed))
        assert here.error_m == 0.0


def test_a_flight_is_shown_beside_its_plan_from_when_that_began(tmp_path, fly_circle):
    log = fly_circle(tmp_path / "flight.ulg")
    shown = logged(log)
    assert {here.mode for here in shown.moments} >= {"OFFBOARD"}
    assert all(here.reference_p is None for here in shown.moments)
    here = shown.moments[len(shown.moments) // 2]
    assert here.rotor_N is not None
    assert len(here.rotor_N) == 4


def test_the_moment_at_a_time_is_the_last_one_not_after_it():
    shown = Recording.of(Setting("", (-3.0, 3.0), 0.2), [moment(t) for t in (1.0, 2.0, 3.0)])
    assert [shown.at(t).t_s for t in (0.0, 1.0, 1.99, 2.0, 9.0)] == [1.0, 1.0, 1.0, 2.0, 3.0]


@given(st.floats(0.0, 12.0), st.integers(1, 50))
def test_a_window_holds_no_more_than_it_may_and_nothing_of_another_time(t_s, count):
    shown = Recording.of(Setting("", (-3.0, 3.0), 0.2), [moment(0.1 * i) for i in range(101)])
    times = [each.t_s for each in shown.window(t_s, 3.0, count)]
    assert 1 <= len(times) <= count + 1
    assert times == sorted(times)
    assert all(t_s - 3.1 <= each <= max(t_s, 0.1) + 1e-6 for each in times) or t_s > 10.0


def test_a_thinned_recording_keeps_both_ends():
    shown = Recording.of(Setting("", (-3.0, 3.0), 0.2), [moment(0.001 * i) for i in range(1001)])
    assert shown.thinned(25.0).span == shown.span
    assert len(shown.thinned(25.0).moments) == 26


def test_what_cannot_be_looked_at_is_refused_with_what_can(tmp_path):
    with pytest.raises(InputError, match="no such file; give live, a log"):
        recording_of(tmp_path / "nothing.ulg.txt")


# Attitudes and rotors


@given(st.floats(-179, 179), st.floats(-89, 89), st.floats(0, 359.9))
def test_angles_are_told_as_ground_control_stations_count_them(roll, pitch, heading):
    # intrinsic yaw, pitch, roll about down, right, forward; half a turn about x leads to our axes
    wire = Rotation.from_euler("ZYX", [heading, pitch, roll], degrees=True)
    x, y, z, w = wire.as_quat()
    said = roll_pitch_heading_deg(np.array([w, x, -y, -z]))
    assert said[0] == pytest.approx(roll, abs=1e-5)
    assert said[1] == pytest.approx(pitch, abs=1e-5)
    assert math.cos(math.radians(said[2] - heading)) == pytest.approx(1.0, abs=1e-9)


def test_an_arrow_points_where_its_rotor_pushes_as_far_as_its_share_of_the_limit():
    points, shades = thrust_arrows(np.array([3.0, 1.5, -1.5, 0.0]), (-3.0, 3.0), arm=1.0)
    lengths = points[:, 1, 2] - points[:, 0, 2]
    assert lengths / lengths[0] == pytest.approx([1.0, 0.5, -0.5, 0.0])
    assert points[:, 0, :2].tolist() == [[0, 1], [-1, 0], [0, -1], [1, 0]]  # left, rear, right, front
    assert [tuple(shade) for shade in shades] == [colours.AT_LIMIT, colours.PUSHES, colours.PULLS, colours.PUSHES]


def test_full_arrows_end_at_the_marks_of_the_limits():
    marks = limit_marks((-3.0, 3.0), arm=0.2)
    for thrust, row in ((-3.0, 0), (3.0, 1)):
        points, _ = thrust_arrows(np.full(4, thrust), (-3.0, 3.0), arm=0.2)
        assert points[:, 1] == pytest.approx(marks.mean(axis=1)[row::2], abs=1e-6)


def test_rotors_of_one_sign_have_their_limits_at_zero_and_full():
    assert saturated(np.array([0.15, 0.2, 2.99, 2.9]), (0.15, 3.0)).tolist() == [True, False, True, False]
    assert rotor_use(np.array([1.575] * 4), (0.15, 3.0)) == pytest.approx(0.0)
    assert rotor_use(np.array([1.575, 1.575, 1.575, 0.15]), (0.15, 3.0)) == pytest.approx(1.0)


def test_a_window_stands_across_the_nose():
    corners = window(0.2).reshape(-1, 3)
    assert np.ptp(corners[:, 0]) == 0.0
    assert np.ptp(corners[:, 1]) > np.ptp(corners[:, 2]) > 0.3


# Figures and status


def test_panels_draw_nothing_for_what_is_not_known_and_limits_beside_what_is():
    setting = Setting("", (-3.0, 3.0), 0.2)
    for panel in panels_of(setting, live=True):
        rows = columns(panel.values, len(panel.lines), panel.limits, [moment(0.0), moment(0.1)])
        assert len(rows) == 1 + len(panel.lines) + len(panel.limits)
        assert {len(row) for row in rows} == {2}
    rotors = next(panel for panel in panels_of(setting, live=False) if panel.limits)
    known = [moment(t, rotor_N=np.array([1.0, 2.0, -1.0, 0.5])) for t in (0.0, 0.1)]
    rows = columns(rotors.values, 4, rotors.limits, known)
    assert [row[0] for row in rows] == [0.0, 1.0, 2.0, -1.0, 0.5, -3.0, 3.0]


def test_a_failsafe_is_an_alert_and_texts_are_never_markup():
    setting = Setting("<b>box</b>", (-3.0, 3.0), 0.2)
    said = status_html(setting, moment(warning="Failsafe: fence, RTL", mode="RTL"), ["<script>"], 30.0)
    assert 'role="alert"' in said
    assert "Failsafe: fence, RTL" in said
    assert "<script>" not in said
    assert "<b>box" not in said
    assert 'role="alert"' not in status_html(setting, moment(), [], None)


# What a ground station tells


@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=30), st.integers(0, 2**40))
def test_what_is_told_arrives(points, t_us):
    path = np.array(points)
    plan = ToldPlan("mit-vp", 4.5, path, ((path[0], None), (path[-1], UPRIGHT)), (-3.0, 3.0), 0.2)
    heard = unpacked(packed(plan))
    assert isinstance(heard, ToldPlan)
    assert heard.path == pytest.approx(path, abs=1e-4)
    assert heard.gates[0][1] is None
    assert heard.gates[1][1].tolist() == UPRIGHT.tolist()
    reference = unpacked(packed(ToldReference(t_us, path[0], UPRIGHT)))
    assert isinstance(reference, ToldReference)
    assert reference.t_us == t_us


@given(st.binary(max_size=200) | st.text(max_size=100).map(str.encode))
def test_nonsense_at_the_port_is_nothing_told(datagram):
    assert unpacked(datagram) is None


@pytest.mark.parametrize(
    "said",
    [
        b'{"t_us": 1, "p": [0, 0], "q_WD": [1, 0, 0, 0]}',
        b'{"t_us": 1, "p": [0, 0, NaN], "q_WD": [1, 0, 0, 0]}',
        b'{"t_us": 1e999, "p": [0, 0, 0], "q_WD": [1, 0, 0, 0]}',
        b'{"vehicle": "x", "duration_s": 1, "path": [[1, 2, 1e999]], "gates": [], "thrust_N": [0, 1], "arm_m": 1}',
        b"[]",
        b"[" * 100000,
    ],
)
def test_half_of_what_is_told_is_nothing_told(said):
    assert unpacked(said) is None


def test_a_reference_is_taken_at_the_time_of_the_sample_and_not_of_its_arrival():
    told = deque(ToldReference(20_000 * k, np.array([0.24 * k, 0.0, 0.0]), UPRIGHT) for k in range(10))  # 12 m/s
    assert reference_at(told, 90_000).p[0] == pytest.approx(1.08)
    assert reference_at(told, 190_000).p[0] == pytest.approx(2.28)  # a little ahead of all that was told
    assert reference_at(told, 500_000) is None
    assert reference_at(deque(), 0) is None


# Colours


def seen_by_a_deuteranope(colour: tuple[int, int, int]) -> np.ndarray:
    """Machado, Oliveira and Fernandes 2009, severity 1, on linear RGB."""
    linear = np.array(colour, dtype=float) / 255.0
    linear = np.where(linear <= 0.04045, linear / 12.92, ((linear + 0.055) / 1.055) ** 2.4)
    matrix = np.array(
        [(0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)]
    )
    return matrix @ linear


def test_lines_of_a_panel_and_signs_of_a_thrust_differ_for_who_does_not_tell_red_from_green():
    lines = [tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5)) for colour in colours.SERIES]
    arrows = [colours.PUSHES, colours.PULLS, colours.AT_LIMIT]
    for group in (lines, arrows):
        for i, one in enumerate(group):
            for other in group[:i]:
                assert np.linalg.norm(seen_by_a_deuteranope(one) - seen_by_a_deuteranope(other)) > 0.12, (one, other)


def test_the_ramp_grows_lighter_all_the_way():
    shades = colours.ramp(np.linspace(0.0, 1.0, 50)).astype(float)
    lightness = shades @ np.array([0.2126, 0.7152, 0.0722])
    assert np.all(np.diff(lightness) > 0.0)
    assert ON_PAPER.alert != ON_PAPER.flown
