"""Inverse dynamics: derivatives of position and yaw to attitude, body rates, torque and the four rotor thrusts.

Why: it is the planner's picture of the vehicle (Eqs 2-4 and 11-19 inverted, docs/paper.md, without
feedback). Everything is vectorised over samples, and continuous through free fall and through upside down.

The thrust axis n = s F/|F| has a sign s. It is +1, except
- in purely vertical flight: there the body stays as it is and thrust is signed (pushing down beyond free fall), and
- after a free-fall flip, at which F passes through zero: s changes there, n turns smoothly on (`flips`).
sigma, the wanted sign of n_z, follows: sigma = sgn(n_z).

Attitude is measured from upright while n_z >= 0 (chart A) and from upside down while n_z < 0 (chart C), without
hysteresis. At a change from A to C the heading gamma of chart C is taken from n, so the attitude is continuous; at a
change back, what the charts differ by becomes a constant yaw offset. On a path that turns over out of one plane the
yaw rate still steps at the change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfroll import _planner as kernel
from halfroll.vehicle import GRAVITY, Vehicle

Array = NDArray[np.float64]

# [N], below it, and so close to a flip, u = F/|F| is taken from its series. Of what rounding leaves of F at the flip
# itself, u'' makes as much as F'^2/F^3: where F' is large the series serves farther, but no longer.
NEAR_ZERO_FORCE, QUICK_FORCE = 1e-3, 0.015
NEAR_ZERO_TIME, QUICK_TIME = 0.005, 5e-5  # [s]
_VERTICAL = 1e-10  # horizontal force and its derivatives, relative to the weight: purely vertical flight


@dataclass(frozen=True)
class Charts:
    """Which chart is used when: before changes[0] entry 0, from changes[k-1] on entry k."""

    changes: Array  # (K,) [s]
    inverted: NDArray[np.bool_]  # (K+1,) chart C
    gamma: Array  # (K+1,) [rad], heading of chart C
    yaw_offset: Array  # (K+1,) [rad]

    def at(self, t: Array) -> tuple[NDArray[np.bool_], Array, Array]:
        k = np.searchsorted(self.changes, t, side="right")
        return self.inverted[k], self.gamma[k], self.yaw_offset[k]


UPRIGHT = Charts(np.array([]), np.array([False]), np.zeros(1), np.zeros(1))  # chart A throughout: n_z above -1


@dataclass(frozen=True)
class FlatOutputs:
    """What the vehicle does at each of S samples. q_WD Hamilton [w, x, y, z]; rates and torque in D (the body)."""

    force: Array  # (S, 3) [N] in W: m (acceleration + g e3)
    thrust_axis: Array  # (S, 3) n, the body's z in W
    q_WD: Array  # (S, 4), continuous from sample to sample
    w_WD_D: Array  # (S, 3) [rad/s]
    dw_WD_D: Array  # (S, 3) [rad/s²]
    thrust: Array  # (S,) [N], signed total
    torque: Array  # (S, 3) [N m]
    rotors: Array  # (S, 4) [N], rotors left, back, right, front
    vertical: NDArray[np.bool_]  # (S,) no horizontal force: signed thrust
    charts: Charts

    @property
    def force_size(self) -> Array:
        return np.asarray(np.linalg.norm(self.force, axis=1))

    @property
    def sigma(self) -> Array:
        """(S,) +1 upright, -1 inverted."""
        return np.where(self.thrust_axis[:, 2] < 0.0, -1.0, 1.0)


def inverse_dynamics(
    t: Array,
    derivatives: Array,
    vehicle: Vehicle,
    flips: Sequence[float] = (),
    charts: Charts | None = None,
    turns: Sequence[tuple[float, float]] | None = None,
) -> FlatOutputs:
    """Attitude, rates, torque and rotor thrusts at increasing times t (S,) with derivatives (S, 6, 4).

    flips: times at which F passes through zero and s changes. charts: as found from a dense sampling of the same
    trajectory; without it they are found from these samples, which must then be dense enough to see each turn. turns:
    the times between which charts change; between others the thrust axis may cross the horizon in its chart. None: any.
    """
    force, vertical = _force_and_derivatives(derivatives, vehicle)
    events = np.asarray(flips, dtype=float)
    sign = np.where(np.searchsorted(events, t, side="right") % 2 == 1, -1.0, 1.0)
    axis = _thrust_axis(t, force, sign, vertical, events)
    sign = np.where(vertical & (force[0, 2] < 0.0), -sign, sign)
    charts = _find_charts(t, axis, turns) if charts is None else charts
    inverted, gamma, offset = charts.at(t)
    yaw = derivatives[:, 0, 3] + offset
    rate, acceleration = _body_rate(_turned(axis, inverted, gamma), yaw, derivatives[:, 1, 3], derivatives[:, 2, 3])
    thrust = sign * np.sqrt((force[0] ** 2).sum(axis=0))
    torque = _torque(rate, acceleration, vehicle)
    return FlatOutputs(
        force[0].T,
        axis[0].T,
        _attitude(axis[0], inverted, gamma, yaw),
        rate.T,
        acceleration.T,
        thrust,
        torque.T,
        rotor_thrusts(thrust, torque, vehicle).T,
        vertical,
        charts,
    )


def rotor_slopes(
    t: Array, derivatives: Array, vehicle: Vehicle, flips: Sequence[float] = (), charts: Charts | None = None
) -> tuple[Array, Array]:
    """Rotor thrusts (S, 4) and their exact slopes (S, 4, 5, 4) over derivatives 0..4 of x, y, z, yaw; arguments as for
    `inverse_dynamics`, and not at a flip itself, where there is no slope.

    Reverse thrust and chart C are upright thrust of the mirrored force: s R_f F, R_f half a turn about a horizontal
    axis. The kernel knows only that.
    """
    out = inverse_dynamics(t, derivatives, vehicle, flips, charts)
    inverted, gamma, offset = out.charts.at(t)
    c, s = np.where(inverted, [np.cos(2.0 * gamma), np.sin(2.0 * gamma)], 0.0)
    mirror = np.tile(np.eye(3), (len(t), 1, 1))
    mirror[inverted] = 0.0
    mirror[inverted, 0, 0], mirror[inverted, 1, 1], mirror[inverted, 2, 2] = c[inverted], -c[inverted], -1.0
    mirror[inverted, 0, 1] = mirror[inverted, 1, 0] = s[inverted]
    sign = np.where(out.thrust < 0.0, -1.0, 1.0)
    mirror *= sign[:, None, None]
    gravity = np.array([0.0, 0.0, GRAVITY])
    vectors = derivatives[:, 2:5, :3].copy()
    vectors[:, 0] += gravity
    vectors = np.einsum("sij,sdj->sdi", mirror, vectors)
    vectors[:, 0] -= gravity
    yaw = derivatives[:, :3, 3].copy()
    yaw[:, 0] += offset
    rotors, by = kernel.rotor_slopes(np.concatenate([vectors.reshape(-1, 9), yaw], axis=1), kernel_vehicle(vehicle))
    slopes = np.zeros((len(t), 4, 5, 4))
    slopes[:, :, 2:, :3] = np.einsum("sij,srdj->srdi", mirror, by[:, :, :9].reshape(-1, 4, 3, 3))
    slopes[:, :, :3, 3] = by[:, :, 9:]
    turned = (sign - 1.0) / 4.0  # the kernel's total thrust is |F|
    slopes[:, :, 2, :3] += (turned * vehicle.mass_kg / out.force_size)[:, None, None] * out.force[:, None]
    return rotors + (turned * out.force_size)[:, None], slopes


def kernel_vehicle(vehicle: Vehicle) -> kernel.Vehicle:
    return kernel.Vehicle(
        mass=vehicle.mass_kg,
        inertia=list(vehicle.inertia_kg_m2),
        arm=vehicle.arm_m,
        yaw_coefficient=vehicle.yaw_coefficient_m,
        gravity=GRAVITY,
    )


def upright_outputs(derivatives: Array, vehicle: Vehicle, vertical: bool) -> tuple[Array, Array, Array]:
    """Rotor thrusts (4, ...), force (3, ...) and body rate (3, ...) of derivatives (6, 4, ...), chart A throughout.

    The fast form for optimising upright flight: s = +1, or purely vertical with signed thrust; n_z must stay above -1.
    """
    force = vehicle.mass_kg * derivatives[2:5, :3]
    force[0, 2] += vehicle.weight
    if vertical:
        axis = np.zeros_like(force)
        axis[0, 2] = 1.0
        thrust = force[0, 2]
    else:
        axis = _unit(force, 1.0)
        thrust = np.sqrt((force[0] ** 2).sum(axis=0))
    rate, acceleration = _body_rate(axis, derivatives[0, 3], derivatives[1, 3], derivatives[2, 3])
    return rotor_thrusts(thrust, _torque(rate, acceleration, vehicle), vehicle), force[0], rate


def planar_outputs(derivatives: Array, vehicle: Vehicle, sign: Array) -> tuple[Array, Array, Array]:
    """As `upright_outputs`, of flight in the x-z plane with constant yaw that may turn over: any attitude, thrust of
    this sign (1 or -1, broadcast), F anything but zero. It needs no chart."""
    force = vehicle.mass_kg * derivatives[2:5, :3]
    force[0, 2] += vehicle.weight
    axis = sign * _unit(force, 1.0)
    thrust = sign * np.sqrt((force[0] ** 2).sum(axis=0))
    (x, _, z), (x1, _, z1), (x2, _, z2) = axis
    turning, quickening = z * x1 - x * z1, z * x2 - x * z2  # about y
    yaw = derivatives[0, 3]
    about = np.stack([np.sin(yaw), np.cos(yaw), np.zeros_like(yaw)])
    rate, acceleration = turning * about, quickening * about
    return rotor_thrusts(thrust, _torque(rate, acceleration, vehicle), vehicle), force[0], rate


def rotor_thrusts(thrust: Array, torque: Array, vehicle: Vehicle) -> Array:
    """(4, ...) [N] from signed total thrust (...) and torque (3, ...).   Eq 4 inverted"""
    x, y, z = (
        torque[0] / (2.0 * vehicle.arm_m),
        torque[1] / (2.0 * vehicle.arm_m),
        torque[2] / (4.0 * vehicle.yaw_coefficient_m),
    )
    T = thrust / 4.0
    return np.stack([T + x - z, T + y + z, T - x - z, T - y + z])


def _force_and_derivatives(derivatives: Array, vehicle: Vehicle) -> tuple[Array, NDArray[np.bool_]]:
    """F, F', F'', F''' as (4, 3, S), and where the flight is purely vertical."""
    force = vehicle.mass_kg * np.moveaxis(derivatives[:, 2:6, :3], 0, -1)
    force[0, 2] += vehicle.weight
    vertical = np.all(np.abs(force[:3, :2]) <= _VERTICAL * vehicle.weight, axis=(0, 1))
    return force, vertical


def _thrust_axis(t: Array, force: Array, sign: Array, vertical: NDArray[np.bool_], flips: Array) -> Array:
    """n, n', n'' as (3, 3, S).   Eq 19 and one derivative more; at F = 0 its limit"""
    up = np.zeros_like(force[:3])
    up[0, 2] = 1.0
    along = np.where(vertical, up, force[:3])
    for k, flip in enumerate(flips):  # u = F/(t - flip) is smooth through F = 0; its series is exact to (t - flip)³
        size, away = np.abs(force[0]).max(axis=0), np.abs(t - flip)
        near = (size < np.where(away < QUICK_TIME, QUICK_FORCE, NEAR_ZERO_FORCE)) & (away < NEAR_ZERO_TIME)
        since = (t - flip)[near]
        _, f1, f2, f3 = force[:, :, near]
        along[:, :, near] = f1 - f2 * since / 2.0 + f3 * since**2 / 6.0, f2 / 2.0 - f3 * since / 3.0, f3 / 3.0
        sign = np.where(near, 1.0 if k % 2 else -1.0, sign)  # on both sides the sign of after the flip
    return _unit(along, sign)


def _unit(along: Array, sign: Array | float) -> Array:
    """n = s u/|u| with n', n'' from u, u', u'' as (3, 3, ...)."""
    u0, u1, u2 = along
    size = np.sqrt((u0 * u0).sum(axis=0))
    size = np.maximum(size, 1e-12)
    n = u0 / size
    r1 = (n * u1).sum(axis=0)
    n1 = (u1 - n * r1) / size
    r2 = (n1 * u1).sum(axis=0) + (n * u2).sum(axis=0)
    n2 = (u2 - 2.0 * n1 * r1 - n * r2) / size
    return sign * np.stack([n, n1, n2])


def _find_charts(t: Array, axis: Array, turns: Sequence[tuple[float, float]] | None) -> Charts:
    """Changes of sign of n_z; between samples n is continued with its two derivatives."""
    below = axis[0, 2] < 0.0
    changes, inverted, gamma, offset = [], [bool(below[0])], [0.0], [0.0]
    for k in np.flatnonzero(below[1:] != below[:-1]) + 1:
        if turns is not None and not any(start <= t[k] <= end for start, end in turns):
            continue
        nearer = int(k) - int(abs(axis[0, 2, k - 1]) < abs(axis[0, 2, k]))
        n, n1, n2 = axis[:, :, nearer]
        step = -n[2] / n1[2] if n1[2] != 0.0 else 0.0
        step -= (n[2] + n1[2] * step + n2[2] * step**2 / 2.0) / (n1[2] + n2[2] * step or np.inf)
        step = float(np.clip(step, t[k - 1] - t[nearer], t[k] - t[nearer]))
        across = n + n1 * step + n2 * step**2 / 2.0
        heading = float(np.arctan2(across[0], -across[1]))  # phi + pi/2: both charts agree here
        changes.append(float(t[nearer]) + step)
        if inverted[-1]:
            offset.append(offset[-1] + 2.0 * _half_turn(heading - gamma[-1]))
            gamma.append(0.0)
        else:
            offset.append(offset[-1])
            gamma.append(heading)
        inverted.append(not inverted[-1])
    return Charts(np.array(changes), np.array(inverted), np.array(gamma), np.array(offset))


def _half_turn(angle: float) -> float:
    """Into [-pi/2, pi/2): twice of it is an angle."""
    return float((angle + np.pi / 2.0) % np.pi - np.pi / 2.0)


def _turned(axis: Array, inverted: NDArray[np.bool_], gamma: Array) -> Array:
    """R_f n and derivatives where inverted: half a turn about the horizontal axis at heading gamma."""
    if not inverted.any():
        return axis
    x, y, z = axis[:, 0], axis[:, 1], axis[:, 2]
    c, s = np.cos(2.0 * gamma), np.sin(2.0 * gamma)
    return np.where(inverted, np.stack([c * x + s * y, s * x - c * y, -z], axis=1), axis)


def _body_rate(axis: Array, yaw: Array, yaw_rate: Array, yaw_acceleration: Array) -> tuple[Array, Array]:
    """Rate and acceleration in D of the least rotation e3 -> n followed by yaw.   Eqs 13, 15-18"""
    (a, b, c), (a1, b1, c1), (a2, b2, c2) = axis
    D = np.maximum(1.0 + c, 1e-6)
    k = c1 / D
    k1 = c2 / D - k * k
    spin, spin1 = b * a1 - a * b1, b * a2 - a * b2
    w = np.stack([-b1 + b * k, a1 - a * k, spin / D])
    dw = np.stack([-b2 + b1 * k + b * k1, a2 - a1 * k - a * k1, (spin1 - spin * k) / D])
    cos, sin = np.cos(yaw), np.sin(yaw)
    rate = np.stack([cos * w[0] + sin * w[1], cos * w[1] - sin * w[0], w[2] + yaw_rate])
    acceleration = np.stack(
        [
            cos * dw[0] + sin * dw[1] + yaw_rate * rate[1],
            cos * dw[1] - sin * dw[0] - yaw_rate * rate[0],
            dw[2] + yaw_acceleration,
        ]
    )
    return rate, acceleration


def _torque(rate: Array, acceleration: Array, vehicle: Vehicle) -> Array:
    """J dw + w x J w.   Eq 3"""
    jx, jy, jz = vehicle.inertia_kg_m2
    p, q, r = rate
    return np.stack(
        [
            jx * acceleration[0] + (jz - jy) * q * r,
            jy * acceleration[1] + (jx - jz) * r * p,
            jz * acceleration[2] + (jy - jx) * p * q,
        ]
    )


def _attitude(n: Array, inverted: NDArray[np.bool_], gamma: Array, yaw: Array) -> Array:
    """(S, 4): q_WD with one sign throughout.   Eqs 12, 13"""
    turned = _turned(n[None], inverted, gamma)[0]
    scale = 1.0 / np.sqrt(2.0 * np.maximum(1.0 + turned[2], 1e-12))
    tilt = np.stack([(1.0 + turned[2]) * scale, -turned[1] * scale, turned[0] * scale, np.zeros_like(scale)])
    w, x, y, _ = tilt
    cg, sg = np.cos(gamma), np.sin(gamma)
    over = np.stack([-cg * x - sg * y, cg * w, sg * w, cg * y - sg * x])  # (0, cos, sin, 0) * tilt
    w, x, y, z = np.where(inverted, over, tilt)
    ch, sh = np.cos(yaw / 2.0), np.sin(yaw / 2.0)
    q = np.stack([w * ch - z * sh, x * ch + y * sh, y * ch - x * sh, z * ch + w * sh], axis=1)
    same_side = np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    q[1:] *= np.cumprod(same_side)[:, None]
    return q
