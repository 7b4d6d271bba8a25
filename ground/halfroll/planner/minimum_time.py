"""Shortest durations of the pieces between two rests, under the limits (Eqs 25-27).

Why: this is the search; plan.py says what is searched. The unknowns are the durations of the legs (in their logarithm),
and along which of its lines a node is passed (a thrust that an attitude leaves open, a speed in a given direction);
waypoints and continuity hold by construction, because every trial solves for the whole path, which is linear in the
latter. A trial is one array: durations (M,), then values on the lines (P,).

Each step linearises all margins at fixed samples of each leg, by one batch of perturbed copies of the path, and solves
a linear program for the change of durations within a trust region; a common slack lets it start outside the limits.
At the optimum most courses have as many active limits as legs, where such steps converge like Newton's; where there are
fewer they zigzag, so a short stretch is polished by SLSQP, which learns the curvature. Peaks between the samples are
then found densely, the limits of those legs tightened by the excess, and the search goes on; a last uniform stretch of
well under a percent makes the dense check hold.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog, minimize
from scipy.sparse import csr_array, hstack

from halfroll.errors import InfeasibleSegment, PlanError
from halfroll.planner.flatness import planar_outputs, upright_outputs
from halfroll.planner.limits import Limits, Margins, margins, relative_margins, rows
from halfroll.planner.segments import ORDER, PiecewisePolynomial, monomials, solve, solve_many
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]
Progress = Callable[[float, int], None]  # total time of the best so far, iteration

_SAMPLES, _FINE_SAMPLES = 32, 96  # of each leg while searching, and while repairing
_DERIVATIVES = 5
_INSIDE = 1e-3  # of a leg
_STEP = 1e-5  # of log duration, for differences
_WINDOW = 25  # legs
_CRITICAL, _ALL_BELOW = 0.15, 0.02  # margins in the linear program; of many samples only minima between the two
_TRUST_START, _TRUST_MAX, _TRUST_MIN = 0.1, 0.4, 2e-4
_ITERATIONS = 60
_REPAIRS = 5
_SPARE = 1e-6  # relative margin left for the proof
_GAIN_MIN = 1e-6  # of the total time
_POLISHED_LEGS = 8
_POLISH_WITHIN = 0.1  # of log duration
_POWERS = (0.5, 0.75, 1.0)  # of a leg's distance, for the duration to begin with
_MANY_POWERS, _SHARES, _PROMISING = (0.15, 0.3, 0.5, 0.75, 1.0), (0.4, 0.7, 1.0, 1.6), 3
_SKEWS = (0.75, 1.02, 1.35)  # of the last leg; never 1: position and acceleration half way would be singular
_NO_PATH = -1e12  # margin, below any of a path
_BEFORE = -1.0  # [s], long before the start
_PENALTY = 30.0  # relative time a unit of relative violation costs


def _table(samples: int) -> Array:
    """The ends a little inside: where the thrust changes its sign the outputs have a limit on each side, no value."""
    tau = np.clip(np.arange(samples + 1) / samples, _INSIDE, 1.0 - _INSIDE)
    return np.stack([monomials(tau, d) for d in range(_DERIVATIVES)])


_TABLES = {samples: _table(samples) for samples in (_SAMPLES, _FINE_SAMPLES)}


class NoDurations(InfeasibleSegment):
    """`segment` counts from the first leg of the stretch."""

    def __init__(self, segment: int, message: str) -> None:
        super().__init__(message)
        self.segment = segment


@dataclass(frozen=True)
class Line:
    """What is given at a node may move along a line: by its value times `along` (5, 4), zero where nothing is given."""

    node: int
    along: Array
    start: float  # the value to begin with; of order 1


@dataclass(frozen=True)
class Stretch:
    """From rest to rest through inner nodes.

    thrust_sign: of each leg where it turns over. It then stays in the x-z plane of its own axes, and thrust
    changes its sign exactly at nodes of free fall.
    """

    nodes: Array  # (M+1, 5, 4), as for segments.solve
    speed_max: Array  # (M,) [m/s], inf where there is none
    places: Array  # (M+1, 3) positions, where they are free a first guess
    lines: tuple[Line, ...] = ()
    thrust_sign: Array | None = None  # (M,)

    @property
    def legs(self) -> int:
        return len(self.nodes) - 1

    @property
    def start_values(self) -> Array:
        return np.array([line.start for line in self.lines])

    def nodes_at(self, values: Array) -> Array:
        """With what these values on the lines give."""
        nodes = self.nodes.copy()
        for line, value in zip(self.lines, values, strict=True):
            nodes[line.node] += value * line.along
        return nodes

    def response(self, k: int, durations: Array) -> Array:
        """(M, 10, 4): coefficients by the value on line k."""
        nodes = np.where(np.isnan(self.nodes), np.nan, 0.0)
        nodes[self.lines[k].node] += self.lines[k].along
        return np.asarray(solve_many(nodes, durations[None])[0])

    def flips(self, durations: Array) -> tuple[float, ...]:
        """When the thrust changes sign; before the start if it is negative there."""
        if self.thrust_sign is None:
            return ()
        changes = np.flatnonzero(np.diff(self.thrust_sign)) + 1
        before = (_BEFORE,) if self.thrust_sign[0] < 0.0 else ()
        return (*before, *np.concatenate([[0.0], np.cumsum(durations)])[changes].tolist())

    @property
    def purely_vertical(self) -> bool:
        horizontal = self.nodes[:, :, :2]
        here = np.nan_to_num(horizontal[:, 0] - horizontal[0, 0], nan=1.0)
        return bool(np.all(here == 0.0) and np.all(np.nan_to_num(horizontal[:, 1:]) == 0.0))

    def trajectory(self, trial: Array) -> PiecewisePolynomial:
        return solve(self.nodes_at(trial[self.legs :]), trial[: self.legs])

    def slowed(self, trial: Array, factor: float) -> Array:
        return np.concatenate([factor * trial[: self.legs], trial[self.legs :]])

    def total(self, trial: Array) -> float:
        return float(trial[: self.legs].sum())


def _merit(u: Array, here: Array, unit: float) -> float:
    return float(np.exp(u).sum() / unit - _PENALTY * min(0.0, here.min()))


@dataclass(frozen=True)
class _Model:
    """The linear program around one set of durations."""

    cost: Array  # (M+P,) slope of the total time over log durations and values on lines
    critical: NDArray[np.bool_]  # which of the sampled margins
    slope: Any  # sparse (n, M+P)

    def step(self, margin: Array, trust: float) -> tuple[Array, float]:
        """Change of the unknowns (M+P,) within the trust region; the gain in merit it promises, present
        violation left out."""
        A = hstack([-self.slope, csr_array(np.full((len(margin), 1), -1.0))])
        bounds = [(-trust, trust)] * len(self.cost) + [(0.0, None)]
        result = linprog(np.append(self.cost, _PENALTY), A_ub=A, b_ub=margin, bounds=bounds, method="highs")
        if result.status != 0:
            return np.zeros_like(self.cost), 0.0
        return np.asarray(result.x[:-1]), -float(result.fun)


@dataclass
class Search:
    """One stretch, one vehicle, one set of limits."""

    stretch: Stretch
    vehicle: Vehicle
    limits: Limits
    progress: Progress | None = None
    samples: int = _SAMPLES  # of each leg
    iteration: int = 0
    best: float = np.inf
    tightened: Array = field(init=False)  # (rows, legs), added to the limits where peaks hide between samples

    def __post_init__(self) -> None:
        self.tightened = np.zeros((len(rows(self.vehicle, self.limits)), self.stretch.legs))

    def sampled(self, trial: Array) -> Array:
        """(rows, M, samples): relative margins."""
        durations = trial[: self.stretch.legs]
        return np.asarray(self._of_many(durations[None], trial[self.stretch.legs :])[0])

    def _of_many(self, durations: Array, values: Array) -> Array:
        """(B, rows, M, samples) for B sets of durations (B, M)."""
        try:
            coefficients = solve_many(self.stretch.nodes_at(values), durations)  # (B, M, 10, 4)
        except PlanError:  # pieces too unequal to be solved for
            return np.full((len(durations), *self.tightened.shape, self.samples + 1), _NO_PATH)
        return self._of_coefficients(coefficients, durations)

    def _of_coefficients(self, coefficients: Array, durations: Array) -> Array:
        flat = coefficients.reshape(-1, ORDER, 4)
        tau_derivatives = _TABLES[self.samples][:, None] @ flat[None]  # (5, B M, samples, 4)
        scale = durations.reshape(-1) ** -np.arange(_DERIVATIVES)[:, None]
        d = np.moveaxis(tau_derivatives * scale[:, :, None, None], -1, 1)
        d = np.ascontiguousarray(d).reshape(_DERIVATIVES, 4, *durations.shape, -1)
        vertical, sign = self.stretch.purely_vertical, self.stretch.thrust_sign
        if sign is None:
            rotors, force, rate = upright_outputs(d, self.vehicle, vertical)
        else:
            rotors, force, rate = planar_outputs(d, self.vehicle, sign[:, None])
        found = relative_margins(
            self.vehicle,
            self.limits,
            rotors=rotors,
            force=force,
            rate=rate,
            velocity=d[1, :3],
            height=d[0, 2],
            speed_max=self.speed_max[:, None],
            exempt=vertical and self.vehicle.variable_pitch,
        )
        return np.moveaxis(found, 0, 1) - self.tightened[:, :, None]

    @property
    def speed_max(self) -> Array:
        return np.minimum(self.stretch.speed_max, np.inf if self.limits.speed_max is None else self.limits.speed_max)

    def check(self, trial: Array) -> Margins:
        """The dense, refined check."""
        trajectory, flips = self.stretch.trajectory(trial), self.stretch.flips(trial[: self.stretch.legs])
        turns = () if self.stretch.thrust_sign is None else None
        return margins(
            trajectory, self.vehicle, self.limits, segment_speed_max=self.speed_max, flips=flips, turns=turns
        )

    def holds(self, trial: Array) -> bool:
        """Whether the dense check accepts it, with a little to spare for rounding."""
        return self.check(trial).worst.relative >= _SPARE

    def least(self, trial: Array) -> float:
        """Smallest sampled margin."""
        return float(self.sampled(trial).min())

    def descend(self, trial: Array, trust: float = _TRUST_START, iterations: int = _ITERATIONS) -> Array:
        """Local search; the result may be a little outside the limits, or far outside where it is stuck."""
        legs = self.stretch.legs
        z, unit = self._logged(trial), trial[:legs].sum()
        here = self.sampled(trial)
        model: _Model | None = None
        for _ in range(iterations):
            if model is None:
                critical = self._critical(here, trust)
                cost = np.concatenate([np.exp(z[:legs]) / unit, np.zeros(len(z) - legs)])
                model = _Model(cost, critical, self._slope(z, here, critical))
            change, promised = model.step(here[model.critical], trust)
            now = _merit(z[:legs], here, unit)
            gain = promised - _PENALTY * min(0.0, float(here.min()))
            there = self.sampled(self._trial(z + change))
            if now - _merit((z + change)[:legs], there, unit) < 0.5 * gain:  # follow the curved limits (second order)
                corrected, _ = model.step(there[model.critical] - model.slope @ change, trust)
                second = self.sampled(self._trial(z + corrected))
                if _merit((z + corrected)[:legs], second, unit) < _merit((z + change)[:legs], there, unit):
                    change, there = corrected, second
            self._report(float(np.exp(z[:legs]).sum()))
            got = now - _merit((z + change)[:legs], there, unit)
            if got > 0.1 * gain:
                z, here, model = z + change, there, None
                if got > 0.6 * gain:
                    trust = min(2.0 * trust, _TRUST_MAX)
            else:
                trust = min(trust, float(np.abs(change).max())) / 3.0
            if gain < _GAIN_MIN or trust < _TRUST_MIN:
                break
        return self._trial(z)

    def polish(self, trial: Array) -> Array:
        """The optimum nearby, where there are few unknowns; its sampled margins are no worse than given."""
        legs = self.stretch.legs
        start = self._logged(trial)
        here = self.sampled(trial)
        near = here < 2.0 * _POLISH_WITHIN

        def total(z: Array) -> float:
            return float(np.exp(z[:legs]).sum())

        def slope_of_total(z: Array) -> Array:
            return np.concatenate([np.exp(z[:legs]), np.zeros(len(z) - legs)])

        found = minimize(
            total,
            start,
            jac=slope_of_total,
            method="SLSQP",
            bounds=[(one - _POLISH_WITHIN, one + _POLISH_WITHIN) for one in start],
            constraints={
                "type": "ineq",
                "fun": lambda z: self.sampled(self._trial(z))[near],
                "jac": lambda z: self._slope(z, self.sampled(self._trial(z)), near).toarray(),
            },
            options={"maxiter": _ITERATIONS, "ftol": 1e-10},
        )
        polished = self._trial(found.x)
        if found.success and self.least(polished) >= min(-_SPARE, float(here.min())):
            return polished
        return trial

    def _logged(self, trial: Array) -> Array:
        legs = self.stretch.legs
        return np.concatenate([np.log(trial[:legs]), trial[legs:]])

    def _trial(self, z: Array) -> Array:
        legs = self.stretch.legs
        return np.concatenate([np.exp(z[:legs]), z[legs:]])

    def _critical(self, here: Array, trust: float) -> NDArray[np.bool_]:
        """Which margins the linear program sees."""
        critical = here < max(_CRITICAL, 4.0 * trust)
        if (
            here.shape[1] > _WINDOW or self.samples == _FINE_SAMPLES
        ):  # only local minima, and what is about to be reached
            near = np.pad(here, ((0, 0), (0, 0), (1, 1)), mode="edge")
            critical &= (here < _ALL_BELOW) | ((here <= near[..., :-2]) & (here <= near[..., 2:]))
        return critical

    def _slope(self, z: Array, here: Array, critical: NDArray[np.bool_]) -> Any:
        """Sparse (critical margins, unknowns): their slopes over log durations and values on lines.

        A leg's duration matters less by 0.6 with each leg, so legs _WINDOW apart are perturbed in one copy of the path.
        """
        legs = self.stretch.legs
        u, values = z[:legs], z[legs:]
        copies = min(legs, _WINDOW)
        colour = np.arange(legs) % copies
        perturbed = np.exp(u + _STEP * (colour == np.arange(copies)[:, None]))
        slope = ((self._of_many(perturbed, values) - here) / _STEP)[:, critical].T  # (n, copies)
        of_leg = np.nonzero(critical)[1]
        by = np.arange(copies)
        shift = np.rint((of_leg[:, None] - by) / copies) if legs > copies else np.zeros((len(of_leg), copies))
        leg = by + copies * shift.astype(int)  # the nearest of that colour
        inside = (leg >= 0) & (leg < legs)
        row = np.broadcast_to(np.arange(len(of_leg))[:, None], leg.shape)
        over_times = csr_array((slope[inside], (row[inside], leg[inside])), shape=(len(of_leg), legs))
        if len(values) == 0:
            return over_times
        durations = np.exp(u)
        path = solve_many(self.stretch.nodes_at(values), durations[None])[0]
        moved = np.stack([path + _STEP * self.stretch.response(k, durations) for k in range(len(values))])
        repeated = np.broadcast_to(durations, (len(values), legs))
        over_values = (self._of_coefficients(moved, repeated) - here) / _STEP
        return hstack([over_times, csr_array(over_values[:, critical].T)], format="csr")

    def _report(self, total: float) -> None:
        self.iteration += 1
        if self.progress is not None:
            self.progress(total, self.iteration)

    def feasible_scale(self, trial: Array) -> Array:
        """All durations times one factor, the smallest found for which the sampled margins are >= 0; if none is, the
        factor with the least violation."""
        factors = 2.0 ** np.arange(-3.0, 7.0, 0.25)
        least = np.array([self.least(self.stretch.slowed(trial, f)) for f in factors])
        fits = np.flatnonzero(least >= 0.0)
        if len(fits) == 0:
            return self.stretch.slowed(trial, float(factors[least.argmax()]))
        high = float(factors[fits[0]])
        low = float(factors[fits[0] - 1]) if fits[0] > 0 else high / 2.0
        for _ in range(8):
            middle = np.sqrt(low * high)
            low, high = (low, middle) if self.least(self.stretch.slowed(trial, middle)) >= 0.0 else (middle, high)
        return self.stretch.slowed(trial, high)

    def tighten(self, trial: Array, found: Margins) -> None:
        """Ask more where the dense check found peaks that the samples missed. Where a slower flight is no easier one,
        only of what fails: nothing else mends it, and what is asked too much leads away."""
        missed = self.sampled(trial).min(axis=-1) + self.tightened - found.by_segment
        near = found.by_segment < (0.01 if self.stretch.thrust_sign is None else _SPARE)
        self.tightened = np.where(near, np.maximum(self.tightened, 1.05 * missed + 1e-6), self.tightened)

    def stretch_until_checked(self, trial: Array, most: float) -> Array | None:
        """The smallest uniform stretch or shrink (down to 0.5 %) that the dense check accepts; None above `most`."""
        high, step = 1.0, 1e-4
        while not self.holds(self.stretch.slowed(trial, high)):
            high, step = high * (1.0 + step), 2.0 * step
            if high > most:
                return None
        low = 0.995 if high == 1.0 else high / (1.0 + step / 2.0)
        for _ in range(14):
            middle = (low + high) / 2.0
            low, high = (low, middle) if self.holds(self.stretch.slowed(trial, middle)) else (middle, high)
        return self.stretch.slowed(trial, high)


def shortest(
    stretch: Stretch, vehicle: Vehicle, limits: Limits, starts: Sequence[Array] = (), progress: Progress | None = None
) -> Array:
    """(M+P,) durations, and values on lines, for which the dense check holds, locally shortest; from `starts` and from
    three of its own.

    Raises NoDurations.
    """
    search = Search(stretch, vehicle, limits, progress)
    if stretch.legs == 1 and not starts:
        return _single(search)
    guesses = _promising(search) if stretch.lines or stretch.thrust_sign is not None else _guesses(stretch)
    if stretch.legs > (_WINDOW if not starts else 8):
        guesses = guesses[1:2]
    tried = [search.feasible_scale(start) for start in guesses] + list(starts)
    found = [search.descend(start) for start in tried]
    order = np.argsort([stretch.total(trial) + 1e3 * max(0.0, -search.least(trial) - 1e-4) for trial in found])
    best: Array | None = None
    for k in order[:2]:
        search.tightened[:] = 0.0
        search.samples = _FINE_SAMPLES
        repaired = _repaired(search, found[k])
        if repaired is not None and (best is None or stretch.total(repaired) < stretch.total(best)):
            best = repaired
        if best is not None:
            break
    for start in starts:  # feasible by themselves, perhaps: never do worse
        if (best is None or stretch.total(start) < stretch.total(best)) and search.holds(start):
            best = start
    if best is None:
        raise infeasible(search.check(found[order[0]]))
    return best


def _promising(search: Search) -> list[Array]:
    """Where values are open or the vehicle turns over, there are many optima: the best of many starts."""
    stretch = search.stretch
    lines = bool(stretch.lines)
    starts = [
        search.feasible_scale(np.concatenate([durations * skewed, share * stretch.start_values]))
        for durations in _guesses(stretch, _MANY_POWERS)
        for skewed in np.geomspace(1.0, _SKEWS if lines else _SKEWS[1:2], stretch.legs).T
        for share in (_SHARES if lines else (1.0,))
    ]
    rank = [1e3 * max(0.0, -search.least(start)) + stretch.total(start) for start in starts]
    return [starts[k] for k in np.argsort(rank)[:_PROMISING]]


def _guesses(stretch: Stretch, powers: Sequence[float] = _POWERS) -> list[Array]:
    """Durations by distance: of constant acceleration, of constant speed, and between."""
    distance = np.maximum(np.linalg.norm(np.diff(stretch.places, axis=0), axis=1), 1e-3)
    turn = np.abs(np.nan_to_num(np.diff(stretch.nodes[:, 0, 3])))
    ends = np.ones(stretch.legs)
    ends[0] += 0.4
    ends[-1] += 0.4
    typical = float(np.median(distance))
    return [
        np.maximum(2.0 * ends * (distance / typical) ** power * np.sqrt(typical / 5.0), 0.2 * np.sqrt(turn))
        for power in powers
    ]


def _single(search: Search) -> Array:
    """One leg: only its duration is free, found to 1e-9 (a vertical leg has it in closed form)."""
    start = search.feasible_scale(_guesses(search.stretch)[0])
    high = search.stretch_until_checked(start, 1.5)
    if high is None:
        raise infeasible(search.check(start))
    low = 0.99 * high
    if search.holds(low):
        return low
    for _ in range(30):
        middle = (low + high) / 2.0
        low, high = (low, middle) if search.holds(middle) else (middle, high)
    search._report(float(high[0]))
    return high


def _repaired(search: Search, trial: Array) -> Array | None:
    few = len(trial) <= _POLISHED_LEGS
    if few:
        trial = search.polish(trial)
    stretchable = search.stretch.thrust_sign is None
    for _ in range(_REPAIRS if stretchable else 3 * _REPAIRS):
        found = search.check(trial)
        if found.worst.relative > (-2e-5 if stretchable else _SPARE):
            break
        search.tighten(trial, found)
        trial = search.descend(trial, trust=0.01, iterations=20)
        if few:
            trial = search.polish(trial)
    for most in (1.01, 1.1, 8.0):
        stretched = search.stretch_until_checked(trial, most)
        if stretched is not None:
            return stretched
    return None


def infeasible(found: Margins) -> NoDurations:
    worst = found.worst
    unit = {"speed": "m/s", "floor": "m", "body_rate": "rad/s"}.get(worst.limit, "N")
    what = f"rotor {worst.rotor}" if worst.rotor is not None else worst.limit.replace("_", " ")
    return NoDurations(
        worst.segment,
        f"{what} would need {worst.quantity:.2f} {unit} where {worst.allowed:.2f} {unit} is "
        "allowed, at every duration tried; move the waypoint or relax the limit",
    )
