"""Leads, tables and approach of the reference stream. The outer loop itself has tests of its own."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfroll import _firmware
from halfroll.missions.mission import Waypoint
from halfroll.planner.plan import Limits, plan_course
from halfroll.station import references
from halfroll.station.references import PARAMETERS, Leads, Path, References, approach, heading, other_vehicle
from halfroll.vehicle import load_vehicle

VP = {"ATT_WN": 16.0, "ATT_ZETA": 0.9, "ACT_LEAD": 0.021}


def params(**changed):
    values = _firmware.Params()
    for name, value in (VP | changed).items():
        values[name] = value
    return values


def state(position=(0.0, 0.0, 1.0), velocity=(0.0, 0.0, 0.0), yaw=0.0, t_us=0):
    q_WB = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
    return SimpleNamespace(
        t_us=t_us, q_WB=q_WB, w_WB_B=np.zeros(3), p_WB=np.array(position), v_WB=np.array(velocity, dtype=float)
    )


def test_leads_in_lockstep_are_half_a_tick_and_what_the_rotors_need():
    leads = Leads.of(params(), link_delay=0.0, rotor_delay=0.003)
    assert leads.mid_age == pytest.approx(0.005)
    assert leads.rate_gain == pytest.approx(2 * 0.9 * 16)
    assert (leads.delay, leads.lag) == pytest.approx((0.003, 0.018))


def test_leads_in_real_time_allow_for_the_wire():
    assert Leads.of(params(), link_delay=0.002).mid_age == pytest.approx(0.007)


def test_without_a_lead_the_rotors_are_believed_to_follow_at_once():
    leads = Leads.of(params(ACT_LEAD=0.0), 0.0, 0.003)
    assert (leads.delay, leads.lag) == (0.0, 0.0)


@given(st.floats(0.0, 1.0, allow_subnormal=False), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_a_table_is_exact_on_its_rows_linear_between_and_at_rest_outside(share, a, b):
    path = Path(np.stack([np.full((5, 4), a), np.full((5, 4), b)]), np.array([[a] * 3, [b] * 3]))
    assert path.at(share * 1e-3) == pytest.approx(np.full((5, 4), a + share * (b - a)), abs=1e-5)
    assert path.at(-1.0)[0, 0] == pytest.approx(a)
    assert path.rate_at(2.0)[0] == pytest.approx(b)


def test_thrust_and_rates_are_what_a_lag_needs_to_follow_the_path_while_the_setpoint_is_in_use():
    t = np.arange(1001) * 1e-3
    derivatives = np.zeros((1001, 5, 4))
    derivatives[:, 0, 0] = t  # position x tells the time
    derivatives[:, 2, 2], derivatives[:, 3, 2] = t**2, 2.0 * t  # acceleration z, and jerk
    path = Path(derivatives, np.stack([t, t**2, t**3], axis=1))
    leads = Leads.of(params(), 0.0, rotor_delay=0.003)
    later = 0.3 + 0.005 + 0.003
    assert leads.acceleration(path, 0.3)[2] == pytest.approx(later**2 + 0.018 * 2 * later, abs=1e-6)
    middle = 0.3 + 0.005
    change = np.array([1.0, 2 * later, 3 * later**2]) + 0.018 * np.array([0.0, 2.0, 6 * later])  # w' + lag w''
    then = np.array([middle, middle**2, middle**3])
    extra = leads.rate_ahead(path, 0.3) - (then - [0.3, 0.09, 0.027])
    assert 28.8 * extra - np.cross(then, extra) == pytest.approx(change, abs=1e-3)


def test_a_setpoint_is_for_the_place_of_the_path_at_the_tick_and_bears_its_stamp():
    t = np.arange(1001) * 1e-3
    derivatives = np.zeros((1001, 5, 4))
    derivatives[:, 0, 0] = derivatives[:, 0, 3] = t  # position x and yaw tell the time
    derivatives[:, 1, 0] = 1.0
    path, vehicle = Path(derivatives, np.zeros((1001, 3))), load_vehicle("mit-vp")
    flying = References(references.firmware_vehicle(vehicle), params(), Leads.of(params(), 0.0))
    here = state((0.3, 0.0, 0.0), (1.0, 0.0, 0.0), yaw=0.3, t_us=2_300_000)
    flying.begin(here)
    setpoint = flying.setpoint(path, 2_000_000, here)
    assert setpoint.t_us == 2_300_000
    assert heading(setpoint.q_WD) == pytest.approx(0.3, abs=1e-6)
    assert setpoint.q_WD[1:3] == pytest.approx(np.zeros(2), abs=2e-2)  # no error but of drag: it need not lean


def test_led_rates_make_the_attitude_law_ask_for_the_torque_of_the_path_about_all_axes_at_once():
    t = np.arange(1001) * 1e-3
    rates = np.stack([6.0 * np.sin(9.0 * t), 5.0 * np.cos(7.0 * t), np.sin(4.0 * t)], axis=1)
    path = Path(np.zeros((1001, 5, 4)), rates)
    leads = Leads.of(params(ACT_LEAD=0.0), 0.0)
    vehicle = load_vehicle("mit-vp")
    level = np.array([1.0, 0.0, 0.0, 0.0])
    for now in (0.1, 0.33, 0.7):
        then = now + leads.mid_age
        w = path.rate_at(then)
        sent = path.rate_at(now) + leads.rate_ahead(path, now)
        _, torque = _firmware.attitude_wrench(
            level, w, level, sent, np.zeros(3), 5.6, references.firmware_vehicle(vehicle), params()
        )
        J = np.array(vehicle.inertia_kg_m2)
        turning = np.array([54.0 * np.cos(9.0 * then), -35.0 * np.sin(7.0 * then), 4.0 * np.cos(4.0 * then)])
        assert torque == pytest.approx(J * turning + np.cross(w, J * w), abs=2e-3)


def test_position_feedback_turns_a_near_optimal_plan_s_attitude_the_shortest_way():
    """So the nose is where the plan has it, although yaw counted from upright would turn it by many times as much."""
    planned = np.zeros((5, 4))
    planned[2, :3] = (15.0, 0.0, -9.0)  # the thrust axis near the horizon
    planned[0, 3] = 0.4
    axis = np.array([15.0, 0.0, 0.81]) / np.linalg.norm([15.0, 0.0, 0.81])
    aside = axis + np.array([0.0, 0.02, 0.0])
    aside /= np.linalg.norm(aside)
    q_planned = _firmware.multiply(
        least_rotation(np.array([0.0, 0.0, 1.0]), axis), np.array([np.cos(0.2), 0.0, 0.0, np.sin(0.2)])
    )
    q_tried = least_rotation(np.array([0.0, 0.0, 1.0]), aside)
    led = _firmware.nose_led(planned, 0.1, q_tried, np.array([0.0, 0.0, 0.3]))
    q_led = _firmware.multiply(q_tried, np.array([np.cos(led[0, 3] / 2), 0.0, 0.0, np.sin(led[0, 3] / 2)]))
    turn = _firmware.multiply(_firmware.conjugate(q_planned), q_led)
    assert 2.0 * np.linalg.norm(turn[1:]) == pytest.approx(np.arccos(axis @ aside), abs=1e-5)
    assert led[1, 3] == pytest.approx(-0.2)


def least_rotation(a, b):
    """Turns unit vector a onto b the shortest way."""
    q = np.array([1.0 + a @ b, *np.cross(a, b)])
    return q / np.linalg.norm(q)


def test_sigma_turns_over_at_its_events_and_is_free_near_them():
    path = Path(np.zeros((2, 5, 4)), np.zeros((2, 3)), sigma_events=(1.0, 2.0))
    assert [path.sigma_at(t) for t in (0.5, 1.5, 2.5)] == [1.0, -1.0, 1.0]
    assert [path.is_near_sigma_event(t) for t in (0.9, 0.95, 1.05, 1.1)] == [False, True, True, False]


@given(
    st.lists(st.floats(-20, 20), min_size=3, max_size=3),
    st.lists(st.floats(-3, 3), min_size=3, max_size=3),
    st.floats(-math.pi, math.pi),
    st.floats(-math.pi, math.pi),
)
def test_an_approach_leaves_with_the_vehicle_and_ends_at_rest_at_the_goal(goal, velocity, yaw, goal_yaw):
    path = approach(state((1.0, 2.0, 3.0), velocity, yaw), goal, goal_yaw)
    first, last = path.at(0.0), path.at(path.duration)
    assert first[0, :3] == pytest.approx([1.0, 2.0, 3.0])
    assert first[1, :3] == pytest.approx(velocity)
    assert math.remainder(first[0, 3] - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)
    assert last[0] == pytest.approx([*goal, goal_yaw], abs=1e-6)
    assert np.abs(last[1:]).max() < 1e-6


def test_an_approach_is_gentle_however_far_it_goes():
    for distance in (0.0, 0.1, 2.0, 50.0):
        path = approach(state((0.0, 0.0, 5.0)), (distance, 0.0, 5.0), 0.0)
        assert np.abs(path.derivatives[:, 2, :3]).max() < 2.05
        assert np.abs(path.derivatives[:, 1, :3]).max() < 3.05
        assert path.duration >= 0.5


@given(st.floats(-3.1, 3.1))
def test_heading_is_counter_clockwise_from_north(yaw):
    assert heading(state(yaw=yaw).q_WB) == pytest.approx(yaw)


def test_the_table_of_a_plan_is_the_plan():
    plan = two_points()
    path = references.path_of(plan)
    assert abs(path.duration - plan.T) < 1e-3 + 1e-9
    for t in (0.0, 0.123, 0.5 * plan.T, plan.T):
        point = plan.at(round(t, 3))
        assert path.at(round(t, 3))[:, :3] == pytest.approx(
            np.stack([point.position, point.velocity, point.acceleration, point.jerk, point.snap]), abs=1e-6
        )
    assert path.rate_at(0.2) == pytest.approx(plan.rates([0.2])[0])


def two_points():
    vehicle = load_vehicle("mit-vp")
    waypoints = (Waypoint((0.0, 0.0, 2.0)), Waypoint((2.0, 1.0, 2.0)))
    return plan_course(waypoints, vehicle, Limits.of(vehicle, "rotors", 0.2), lambda _: None)


def test_the_outer_loop_flies_with_the_vehicle_and_the_gains_of_the_autopilot():
    vehicle = load_vehicle("mit-vp")
    values = dict.fromkeys(references.PARAMETERS, 1.0) | VP | {"VEH_T_REF": 12.0, "SIGN_RULE": 0.0}
    here = state((0.0, 0.0, 1.0), t_us=1_000_000)
    path = approach(here, (0.0, 0.0, 1.0), 0.0)
    flying = references.for_vehicle(vehicle, values, link_delay=0.0)
    flying.begin(here)
    setpoint = flying.setpoint(path, here.t_us, here)
    assert setpoint.thrust == pytest.approx(vehicle.weight, rel=1e-3)  # hovers where it shall
    assert setpoint.q_WD == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-6)
    bound = references.firmware_vehicle(load_vehicle("mit-fp"))
    assert bound.inertia == pytest.approx([0.00365, 0.00365, 0.0068])
    assert (bound.thrust_min, bound.rotor_lag) == pytest.approx((0.15, 0.12))


def test_a_vehicle_is_told_from_another_by_the_parameters_of_its_autopilot():
    ours, other = load_vehicle("mit-vp"), load_vehicle("mit-fp")
    known = {name: float(_firmware.Params()[name]) for name in PARAMETERS} | {"VEH_T_REF": 12.0}
    assert other_vehicle(ours, known | ours.params) is None
    assert other_vehicle(ours, known | {"ACT_LEAD": 0.0, "VEH_DRAG": 0.05}) is None  # the paper's, in real air
    assert other_vehicle(ours, known | other.params) == "ACT_LEAD is 0.04, mit-vp has 0.021"
    assert other_vehicle(ours, known | {"VEH_T_REF": 32.0}) == "VEH_T_REF is 32, mit-vp has 12"
