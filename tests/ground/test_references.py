"""Leads, tables and approach of the reference stream. The outer loop itself has tests of its own."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfroll import _firmware, references
from halfroll.mission import Waypoint
from halfroll.plan import Limits, plan_course
from halfroll.references import PARAMETERS, Leads, Path, References, approach, heading, other_vehicle
from halfroll.vehicle import load_vehicle

VP = {"ATT_WN": 16.0, "ATT_ZETA": 0.9, "ACT_LEAD": 0.021}


def state(position=(0.0, 0.0, 1.0), velocity=(0.0, 0.0, 0.0), yaw=0.0, t_us=0):
    q_WB = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
    return SimpleNamespace(
        t_us=t_us, q_WB=q_WB, w_WB_B=np.zeros(3), p_WB=np.array(position), v_WB=np.array(velocity, dtype=float)
    )


class Listening:
    """In the place of the bound outer loop: keeps what it was asked."""

    def __init__(self):
        self.asked = []

    def step(self, **asked):
        self.asked.append(asked)


def test_leads_in_lockstep_are_those_of_the_recipe():
    leads = Leads.of(VP, link_delay=0.0)  # zw = 2 * 0.9 * 16 = 28.8 /s, half a tick is 5 ms
    assert leads.mid_age == pytest.approx(0.005)
    assert leads.rate == pytest.approx(1 / 28.8 + 0.005)
    assert leads.thrust == pytest.approx(0.026)


def test_leads_in_real_time_allow_for_the_wire():
    leads = Leads.of(VP, link_delay=0.002)
    assert leads.rate == pytest.approx(0.0417, abs=5e-5)
    assert leads.thrust == pytest.approx(0.028)


@given(st.floats(0.0, 1.0, allow_subnormal=False), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_a_table_is_exact_on_its_rows_linear_between_and_at_rest_outside(share, a, b):
    path = Path(np.stack([np.full((5, 4), a), np.full((5, 4), b)]), np.array([[a] * 3, [b] * 3]))
    assert path.at(share * 1e-3) == pytest.approx(np.full((5, 4), a + share * (b - a)), abs=1e-5)
    assert path.at(-1.0)[0, 0] == pytest.approx(a)
    assert path.rate_at(2.0)[0] == pytest.approx(b)


def test_each_field_is_taken_from_its_own_time_of_the_path():
    t = np.arange(1001) * 1e-3
    derivatives = np.zeros((1001, 5, 4))
    derivatives[:, 0, 0] = derivatives[:, 2, 2] = t  # position x and acceleration z tell the time
    path = Path(derivatives, np.stack([t, t**2, 0 * t], axis=1))
    loop, leads = Listening(), Leads.of(VP, 0.0)
    References(loop, leads).setpoint(path, 2_000_000, state(t_us=2_300_000))
    (asked,) = loop.asked
    assert asked["t_us"] == 2_300_000
    assert asked["now"].position[0] == pytest.approx(0.3)
    assert asked["at_sample"] is asked["now"]  # the estimate is for its own stamp, the tick
    assert asked["lead_acceleration"][2] == pytest.approx(0.3 + 0.026)
    later = 0.3 + 1 / 28.8 + 0.005
    assert asked["lead_rate"] == pytest.approx([later - 0.3, later**2 - 0.09, 0.0], abs=1e-6)
    assert asked["mid_age"] == pytest.approx(0.005)


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
    params = dict.fromkeys(references.PARAMETERS, 1.0) | VP | {"VEH_T_REF": 12.0, "SIGN_RULE": 0.0}
    here = state((0.0, 0.0, 1.0), t_us=1_000_000)
    path = approach(here, (0.0, 0.0, 1.0), 0.0)
    flying = References.for_vehicle(vehicle, params, link_delay=0.0)
    flying.begin(here)
    setpoint = flying.setpoint(path, here.t_us, here)
    assert setpoint.thrust == pytest.approx(vehicle.weight, rel=1e-3)  # hovers where it shall
    assert setpoint.q_WD == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-6)
    bound = references.firmware_vehicle(load_vehicle("mit-fp"))
    assert bound.inertia == pytest.approx([0.00365, 0.00365, 0.0068])
    assert (bound.thrust_min, bound.rotor_lag) == pytest.approx((0.15, 0.12))


def test_a_vehicle_is_told_from_another_by_the_parameters_of_its_autopilot():
    ours, other = load_vehicle("mit-vp"), load_vehicle("mit-fp")
    params = {name: float(_firmware.Params()[name]) for name in PARAMETERS} | {"VEH_T_REF": 12.0}
    assert other_vehicle(ours, params | ours.params) is None
    assert other_vehicle(ours, params | {"ACT_LEAD": 0.0, "VEH_DRAG": 0.05}) is None  # the paper's, in real air
    assert other_vehicle(ours, params | other.params) == "ACT_LEAD is 0.04, mit-vp has 0.021"
    assert other_vehicle(ours, params | {"VEH_T_REF": 32.0}) == "VEH_T_REF is 32, mit-vp has 12"
