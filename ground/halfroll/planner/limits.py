"""Limits of a flight, and the margins a trajectory leaves to them (>= 0 is flyable).

Why: what "feasible" means is written once; the optimiser and the final check use the same rows. The final check is
dense sampling with every near-critical extremum refined between the samples, which finds the true
extrema of anything smooth on the scale of a thousandth of a piece. It is a check, not a proof: a proof by Taylor models
over whole pieces can take its place behind the same `margins`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfroll.errors import InputError
from halfroll.planner.flatness import FlatOutputs, inverse_dynamics
from halfroll.planner.segments import PiecewisePolynomial
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]

_FLOOR = 0.5  # [m], lowest height outside takeoff and landing
_FIXED_PITCH_LIFT = 0.65  # of the weight: the outer loop clamps at 0.5, and feedback needs room above that
_REFINE_BELOW = 0.02  # relative margin under which every local extremum is refined
_REFINE_ROUNDS, _REFINE_POINTS = 6, 9


RATE_ROOM = 1.3  # lags are planned with as if they were so much longer: feedback needs some of the rate


@dataclass(frozen=True)
class Drive:
    """How rotors follow commands, and the commands they take [N]: what limits how quickly thrust can change.

    Variable pitch: thrust lags its command c, so that following f takes c = f + lag f'. Fixed pitch: the speed of the
    motor, sqrt(f), does, and following takes the speed sqrt(f) + lag f'/(2 sqrt(f)), whatever share of the lag the
    autopilot's LAG_COMP hides.
    """

    lag_up: float  # [s]
    lag_down: float
    of_speed: bool
    command_min: float
    command_max: float

    @classmethod
    def of(cls, vehicle: Vehicle, command_min: float, command_max: float) -> Drive:
        rotor = vehicle.rotor
        lag_up, lag_down = RATE_ROOM * rotor.lag_s, RATE_ROOM * rotor.lag_down_s
        return cls(lag_up, lag_down, not vehicle.variable_pitch, command_min, command_max)


@dataclass(frozen=True)
class Limits:
    """None switches a limit off. SI units; thrusts per rotor and signed."""

    rotor_min: float
    rotor_max: float
    speed_max: float | None = None
    floor: float | None = None  # lowest height in W
    body_rate_max: float | None = None
    force_z_min: float | None = None  # upright flight; not asked of purely vertical flight with variable pitch
    force_min: float | None = None  # |F|: keeps the attitude from turning at once; the same exception
    rotor_rate_max: float | None = None  # [N/s], either way
    drive: Drive | None = None
    tilt_max: float | None = None  # of the thrust axis from the vertical; the same exception
    ceiling: float | None = None  # greatest height in W

    @classmethod
    def of(
        cls, vehicle: Vehicle, kind: Literal["mission", "rotors"] = "mission", margin: float | None = None
    ) -> Limits:
        """`mission`: rotor thrust with a margin (0.1: ten percent of the largest thrust, on both sides, but never more
        than half the way to hover on the lower), speed, body rate, floor, and a vertical force that the outer loop can
        hold upright. `rotors`: rotor thrust alone, margin 0.

        Both keep the thrust axis above the horizon: fixed pitch F_z >= 4 f_min, in missions
        well above half the weight, where its outer loop clamps; variable pitch a small part of the weight.
        """
        rotor, mission = vehicle.rotor, kind == "mission"
        margin = (0.1 if mission else 0.0) if margin is None else margin
        hover = vehicle.weight / 4.0
        lower = min(rotor.thrust_min_N + margin * rotor.thrust_max_N, (rotor.thrust_min_N + hover) / 2.0)
        if vehicle.variable_pitch:
            force_z_min = (0.1 if mission else 0.04) * vehicle.weight
        else:
            force_z_min = max(4.0 * rotor.thrust_min_N, _FIXED_PITCH_LIFT * vehicle.weight if mission else 0.0)
        rotor_min = lower if margin > 0.0 else rotor.thrust_min_N
        rotor_max = (1.0 - margin) * rotor.thrust_max_N
        return cls(
            rotor_min=rotor_min,
            rotor_max=rotor_max,
            speed_max=vehicle.speed_max_m_s if mission else None,
            floor=_FLOOR if mission else None,
            body_rate_max=vehicle.body_rate_max_rad_s if mission else None,
            force_z_min=force_z_min,
            rotor_rate_max=(1.0 - margin) * rotor.slew_N_s if mission else None,
            drive=Drive.of(vehicle, rotor_min, rotor_max) if mission else None,
        )

    @property
    def inverted(self) -> Limits:
        """Of the mirror image of a flight that is flown inverted: there pushing down is pulling up."""
        drive = self.drive
        if drive is not None:
            drive = replace(drive, command_min=-drive.command_max, command_max=-drive.command_min)
        return replace(self, rotor_min=-self.rotor_max, rotor_max=-self.rotor_min, drive=drive)


@dataclass(frozen=True)
class Setting:
    """A limit that a person may set: which, in which unit, and what it means."""

    field: str
    unit: float  # in SI
    meaning: str


SETTABLE = {
    "speed_m_s": Setting("speed_max", 1.0, "speed"),
    "tilt_deg": Setting("tilt_max", np.pi / 180.0, "tilt of the thrust axis from upright"),
    "body_rate_deg_s": Setting("body_rate_max", np.pi / 180.0, "body rate"),
    "rotor_rate_N_s": Setting("rotor_rate_max", 1.0, "how quickly the thrust of a rotor changes"),
    "floor_m": Setting("floor", 1.0, "lowest height above the origin"),
    "ceiling_m": Setting("ceiling", 1.0, "greatest height above the origin"),
}


def changed(limits: Limits, changes: Iterable[tuple[str, float | None]]) -> Limits:
    """With some set anew, by the names of SETTABLE; None switches one off. Raises InputError."""
    for name, number in changes:
        if name not in SETTABLE:
            raise InputError(f"limit {name!r} is not known; there are {', '.join(SETTABLE)}")
        setting = SETTABLE[name]
        if number is not None and not np.isfinite(number):
            raise InputError(f"limit {name} is {number:g}, a finite number is wanted, or off")
        if number is not None and number <= 0.0 and not name.endswith("_m"):
            raise InputError(f"limit {name} is {number:g}, nothing could fly; give more than 0, or off")
        if name == "tilt_deg" and number is not None and number >= 90.0:
            raise InputError(f"limit tilt_deg is {number:g}: the horizon is at 90; give less, or off")
        one: dict[str, Any] = {setting.field: None if number is None else number * setting.unit}
        limits = replace(limits, **one)
    if limits.floor is not None and limits.ceiling is not None and limits.floor >= limits.ceiling:
        raise InputError(f"the floor of {limits.floor:g} m is not below the ceiling of {limits.ceiling:g} m; move one")
    return limits


@dataclass(frozen=True)
class Extreme:
    """Where one quantity comes closest to its limit, or farthest beyond."""

    limit: str  # rotor_min, rotor_max, speed, floor, ceiling, body_rate, force_z, force, tilt
    rotor: int | None  # 1..4
    segment: int
    time: float
    quantity: float
    allowed: float
    relative: float  # margin over a scale of its own; >= 0 is flyable

    @property
    def margin(self) -> float:
        """In the quantity's unit."""
        return self.quantity - self.allowed if self.limit in _LOWER else self.allowed - self.quantity


_LOWER = ("rotor_min", "floor", "force_z", "force", "tilt")  # tilt by its cosine


@dataclass(frozen=True)
class Margins:
    extremes: tuple[Extreme, ...]  # the worst of each limit and rotor, in the order of `rows`
    by_segment: Array  # (rows, N) relative margins, the least of each segment
    rotor_min: tuple[float, ...]  # [N], smallest thrust of each rotor
    rotor_max: tuple[float, ...]

    @property
    def worst(self) -> Extreme:
        return min(self.extremes, key=lambda extreme: extreme.relative)

    @property
    def checked(self) -> bool:
        """True if no limit is exceeded."""
        return self.worst.relative >= 0.0

    @property
    def violation(self) -> float:
        """[N], by how much a rotor exceeds its limit; 0 if none does."""
        return max(0.0, *(-extreme.margin for extreme in self.extremes if extreme.limit in ("rotor_min", "rotor_max")))


@dataclass(frozen=True)
class Row:
    limit: str
    rotor: int | None
    allowed: float  # NaN: depends on the segment
    scale: float


def rows(vehicle: Vehicle, limits: Limits) -> list[Row]:
    """The rows of `relative_margins`, in its order."""
    named = [Row("rotor_min", i, limits.rotor_min, vehicle.rotor.thrust_max_N) for i in range(1, 5)]
    named += [Row("rotor_max", i, limits.rotor_max, vehicle.rotor.thrust_max_N) for i in range(1, 5)]
    if limits.speed_max is not None:
        named.append(Row("speed", None, np.nan, limits.speed_max))
    if limits.floor is not None:
        named.append(Row("floor", None, limits.floor, 1.0))
    if limits.ceiling is not None:
        named.append(Row("ceiling", None, limits.ceiling, 1.0))
    if limits.body_rate_max is not None:
        named.append(Row("body_rate", None, limits.body_rate_max, limits.body_rate_max))
    if limits.force_z_min is not None:
        named.append(Row("force_z", None, limits.force_z_min, vehicle.weight))
    if limits.force_min is not None:
        named.append(Row("force", None, limits.force_min, vehicle.weight))
    if limits.tilt_max is not None:
        named.append(Row("tilt", None, float(np.cos(limits.tilt_max)), 1.0))
    return named


def relative_margins(
    vehicle: Vehicle,
    limits: Limits,
    *,
    rotors: Array,
    force: Array,
    rate: Array,
    velocity: Array,
    height: Array,
    speed_max: Array,
    exempt: ArrayLike,
) -> Array:
    """(rows, ...): margin over scale of each limit. rotors (4, ...), force, rate and velocity (3, ...), height and
    speed_max (...); exempt: where the force limits do not apply (purely vertical with variable pitch)."""
    scale = vehicle.rotor.thrust_max_N
    found = [(rotors - limits.rotor_min) / scale, (limits.rotor_max - rotors) / scale]
    if limits.speed_max is not None:
        found.append((speed_max - _size(velocity))[None] / limits.speed_max)
    if limits.floor is not None:
        found.append((height - limits.floor)[None])
    if limits.ceiling is not None:
        found.append((limits.ceiling - height)[None])
    if limits.body_rate_max is not None:
        found.append(1.0 - _size(rate)[None] / limits.body_rate_max)
    if limits.force_z_min is not None:
        found.append(np.where(exempt, 1.0, (force[2] - limits.force_z_min) / vehicle.weight)[None])
    if limits.force_min is not None:
        found.append(np.where(exempt, 1.0, (_size(force) - limits.force_min) / vehicle.weight)[None])
    if limits.tilt_max is not None:
        upright = force[2] / np.maximum(_size(force), 1e-9)
        found.append(np.where(exempt, 1.0, upright - np.cos(limits.tilt_max))[None])
    return np.concatenate(found)


def _size(vector: Array) -> Array:
    return np.asarray(np.sqrt((vector * vector).sum(axis=0)))


def margins(
    trajectory: PiecewisePolynomial,
    vehicle: Vehicle,
    limits: Limits,
    samples_per_segment: int = 1000,
    *,
    segment_speed_max: ArrayLike | None = None,
    flips: Sequence[float] = (),
    turns: Sequence[tuple[float, float]] | None = None,
) -> Margins:
    """The smallest margin to each limit over the whole trajectory, and where.

    segment_speed_max (N,): speed limit of each segment where it is below limits.speed_max. flips, turns: as for
    `inverse_dynamics`. Of all local minima of a margin, the smallest and every one close to zero are refined.
    """
    t = _sample_times(trajectory, samples_per_segment)
    fastest = np.full(len(trajectory.durations), np.inf if limits.speed_max is None else limits.speed_max)
    if segment_speed_max is not None:
        fastest = np.minimum(fastest, np.asarray(segment_speed_max, dtype=float))

    def evaluate(t: Array, dense: FlatOutputs | None = None) -> tuple[Array, FlatOutputs]:
        derivatives = trajectory.derivatives(t)
        charts = None if dense is None else dense.charts
        outputs = inverse_dynamics(t, derivatives, vehicle, flips, charts, turns)
        found = relative_margins(
            vehicle,
            limits,
            rotors=outputs.rotors.T,
            force=outputs.force.T,
            rate=outputs.w_WD_D.T,
            velocity=derivatives[:, 1, :3].T,
            height=derivatives[:, 0, 2],
            speed_max=fastest[_segment(trajectory, t)],
            exempt=outputs.vertical & vehicle.variable_pitch,
        )
        return found, outputs

    sampled, dense = evaluate(t)
    row, k = _near_critical_minima(sampled)
    best_t, best = t[k], sampled[row, k]
    low, high = t[np.maximum(k - 1, 0)], t[np.minimum(k + 1, len(t) - 1)]
    for _ in range(_REFINE_ROUNDS):
        grid = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _REFINE_POINTS)
        order = np.argsort(grid, axis=None, kind="stable")
        unsorted = np.empty_like(order)
        unsorted[order] = np.arange(order.size)
        fine = evaluate(grid.ravel()[order], dense)[0][:, unsorted].reshape(-1, *grid.shape)
        fine = fine[row, np.arange(len(row))]
        at = fine.argmin(axis=1)
        chosen = np.arange(len(row)), at
        best_t = np.where(fine[chosen] < best, grid[chosen], best_t)
        best = np.minimum(best, fine[chosen])
        step = (high - low) / (_REFINE_POINTS - 1)
        low, high = np.maximum(low, best_t - step), np.minimum(high, best_t + step)
    starts = np.arange(len(fastest)) * samples_per_segment
    by_segment = np.minimum.reduceat(sampled, starts, axis=1)
    for i, segment, relative in zip(row, _segment(trajectory, best_t), best, strict=True):
        by_segment[i, segment] = min(by_segment[i, segment], relative)
    extremes = _extremes(trajectory, rows(vehicle, limits), row, best_t, best, fastest)
    return Margins(
        extremes,
        by_segment,
        tuple(extreme.quantity for extreme in extremes if extreme.limit == "rotor_min"),
        tuple(extreme.quantity for extreme in extremes if extreme.limit == "rotor_max"),
    )


def _sample_times(trajectory: PiecewisePolynomial, per_segment: int) -> Array:
    inner = trajectory.times[:-1, None] + trajectory.durations[:, None] * np.arange(per_segment) / per_segment
    return np.append(inner.ravel(), trajectory.times[-1])


def _segment(trajectory: PiecewisePolynomial, t: Array) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(trajectory.times, t, side="right") - 1, 0, len(trajectory.times) - 2)


def _near_critical_minima(sampled: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """(row, sample) of the least margin of each row and of all local minima close to zero."""
    padded = np.pad(sampled, ((0, 0), (1, 1)), constant_values=np.inf)
    local = (sampled <= padded[:, :-2]) & (sampled < padded[:, 2:]) & (sampled < _REFINE_BELOW)
    local[np.arange(len(sampled)), sampled.argmin(axis=1)] = True
    row, k = np.nonzero(local)
    return row, k


def _extremes(
    trajectory: PiecewisePolynomial, named: list[Row], row: NDArray[np.intp], t: Array, relative: Array, fastest: Array
) -> tuple[Extreme, ...]:
    extremes = []
    for i, what in enumerate(named):
        mine = np.flatnonzero(row == i)
        at = mine[relative[mine].argmin()]
        segment = int(_segment(trajectory, t[at : at + 1])[0])
        allowed = float(fastest[segment]) if np.isnan(what.allowed) else what.allowed
        margin = float(relative[at]) * what.scale
        quantity = allowed + margin if what.limit in _LOWER else allowed - margin
        extremes.append(Extreme(what.limit, what.rotor, segment, float(t[at]), quantity, allowed, float(relative[at])))
    return tuple(extremes)
