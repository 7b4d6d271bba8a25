"""Stretches that turn over, with virtual knots: the flight that mode `best` finds for them.

Why: the paper's polynomials have one piece a leg and meet with continuity through the 8th derivative; most of what a
flip could save is lost to that. Here each leg is cut into pieces that need only be as smooth as rotor commands: through
the 4th derivative, and through the 5th where the thrust changes its sign, because the torque there depends on it.

The unknowns are the durations of the legs (in their logarithm) and derivatives 0..4 of x and z at the knots, each
counted by a power of the knot's own time scale, so that a change of durations alone only rescales time. They start at
the paper's flight, which such pieces contain. Slopes of the margins are exact, by complex steps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll.planner.central_path import Slopes, minimised
from halfroll.planner.flatness import planar_outputs
from halfroll.planner.limits import Limits, margins, relative_margins
from halfroll.planner.minimum_time import Stretch
from halfroll.planner.segments import GIVEN, ORDER, PiecewisePolynomial, monomials
from halfroll.vehicle import GRAVITY, Vehicle

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_PLANAR = (0, 2)  # of x, y, z, yaw: those that move
_ORDERS = 6
_SAMPLES = 24  # of a piece
_INSIDE = 2e-3  # of a piece: at zero force there is a limit, but no value
_COMPLEX = 1e-25
_X_UNIT, _U_UNIT = 10.0, 0.3  # of the unknowns: 10 m/s² times the square of the time scale; log duration
_PARTS = (2, 4)  # of a leg, one after the other
_FEW_LEGS = 2  # of which a leg gets the second, too: for more it costs ten times as long, and gains a percent
# Barriers, and the relative margin below which limits start shifted:
_FROM_PAPER, _FROM_KNOTS, _REPAIR = ((3e-4, 4e-5, 5e-6), 0.02), ((4e-5, 5e-6), 0.02), ((1e-4, 2e-5, 5e-6), 1e-4)
_REPAIRS = 6
_HOPELESS = -1.0  # relative margin: commands that rotors need may begin half as large again as they can be
_LEAST_FORCE = 0.04  # weights, where the thrust keeps its sign: else force, and with it attitude, may turn at once
_SPARE = 1e-5  # relative margin left for the proof
_LOWER = 1e-3  # [m] than the paper's flight, at most: what room it leaves is its room


def _hermite() -> Array:
    """(10, 10): coefficients from derivatives 0..4 by tau at 0, then at 1."""
    ends = np.concatenate([monomials(np.array([at]), d) for at in (0.0, 1.0) for d in range(GIVEN)])
    return np.asarray(np.linalg.inv(ends))


_HERMITE = _hermite()
_ENDS = np.tile(np.arange(GIVEN), 2)  # order of each of a piece's end derivatives: the power of its duration
_FIFTH = np.concatenate([monomials(np.array([at]), 5) @ _HERMITE for at in (1.0, 0.0)])  # where a piece ends, begins


def _table(samples: int, begins: bool, ends: bool) -> Array:
    """(6, samples+1, 10): derivatives by tau from those at the ends; a little inside where there is a reversal."""
    tau = np.clip(np.arange(samples + 1) / samples, _INSIDE if begins else 0.0, 1.0 - _INSIDE if ends else 1.0)
    return np.stack([monomials(tau, order) @ _HERMITE for order in range(_ORDERS)])


@dataclass(frozen=True)
class KnottedFlight:
    path: PiecewisePolynomial  # in axes of the plane
    leg_ends: Array  # (M,) [s]
    flips: tuple[float, ...]

    @property
    def total(self) -> float:
        return float(self.path.times[-1])


def shortened(
    stretch: Stretch,
    vehicle: Vehicle,
    limits: Limits,
    path: PiecewisePolynomial,
    told: Callable[[float], None],
) -> KnottedFlight | None:
    """A shorter flight than `path`, the paper's for this stretch, never lower than it; None if none is found."""
    lowest = float(path.at(np.linspace(0.0, path.times[-1], 1000))[:, 2].min()) - _LOWER
    limits = replace(limits, floor=lowest if limits.floor is None else max(limits.floor, lowest))
    best, leg_ends = None, path.times[1:]
    for parts, start in zip(_PARTS, (_FROM_PAPER, _FROM_KNOTS), strict=True):
        knotted = _Knotted(stretch, vehicle, limits, path, np.diff(leg_ends, prepend=0.0), parts)
        flight = knotted.searched(start, told)
        if flight is None or (best is not None and flight.total >= best.total):
            break
        best, path, leg_ends = flight, flight.path, flight.leg_ends
        if stretch.legs > _FEW_LEGS:
            break
    return best


class _Knotted:
    """The unknowns, and their flight: durations (N,) of its pieces, derivatives (N+1, 5, 2) at its knots."""

    def __init__(
        self,
        stretch: Stretch,
        vehicle: Vehicle,
        limits: Limits,
        path: PiecewisePolynomial,
        leg_durations: Array,
        parts: int,
    ) -> None:
        assert stretch.thrust_sign is not None
        self.stretch, self.vehicle, self.limits = stretch, vehicle, limits
        self.legs, self.parts, self.pieces = stretch.legs, parts, stretch.legs * parts
        self.leg = np.repeat(np.arange(self.legs), parts)
        self.sign = np.repeat(stretch.thrust_sign, parts)
        self.reversals = [int(k) + 1 for k in np.flatnonzero(np.diff(self.sign))]
        fixed = np.full((self.pieces + 1, GIVEN, 2), np.nan)
        fixed[::parts] = stretch.nodes[:, :, _PLANAR]
        self.lines = [(line.node * parts, line.along[:, _PLANAR]) for line in stretch.lines]
        self.free = np.isnan(fixed)
        self.free[self.reversals, 4] = False  # follows
        self.fixed = np.nan_to_num(fixed)
        self.node, self.order, _ = np.nonzero(self.free)
        at = np.isin(np.arange(self.pieces + 1), self.reversals)
        self.keeps_sign = ~(at[:-1] | at[1:])
        beside = list(zip(at[:-1].tolist(), at[1:].tolist(), strict=True))
        self.table, self.fine_table = (
            np.stack([_table(samples, *reversal) for reversal in beside]) for samples in (_SAMPLES, 20 * _SAMPLES)
        )
        self._begin(path, leg_durations)
        self.tightened = np.zeros((self.pieces, len(self._rows(self._derivatives(self.start, self.table)))))

    def _begin(self, path: PiecewisePolynomial, leg_durations: Array) -> None:
        T = leg_durations[self.leg] / self.parts
        values = path.derivatives(np.concatenate([[0.0], np.cumsum(T)]), GIVEN)[:, :, _PLANAR]
        scale = _time_scale(T)
        self.unit = _X_UNIT * scale[self.node] ** 2
        x = values[self.free] * scale[self.node] ** self.order / self.unit
        on_lines = [float(np.vdot(along, values[k] - self.fixed[k]) / np.vdot(along, along)) for k, along in self.lines]
        self.start = np.concatenate([np.log(leg_durations) / _U_UNIT, x, on_lines])
        self.scale = float(leg_durations.sum())

    def flight(self, z: Array) -> tuple[Array, Array]:
        free = len(self.unit)
        T = np.exp(_U_UNIT * z[: self.legs])[self.leg] / self.parts
        y = self.fixed.copy()
        y[self.free] = z[self.legs : self.legs + free] * self.unit / _time_scale(T)[self.node] ** self.order
        for (k, along), value in zip(self.lines, z[self.legs + free :], strict=True):
            y[k] += value * along
        for k in self.reversals:  # its snap is what makes the 5th derivative continuous
            before, after = self._fifth(T, k)
            jump = before @ y[k - 1 : k + 1].reshape(10, 2) - after @ y[k : k + 2].reshape(10, 2)
            y[k, 4] = -jump / (before[9] - after[4])
        return T, y

    def _fifth(self, T: Array, k: int) -> tuple[Array, Array]:
        """What the ends of the pieces before and after node k make of the 5th derivative there, (10,) each."""
        return _FIFTH[0] * T[k - 1] ** (_ENDS - 5.0), _FIFTH[1] * T[k] ** (_ENDS - 5.0)

    def _flight_slopes(self, T: Array, y: Array) -> Array:
        """(N+1, 5, 2, n) of the derivatives at the knots."""
        free, (node, order, axis) = len(self.unit), np.nonzero(self.free)
        slopes = np.zeros((*y.shape, len(self.start)))
        slopes[node, order, axis, self.legs + np.arange(free)] = self.unit / _time_scale(T)[node] ** order
        for beside in (node - 1, node):  # of inner nodes: all others are at rest
            slopes[node, order, axis, self.leg[beside]] -= 0.5 * _U_UNIT * order * y[self.free]
        for i, (k, along) in enumerate(self.lines):
            slopes[k, :, :, self.legs + free + i] += along
        for k in self.reversals:
            before, after = self._fifth(T, k)
            left, right = slopes[k - 1 : k + 1].reshape(10, 2, -1), slopes[k : k + 2].reshape(10, 2, -1)
            jump = np.tensordot(before, left, 1) - np.tensordot(after, right, 1)
            jump[:, self.leg[k - 1]] += _U_UNIT * ((_ENDS - 5.0) * before) @ y[k - 1 : k + 1].reshape(10, 2)
            jump[:, self.leg[k]] -= _U_UNIT * ((_ENDS - 5.0) * after) @ y[k : k + 2].reshape(10, 2)
            slopes[k, 4] = -jump / (before[9] - after[4])
        return slopes

    def _derivatives(self, z: Array, table: Array) -> Array:
        """(6, 2, N, samples)"""
        T, y = self.flight(z)
        ends = np.concatenate([y[:-1], y[1:]], axis=1)  # (N, 10, 2)
        return np.asarray((self._weighted(T, table) @ ends[:, None]).transpose(1, 3, 0, 2))

    def _weighted(self, T: Array, table: Array) -> Array:
        """(N, 6, samples, 10): derivatives by time from those at the ends; table: by tau."""
        power = _ENDS - np.arange(_ORDERS)[:, None, None]
        return np.asarray(table * T[:, None, None, None] ** power)

    # ---- what central_path asks

    def total(self, z: Array) -> tuple[float, Array, Array]:
        slopes = np.zeros(len(z))
        slopes[: self.legs] = _U_UNIT * np.exp(_U_UNIT * z[: self.legs]) / self.scale
        return float(slopes.sum()) / _U_UNIT, slopes, _U_UNIT * slopes

    def margins(self, z: Array) -> Array:
        found = self._rows(self._derivatives(z, self.table)).transpose(1, 2, 0) - self.tightened[:, None]
        return np.asarray(found.reshape(self.pieces, -1))

    def slopes(self, z: Array) -> Slopes:
        T, y = self.flight(z)
        derivatives = self._derivatives(z, self.table)
        moved = np.repeat(derivatives[:, :, None].astype(complex), 2 * _ORDERS, axis=2)
        for order in range(_ORDERS):
            for axis in (0, 1):
                moved[order, axis, 2 * order + axis] += 1j * _COMPLEX
        found = self._rows(moved).imag / _COMPLEX  # (rows, 12, N, samples)
        by = found.reshape(len(found), _ORDERS, 2, self.pieces, -1).transpose(3, 4, 0, 2, 1)  # (N, samples, rows, 2, 6)
        weighted = self._weighted(T, self.table).transpose(0, 2, 1, 3)  # (N, samples, 6, 10)
        by_ends = (by @ weighted[:, :, None]).swapaxes(3, 4).reshape(self.pieces, -1, 20)
        ends = np.concatenate([y[:-1], y[1:]], axis=1)
        by_time = (weighted * (_ENDS - np.arange(_ORDERS)[:, None])) @ ends[:, None]  # (N, samples, 6, 2)
        by_time = np.einsum("ksqar,ksra->ksq", by, by_time).reshape(self.pieces, -1, 1)
        knots = self._flight_slopes(T, y).reshape(self.pieces + 1, 10, -1)
        times = np.zeros((self.pieces, 1, len(z)))
        times[np.arange(self.pieces), 0, self.leg] = _U_UNIT
        return Slopes(
            np.concatenate([by_ends, by_time], axis=2), np.concatenate([knots[:-1], knots[1:], times], axis=1)
        )

    def _rows(self, derivatives: Array | Complex) -> Any:
        """(rows, ..): relative margins of derivatives (6, 2, .., N, samples) of x and z."""
        flat = np.zeros((GIVEN, 4, *derivatives.shape[2:]), dtype=derivatives.dtype)
        flat[:, _PLANAR] = derivatives[:GIVEN]
        flat[0, 3] = self.stretch.nodes[0, 0, 3]
        sign, limits = self.sign[:, None], self.limits
        rotors, force, rate = planar_outputs(flat, self.vehicle, sign)
        found = relative_margins(
            self.vehicle,
            limits,
            rotors=rotors,
            force=force,
            rate=rate,
            velocity=flat[1, :3],
            height=flat[0, 2],
            speed_max=np.minimum(self.stretch.speed_max, limits.speed_max or np.inf)[self.leg][:, None],
            exempt=False,
        )
        size = np.sqrt((force * force).sum(axis=0)) / self.vehicle.weight - _LEAST_FORCE
        rows = [found, np.where(self.keeps_sign[:, None], size, 1.0)[None]]
        rates = planar_rotor_rates(derivatives, flat[0, 3], self.vehicle, sign)
        if limits.rotor_rate_max is not None:
            rows += [1.0 - rates / limits.rotor_rate_max, 1.0 + rates / limits.rotor_rate_max]
        if limits.drive is not None:  # only variable pitch turns over
            command, most = rotors + limits.drive.lag_up * rates, self.vehicle.rotor.thrust_max_N
            rows += [(limits.drive.command_max - command) / most, (command - limits.drive.command_min) / most]
        return np.concatenate(rows)

    # ---- from search to flight

    def searched(self, start: tuple[Sequence[float], float], told: Callable[[float], None]) -> KnottedFlight | None:
        """The shortest flight whose margins hold between the samples, too; None if they never do."""
        z = self.start
        if not self.margins(z).min() > _HOPELESS:
            return None
        for _ in range(_REPAIRS):
            z = minimised(self, z, *start, lambda z: told(self.scale * self.total(z)[0]))
            flight = self._as_flight(z)
            dense = self._dense(z, flight)
            if dense.min() >= _SPARE:
                return flight
            sampled = self.margins(z).reshape(self.pieces, -1, dense.shape[1]).min(axis=1) + self.tightened
            close = dense < 2.0 * _SPARE
            asked = np.maximum(self.tightened, 1.1 * (sampled - dense) + 2.0 * _SPARE)
            self.tightened = np.where(close, asked, self.tightened)
            start = _REPAIR
        return None

    def _dense(self, z: Array, flight: KnottedFlight) -> Array:
        """(N, rows): least margins."""
        dense = self._rows(self._derivatives(z, self.fine_table)).min(axis=2).T
        speed = np.minimum(self.stretch.speed_max, np.inf)[self.leg]
        refined = margins(
            flight.path, self.vehicle, self.limits, segment_speed_max=speed, flips=flight.flips
        ).by_segment.T
        dense[:, : refined.shape[1]] = np.minimum(dense[:, : refined.shape[1]], refined)
        return np.asarray(dense)

    def _as_flight(self, z: Array) -> KnottedFlight:
        T, y = self.flight(z)
        ends = np.concatenate([y[:-1], y[1:]], axis=1) * T[:, None, None] ** _ENDS[:, None]
        coefficients = np.zeros((self.pieces, ORDER, 4))
        coefficients[:, :, _PLANAR] = _HERMITE @ ends
        coefficients[:, 0, 3] = self.stretch.nodes[0, 0, 3]
        times = np.concatenate([[0.0], np.cumsum(T)])
        before = (-1.0,) if self.sign[0] < 0.0 else ()
        return KnottedFlight(
            PiecewisePolynomial(times, coefficients),
            times[self.parts :: self.parts],
            (*before, *times[self.reversals].tolist()),
        )


def _time_scale(T: Array) -> Array:
    """(N+1,) of each knot: between the durations beside it."""
    return np.concatenate([T[:1], np.sqrt(T[:-1] * T[1:]), T[-1:]])


def planar_rotor_rates(derivatives: Any, yaw: Any, vehicle: Vehicle, sign: Array) -> Any:
    """(4, ..) [N/s]: how quickly rotor thrusts change in the x-z plane, from derivatives 0..5 of x and z (6, 2, ..)."""
    (fx, fz), (jx, jz), (sx, sz), (cx, cz) = derivatives[2:]
    fz = fz + GRAVITY
    square, along = fx * fx + fz * fz, fx * jx + fz * jz
    further = jx * jx + jz * jz + fx * sx + fz * sz  # along, by time
    turning = (fz * jx - fx * jz) / square
    quickening = (fz * sx - fx * sz - 2.0 * turning * along) / square
    jolt = (jz * sx + fz * cx - jx * sz - fx * cz - 2.0 * (turning * further + 2.0 * quickening * along)) / square
    thrust = 0.25 * vehicle.mass_kg * sign * along / np.sqrt(square)
    jx_kg_m2, jy_kg_m2, _ = vehicle.inertia_kg_m2
    x = 0.5 * jx_kg_m2 / vehicle.arm_m * np.sin(yaw) * jolt
    y = 0.5 * jy_kg_m2 / vehicle.arm_m * np.cos(yaw) * jolt
    z = 0.5 * (jy_kg_m2 - jx_kg_m2) / vehicle.yaw_coefficient_m * np.sin(yaw) * np.cos(yaw) * turning * quickening
    return np.stack([thrust + x - z, thrust + y + z, thrust - x - z, thrust - y + z])
