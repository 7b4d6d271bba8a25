"""Where the paper's print is wrong: each equation as printed beside the corrected one, against something that knows
neither (finite differences, the simulated world, a flight). docs/errata.md is the table; its last column names these
tests.

Why: who reads code and paper side by side must be able to see that the difference is meant.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfroll import _firmware
from halfroll.paper import paths
from halfroll.paper.flights import START_M
from halfroll.planner.flatness import inverse_dynamics
from halfroll.planner.segments import node, rest, solve
from halfroll.scenario import load_scenario
from halfroll.station.references import firmware_vehicle, path_of
from halfroll.streamed import StreamedFlight
from halfroll.vehicle import GRAVITY, load_vehicle

VP = load_vehicle("mit-vp")
UP = np.array([0.0, 0.0, 1.0])
STEP = 1e-5

components = st.floats(-1.0, 1.0, allow_subnormal=False)
directions = st.tuples(components, components, components).filter(lambda v: np.linalg.norm(v) > 0.1).map(np.array)
angles = st.floats(-3.0, 3.0)


def product(p, q):
    w, v = p[0] * q[0] - p[1:] @ q[1:], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([w, *v])


def conjugate(q):
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def turn(axis, angle):
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis / np.linalg.norm(axis))])


def sandwich(q, v):
    """q v q*"""
    return product(product(q, np.array([0.0, *v])), conjugate(q))[1:]


def unit(v):
    return v / np.linalg.norm(v)


def moving_force(t):
    """A force that turns out of every plane; derivatives by finite differences."""
    return np.array([2.0 * np.sin(1.7 * t), 1.5 * np.cos(2.3 * t), 2.0 + np.sin(0.9 * t)])


def desired(t):
    """Corrected Eq 12 for that force: the least rotation from up."""
    n = unit(moving_force(t))
    return unit(np.array([1.0 + n[2], *np.cross(UP, n)]))


def finite_rate(attitude, t):
    """Body rate of an attitude over time, from q' = q (0, w)/2, which holds as printed."""
    change = (attitude(t + STEP) - attitude(t - STEP)) / (2.0 * STEP)
    return 2.0 * product(conjugate(attitude(t)), change)[1:]


@given(directions, angles, directions, directions)
def test_eq_1_rotation(axis, angle, vector, rate):
    """q v q* turns with q' = q (0, w)/2; q* v q, as printed, turns the other way."""
    q = turn(axis, angle)
    ahead, behind = (product(q, turn(rate, sign * STEP * np.linalg.norm(rate))) for sign in (1.0, -1.0))
    w_in_W = sandwich(q, rate)
    corrected = (sandwich(ahead, vector) - sandwich(behind, vector)) / (2.0 * STEP)
    assert corrected == pytest.approx(np.cross(w_in_W, sandwich(q, vector)), abs=1e-6)
    assert _firmware.rotate(q, vector) == pytest.approx(sandwich(q, vector), abs=1e-6)


def test_eq_1_as_printed_turns_the_wrong_way():
    q, rate, vector = turn(np.array([0.3, -0.5, 0.8]), 1.1), np.array([0.4, 2.0, -1.0]), np.array([1.0, 2.0, 3.0])
    ahead, behind = (product(q, turn(rate, sign * STEP * np.linalg.norm(rate))) for sign in (1.0, -1.0))
    printed = [sandwich(conjugate(p), vector) for p in (ahead, behind)]
    w_in_W = sandwich(conjugate(q), rate)
    error = (printed[0] - printed[1]) / (2.0 * STEP) - np.cross(w_in_W, sandwich(conjugate(q), vector))
    assert np.linalg.norm(error) > 1.0


def test_eqs_2_8_9_28_thrust_in_the_world():
    """A body pitched nose down (about +y) is pushed forward; q* (0, 0, T) q, as printed, would push it back."""
    q, thrust = turn(np.array([0.0, 1.0, 0.0]), 0.5), 8.0
    world = _firmware.World(_firmware.vehicle_setup("mit-vp").plant, "ideal", 0)
    world.place([0.0, 0.0, 9.0], np.zeros(3), q, np.zeros(3), [thrust / 4.0] * 4)
    world.step([thrust / 4.0] * 4)
    pushed = (world.v_WB / 1e-3 + GRAVITY * UP) * VP.mass_kg
    assert pushed == pytest.approx(sandwich(q, thrust * UP), abs=1e-2)
    assert np.linalg.norm(pushed - sandwich(conjugate(q), thrust * UP)) > 7.0


@given(directions.filter(lambda f: abs(f[2]) > 0.05))
def test_eq_11_sign_of_the_thrust(force):
    """s = sigma sgn(F_z) gives the wanted side up; the printed F.F_b >= 0 knows no upside down."""
    for sigma in (1.0, -1.0):
        corrected = sigma * np.sign(force[2]) * unit(force)
        assert np.sign(corrected[2]) == sigma
    printed = np.sign(force @ UP) * unit(force)
    assert printed[2] > 0.0


def test_eq_11_near_a_sigma_event():
    """Flown, the force turns over a little off the scheduled instant: by the rule alone the reference jumps by half a
    turn and back, by continuity around the event it does not."""
    assert largest_jump_deg(SIGN_RULE=1.0) > 150.0
    assert largest_jump_deg(SIGN_RULE=0.0) < 30.0


def largest_jump_deg(**params):
    """Between successive attitude references of the backflip, less what their own rates turn them by."""
    vehicle = load_vehicle("mit-vp", {f"params.{name}": value for name, value in params.items()})
    plan = paths.backflip(vehicle, START_M)
    path, flight, sent = path_of(plan), StreamedFlight(vehicle, load_scenario("nominal")), []
    flight.take_off(START_M)
    flight.settle(plan.waypoints[0].position)
    flight.references.begin(flight.state())
    start_us = flight.autopilot.t_us

    def kept(here):
        sent.append(flight.references.setpoint(path, start_us, here))
        return sent[-1]

    flight.stream(kept, plan.T, 10)
    q, w = np.array([s.q_WD for s in sent], dtype=float), np.array([s.w_WD_D for s in sent], dtype=float)
    jumps = []
    for k in range(len(q) - 1):
        expected = product(q[k], turn(w[k] + 1e-9, 0.01 * np.linalg.norm(w[k])))
        jumps.append(2.0 * np.degrees(np.arccos(min(1.0, abs(expected @ q[k + 1])))))
    return max(jumps)


@given(directions.map(unit).filter(lambda n: abs(n[2]) < 0.99))
def test_eq_12_least_rotation(n):
    """From F_b to F_i takes F_b x F_i; the product printed reversed turns the other way. With n below the horizon it is
    measured from upside down."""
    base = UP if n[2] >= 0.0 else -UP
    corrected = unit(np.array([1.0 + n @ base, *np.cross(base, n)]))
    printed = unit(np.array([1.0 + n @ base, *np.cross(n, base)]))
    assert sandwich(corrected, base) == pytest.approx(n, abs=1e-9)
    assert np.linalg.norm(sandwich(printed, base) - n) > 0.1


@given(directions, directions, angles)
def test_eq_14_thrust_along_the_actual_axis(force, axis, angle):
    """(q* F q)_z is the force along the body's z axis; (q F q*)_z, as printed, is not, unless both happen to agree."""
    q = turn(axis, angle)
    along = force @ sandwich(q, UP)
    assert sandwich(conjugate(q), force)[2] == pytest.approx(along, abs=1e-9)


def test_eq_14_as_printed_takes_another_component():
    q, force = turn(np.array([0.0, 1.0, 0.0]), 0.5), np.array([3.0, 0.0, 5.0])
    assert abs(sandwich(q, force)[2] - force @ sandwich(q, UP)) > 2.0


def test_eqs_15_to_17_body_rates_are_in_body_components():
    """[R^T (n x n')]_xy; the printed n x n' is the same rate in the world's components."""
    corrected, printed = [], []
    for t in np.linspace(0.0, 6.0, 61):
        n = unit(moving_force(t))
        change = (unit(moving_force(t + STEP)) - unit(moving_force(t - STEP))) / (2.0 * STEP)
        rate = finite_rate(desired, t)
        corrected.append(np.abs(sandwich(conjugate(desired(t)), np.cross(n, change))[:2] - rate[:2]).max())
        printed.append(np.abs(np.cross(n, change)[:2] - rate[:2]).max())
    assert max(corrected) < 1e-6
    assert max(printed) > 0.1


def test_eq_18_heading_turns_with_the_thrust_axis():
    """w_z = psi' - (n1 n2' - n2 n1')/(1 + n3); printed psi' alone."""
    yaw_rate = 0.7

    def attitude(t):
        return product(desired(t), turn(UP, yaw_rate * t))

    corrected, printed = [], []
    for t in np.linspace(0.0, 6.0, 61):
        n = unit(moving_force(t))
        n1 = (unit(moving_force(t + STEP)) - unit(moving_force(t - STEP))) / (2.0 * STEP)
        spin = (n[0] * n1[1] - n[1] * n1[0]) / (1.0 + n[2])
        rate = finite_rate(attitude, t)[2]
        corrected.append(abs(yaw_rate - spin - rate))
        printed.append(abs(yaw_rate - rate))
    assert max(corrected) < 1e-6
    assert max(printed) > 0.05


def test_text_after_eq_19_the_force_changes_with_jerk():
    """F' = m (r''' + fb'); in print a dot is missing, which is m times the acceleration."""
    plan = paths.backflip(VP)
    path, t = plan.trajectory, np.linspace(0.1, 2.0, 50)
    force = [VP.mass_kg * (path.at(t + side, 2)[:, :3] + GRAVITY * UP) for side in (STEP, -STEP)]
    change = (force[0] - force[1]) / (2.0 * STEP)
    assert change == pytest.approx(VP.mass_kg * path.at(t, 3)[:, :3], abs=1e-5)
    assert np.abs(change - VP.mass_kg * path.at(t, 2)[:, :3]).max() > 10.0


def test_eq_22_sign():
    """With q_e = q* q_d its vector part points the way that is still to be turned: +sgn(q_e0) Kp; printed with a minus,
    every attitude is turned to upside down of its reference."""
    setup = _firmware.vehicle_setup("mit-vp")
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    for angle in (0.3, 1.5, 3.0):
        q = turn(np.array([1.0, 0.0, 0.0]), -angle)  # to be rolled by +angle
        for law, sense in ((0.0, 1.0), (1.0, -1.0)):
            params = setup.params.copy()
            params["ATT_LAW"] = law
            _, torque = _firmware.attitude_wrench(
                q, np.zeros(3), upright, np.zeros(3), np.zeros(3), 5.6, setup.vehicle, params
            )
            assert sense * torque[0] > 0.01


def test_eq_22_rates_of_a_turned_reference():
    """w - R_e w_d compares in the same axes, and w x J w - J (w x R_e w_d) takes out what turning axes add; printed
    w - w_d asks for torque where none is due."""
    setup = _firmware.vehicle_setup("mit-vp")
    J = np.array(VP.inertia_kg_m2)
    q_WD, w_W = turn(np.array([0.2, 1.0, -0.4]), 0.9), np.array([3.0, -2.0, 1.0])
    q_WB = product(q_WD, turn(UP, 1.2))  # turned about the thrust axis, at the same rate in W
    w_D, w_B = sandwich(conjugate(q_WD), w_W), sandwich(conjugate(q_WB), w_W)
    _, torque = _firmware.attitude_wrench(q_WB, w_B, q_WD, w_D, np.zeros(3), 5.6, setup.vehicle, setup.params)
    wn, zeta = setup.params["ATT_WN"], setup.params["ATT_ZETA"]
    q_BD = product(conjugate(q_WB), q_WD)
    spring = 2.0 * J * wn**2 * np.sign(q_BD[0]) * q_BD[1:]
    assert torque == pytest.approx(spring + np.cross(w_B, J * w_B), abs=1e-4)  # no damping: it turns as it should
    assert np.abs(2.0 * zeta * wn * J * (w_B - w_D)).max() > 0.1  # what the printed term would add


@settings(max_examples=20)
@given(st.floats(1.1, 1.5))
def test_smoothness_at_free_fall(change):
    """Four continuous derivatives, as the text asks, are too few where F = 0: with a fifth that steps, torque steps."""
    smooth = paths.free_fall_flip(VP).trajectory
    half = paths.FLIP_S / 2.0
    middle = smooth.derivatives([half], 5)[0]
    bent = middle.copy()
    bent[4, 2] *= change  # still continuous to the 4th, but no longer to the 5th
    ends = rest([0.0] * 4), rest([paths.FLIP_WIDTH_M, 0.0, 0.0, 0.0])
    kinked = solve([ends[0], node(*bent), ends[1]], [half, half])

    def step(path):
        t = half + np.array([-1e-4, 1e-4])
        return float(abs(np.diff(inverse_dynamics(t, path.derivatives(t), VP, flips=(half,)).torque[:, 1])[0]))

    assert step(smooth) < 0.02
    assert step(kinked) > 5.0 * step(smooth)
    assert kinked.at(half - 1e-9, 4) == pytest.approx(kinked.at(half, 4), rel=1e-4, abs=1e-4)


def flat(derivatives):
    """Of (5, 4) derivatives of x, y, z, yaw."""
    position, velocity, acceleration, jerk, snap = derivatives[:, :3]
    yaw, yaw_rate, yaw_acceleration = derivatives[:3, 3]
    return _firmware.FlatReference(
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        jerk=jerk,
        snap=snap,
        yaw=yaw,
        yaw_rate=yaw_rate,
        yaw_acceleration=yaw_acceleration,
    )


def test_hold_keeps_turning():
    """While the force is too small to have a direction the paper freezes attitude and rate, which contradict each other
    at 945 deg/s. Here the attitude goes on at that rate."""
    plan = paths.free_fall_flip(VP)
    path, params = path_of(plan), _firmware.vehicle_setup("mit-vp").params
    params["HOLD_FORCE"] = 0.5  # held for several ticks
    loop = _firmware.OuterLoop(firmware_vehicle(VP), params)
    sent = []
    for tick in range(40, 66):
        t = 0.01 * tick
        now = flat(path.at(t))
        near = path.is_near_sigma_event(t)
        sent.append(
            loop.step(
                t_us=10_000 * tick,
                q_WB=plan.outputs(np.array([t])).q_WD[0],
                w_WB_B=np.zeros(3),
                p_WB=path.at(t)[0, :3],
                v_WB=path.at(t)[1, :3],
                at_sample=now,
                now=now,
                lead_acceleration=path.at(t)[2, :3],
                sigma=path.sigma_at(t),
                sigma_event_near=near,
            )
        )
    force = VP.mass_kg * np.linalg.norm([path.at(0.01 * k)[2, :3] + GRAVITY * UP for k in range(40, 66)], axis=1)
    held = np.flatnonzero(force < 0.5)
    assert len(held) >= 4
    for k in held:
        before, after, rate = sent[k - 1].q_WD, sent[k].q_WD, np.linalg.norm(sent[k].w_WD_D)
        turned = 2.0 * np.arccos(min(1.0, abs(float(before @ after))))
        assert turned == pytest.approx(0.01 * rate, rel=0.05)
        assert turned > np.radians(5.0)  # frozen, it would be 0


def test_every_row_of_the_errata_page_has_its_test():
    page = (Path(__file__).parents[2] / "docs" / "errata.md").read_text()
    named = set(re.findall(r"`(test_\w+)`", page))
    here = {name for name in globals() if name.startswith("test_")}
    assert named == here - {"test_every_row_of_the_errata_page_has_its_test"}
