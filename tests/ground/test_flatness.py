"""Inverse dynamics: exact against finite differences and against a free rigid body; continuous through flips."""

import numpy as np
import pytest

from halfroll import _firmware
from halfroll.planner.flatness import inverse_dynamics, rotor_slopes, rotor_thrusts, upright_outputs
from halfroll.planner.segments import FREE, node, rest, solve
from halfroll.vehicle import GRAVITY, load_vehicle
from oracle import rigid_body

VP = load_vehicle("mit-vp")
BODY = {
    "mass": VP.mass_kg,
    "inertia": VP.inertia_kg_m2,
    "arm": VP.arm_m,
    "yaw_coefficient": VP.yaw_coefficient_m,
}


def free_fall_flip(T=1.0634):
    """The paper's Fig 2: half a turn through free fall, ends inverted."""
    apex = np.full((5, 4), FREE)
    apex[0, 1], apex[0, 3] = 0.0, 0.0
    apex[2, 0], apex[2, 2] = 0.0, -GRAVITY
    return solve([rest([0, 0, 0, 0]), apex, rest([0.4, 0, 0, 0])], [T / 2, T / 2]), (T / 2,)


def backflip():
    """The paper's Fig 3: a whole turn at speed."""
    times = np.array([0, 0.670, 0.968, 1.150, 1.397, 2.110])
    x, z, push = [0, 1.00, 1.98, 2.39, 3.17, 4.19], [0, 0.102, 0.495, 0.489, 0.108, 0], {2: -5.0, 3: 5.0}
    nodes = []
    for k in range(6):
        position = [x[k], 0, z[k], 0]
        given = rest(position) if k in (0, 5) else node(position)
        if k in push:
            given[2, [0, 2]] = push[k], -GRAVITY
        nodes.append(given)
    return solve(nodes, np.diff(times)), ()


def path_with_yaw():
    nodes = [rest([0, 0, 0, 0]), node([0.6, 0.5, 0.5, 0.7]), node([1.0, 0.2, 0.3, 1.0]), rest([1.5, -0.4, 0.6, 1.4])]
    return solve(nodes, np.array([0.6, 0.5, 0.7]) * 1.7), ()


def straight_down():
    """Brakes harder than gravity: thrust turns negative, the body stays upright."""
    return solve([rest([0, 0, 2, 0.3]), rest([0, 0, 1, 0.3])], [0.6]), ()


def outputs(case, samples=4001, vehicle=VP):
    path, flips = case
    t = np.linspace(0.0, path.times[-1], samples)
    return t, inverse_dynamics(t, path.derivatives(t), vehicle, flips)


def body_rate_by_differences(t, q):
    """2 conj(q) dq/dt with central differences, at inner samples."""
    dq = (q[2:] - q[:-2]) / (t[2:] - t[:-2])[:, None]
    w, v = q[1:-1, :1], q[1:-1, 1:]
    return 2.0 * (w * dq[:, 1:] - dq[:, :1] * v - np.cross(v, dq[:, 1:]))


CASES = [free_fall_flip, backflip, path_with_yaw, straight_down]


@pytest.mark.parametrize("case", CASES)
def test_rotor_thrusts_fly_the_path_open_loop(case):
    path, flips = case()
    _t, o = outputs((path, flips))
    start = np.concatenate([path.at(0.0)[0, :3], np.zeros(3), o.q_WD[0], np.zeros(3)])
    breaks = np.unique([*path.times, *flips])

    def thrusts(now):
        moment = np.array([now])
        return inverse_dynamics(moment, path.derivatives(moment), VP, flips, o.charts).rotors[0]

    breaks = np.unique([*breaks, *(flip + side for flip in flips for side in (-2e-4, 2e-4))])
    rtol, off = (1e-9, 1e-5) if flips else (1e-12, 1e-6)  # next to F = 0 rounding is divided by F: 1e-8 N, 1e-5 rad/s
    positions, attitudes = rigid_body.fly_open_loop(thrusts, breaks, start, rtol=rtol, **BODY)
    assert positions == pytest.approx(path.at(breaks)[:, :3], abs=off)
    alike = np.abs((attitudes[-1] * o.q_WD[-1]).sum())
    assert alike == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("case", CASES)
def test_rates_are_the_derivative_of_attitude_and_accelerations_of_rates(case):
    t, o = outputs(case(), 20001)
    inner = slice(1, -1)
    away = np.ones(len(t) - 2, dtype=bool)  # a difference across a piece or a chart change is one of lower order
    for event in [*case()[0].times, *o.charts.changes]:
        away &= np.abs(t[inner] - event) > 3 * (t[1] - t[0])
    for flip in case()[1]:  # next to F = 0 rounding of F is divided by F
        away &= np.abs(t[inner] - flip) > 1e-3
    rate = body_rate_by_differences(t, o.q_WD)
    assert rate[away] == pytest.approx(o.w_WD_D[inner][away], abs=1e-4 * (1 + np.abs(o.w_WD_D).max()))
    acceleration = (o.w_WD_D[2:] - o.w_WD_D[:-2]) / (t[2:] - t[:-2])[:, None]
    assert acceleration[away] == pytest.approx(o.dw_WD_D[inner][away], abs=1e-4 * (1 + np.abs(o.dw_WD_D).max()))


@pytest.mark.parametrize("case", CASES)
def test_attitude_never_jumps_and_points_the_thrust_along_the_force(case):
    _, o = outputs(case())
    assert np.abs(np.diff(o.q_WD, axis=0)).max() < 0.01  # 1100 deg/s for 0.5 ms
    axis = np.array([rigid_body.rotation(q)[:, 2] for q in o.q_WD[::50]])
    assert axis == pytest.approx(o.thrust_axis[::50], abs=1e-12)
    assert o.thrust[::50, None] * axis == pytest.approx(o.force[::50], abs=1e-9)
    assert np.linalg.norm(o.force, axis=1) == pytest.approx(o.force_size)


def test_the_free_fall_flip_has_the_paper_s_peak_rate_and_ends_inverted():
    t, o = outputs(free_fall_flip(), 20001)
    assert np.degrees(np.abs(o.w_WD_D).max()) == pytest.approx(956.3, rel=1e-3)
    assert o.thrust_axis[-1] == pytest.approx([0, 0, -1], abs=1e-9)
    assert (o.rotors.min(), o.rotors.max()) == pytest.approx((-2.26, 2.26), abs=0.01)
    assert t[np.flatnonzero(np.diff(o.sigma))] == pytest.approx([1.0634 / 2], abs=1e-3)


def test_the_backflip_has_the_paper_s_forces_and_angles():
    t, o = outputs(backflip(), 20001)
    assert (o.rotors.min(), o.rotors.max()) == pytest.approx((-1.13, 2.594), abs=0.01)
    angle = np.degrees(np.unwrap(np.arctan2(o.thrust_axis[:, 0], o.thrust_axis[:, 2])))
    assert np.interp([0.968, 1.150, 2.110], t, angle) == pytest.approx([-90, -270, -360], abs=0.1)
    assert o.charts.changes == pytest.approx([0.968, 1.150], abs=1e-6)
    assert (o.force_size.min(), o.force_size.max()) == pytest.approx((2.16, 9.67), abs=0.01)


def test_straight_down_harder_than_gravity_pushes_down_and_stays_upright():
    _, o = outputs(straight_down())
    assert o.vertical.all()
    assert o.thrust.min() < 0.0
    assert np.all(o.sigma == 1.0)
    assert o.w_WD_D == pytest.approx(0.0, abs=1e-12)


def test_the_fast_upright_form_is_the_same_inverse_dynamics():
    path, _ = path_with_yaw()
    t, o = outputs((path, ()), 200)
    derivatives = np.moveaxis(path.derivatives(t), 0, -1)
    rotors, force, rate = upright_outputs(derivatives, VP, vertical=False)
    assert pytest.approx(o.rotors, abs=1e-12) == rotors.T
    assert pytest.approx(o.force, abs=1e-12) == force.T
    assert pytest.approx(o.w_WD_D, abs=1e-10) == rate.T
    path, _ = straight_down()
    t, o = outputs((path, ()), 200)
    rotors, _, _ = upright_outputs(np.moveaxis(path.derivatives(t), 0, -1), VP, vertical=True)
    assert pytest.approx(o.rotors, abs=1e-12) == rotors.T


@pytest.mark.parametrize("case", CASES)
def test_rotor_slopes_are_the_differences_of_rotor_thrusts(case):
    path, flips = case()
    _, dense = outputs((path, flips))
    t = np.linspace(0.03, path.times[-1] - 0.03, 41)
    t = t[np.all([np.abs(t - event) > 2e-3 for event in (*flips, *dense.charts.changes, -1.0)], axis=0)]
    d = path.derivatives(t)
    rotors, slopes = rotor_slopes(t, d, VP, flips, dense.charts)

    def thrusts(derivatives):
        return inverse_dynamics(t, derivatives, VP, flips, dense.charts).rotors

    assert rotors == pytest.approx(thrusts(d), abs=1e-9)
    if case is straight_down:  # sideways, a thrust that pushes down turns the body over: only along the path
        slopes[:, :, 2:, :2] = 0.0
    for order, axis in np.argwhere(np.any(slopes != 0.0, axis=(0, 1))):
        h = 1e-5 * (1.0 + np.abs(d[:, order, axis]).max())
        change = np.zeros_like(d)
        change[:, order, axis] = h
        difference = (thrusts(d + change) - thrusts(d - change)) / (2.0 * h)
        slope = slopes[:, :, order, axis]
        assert difference == pytest.approx(slope, abs=1e-5 * (1.0 + np.abs(slope).max())), (order, axis)


@pytest.mark.parametrize("case", [free_fall_flip, backflip, path_with_yaw])
def test_the_firmware_s_outer_loop_and_attitude_law_ask_for_the_same_rotor_thrusts(case):
    """On the path, without leads or errors, both are the inverse dynamics; single precision. The angular acceleration
    is the path's: no setpoint carries it."""
    path, flips = case()
    setup = _firmware.vehicle_setup("mit-vp")
    params = setup.params.copy()
    for name in ("FADE_FORCE", "VEH_DRAG", "ACT_LEAD"):
        params[name] = 0.0
    loop = _firmware.OuterLoop(setup.vehicle, params)
    t = np.arange(0.0, path.times[-1], 0.01)
    d = path.derivatives(t)
    o = inverse_dynamics(t, d, VP, flips, outputs((path, flips))[1].charts)
    loop.reset(o.q_WD[0])
    for k, now in enumerate(t):
        point = _firmware.FlatReference(
            **dict(zip(("position", "velocity", "acceleration", "jerk", "snap"), d[k, :5, :3], strict=True)),
            yaw=d[k, 0, 3], yaw_rate=d[k, 1, 3], yaw_acceleration=d[k, 2, 3],
        )  # fmt: skip
        setpoint = loop.step(
            t_us=round(1e6 * now), q_WB=o.q_WD[k], w_WB_B=o.w_WD_D[k], p_WB=d[k, 0, :3], v_WB=d[k, 1, :3],
            at_sample=point, now=point, lead_acceleration=d[k, 2, :3], sigma=o.sigma[k],
            sigma_event_near=any(abs(now - flip) < 0.06 for flip in flips),
        )  # fmt: skip
        if o.force_size[k] < 0.5:  # where the autopilot holds its attitude reference
            continue
        thrust, torque = _firmware.attitude_wrench(
            setpoint.q_WD, setpoint.w_WD_D, setpoint.q_WD, setpoint.w_WD_D, o.dw_WD_D[k], setpoint.thrust,
            setup.vehicle, params,
        )  # fmt: skip
        assert np.abs(np.dot(setpoint.q_WD, o.q_WD[k])) == pytest.approx(1.0, abs=1e-6), now
        assert setpoint.w_WD_D == pytest.approx(o.w_WD_D[k], abs=1e-3 * (1.0 + np.abs(o.w_WD_D[k]).max())), now
        rotors = rotor_thrusts(np.array(thrust), np.array(torque, dtype=float), VP)
        assert rotors == pytest.approx(o.rotors[k], abs=2e-3), now


def test_hover_shares_the_weight():
    assert rotor_thrusts(np.array(VP.weight), np.zeros(3), VP) == pytest.approx(VP.weight / 4.0)


def test_rotor_thrusts_make_the_torques_they_were_asked_for():
    f1, f2, f3, f4 = rotor_thrusts(np.array(6.0), np.array([0.1, -0.2, 0.01]), VP)
    assert f1 + f2 + f3 + f4 == pytest.approx(6.0)
    assert VP.arm_m * (f1 - f3) == pytest.approx(0.1)
    assert VP.arm_m * (f2 - f4) == pytest.approx(-0.2)
    assert VP.yaw_coefficient_m * (-f1 + f2 - f3 + f4) == pytest.approx(0.01)
