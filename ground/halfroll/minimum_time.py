"""Shortest durations of the pieces between two rests, under the limits (Eqs 25-27).

Why: this is the search; plan.py says what is searched. The only unknowns are the durations of the legs (in their
logarithm); waypoints and continuity hold by construction, because every trial solves for the whole path.

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
from halfroll.flatness import upright_outputs
from halfroll.limits import Limits, Margins, margins, relative_margins, rows
from halfroll.segments import ORDER, PiecewisePolynomial, monomials, solve, solve_many
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]
Progress = Callable[[float, int], None]  # total time of the best so far, iteration

_SAMPLES, _FINE_SAMPLES = 32, 96  # of each leg while searching, and while repairing
_DERIVATIVES = 5
_STEP = 1e-5  # of log duration, for differences
_WINDOW = 25  # legs
_CRITICAL, _ALL_BELOW = 0.15, 0.02  # margins in the linear program; of many samples only minima between the two
_TRUST_START, _TRUST_MAX, _TRUST_MIN = 0.1, 0.4, 2e-4
_ITERATIONS = 60
_REPAIRS = 5
_SPARE = 1e-7
_GAIN_MIN = 1e-6  # of the total time
_POLISHED_LEGS = 8
_POLISH_WITHIN = 0.1  # of log duration
_PENALTY = 30.0  # relative time a unit of relative violation costs


def _table(samples: int) -> Array:
    return np.stack([monomials(np.arange(samples + 1) / samples, d) for d in range(_DERIVATIVES)])


_TABLES = {samples: _table(samples) for samples in (_SAMPLES, _FINE_SAMPLES)}


class NoDurations(InfeasibleSegment):
    """`segment` counts from the first leg of the stretch."""

    def __init__(self, segment: int, message: str) -> None:
        super().__init__(message)
        self.segment = segment


@dataclass(frozen=True)
class Stretch:
    """From rest to rest through inner nodes."""

    nodes: Array  # (M+1, 5, 4), as for segments.solve
    speed_max: Array  # (M,) [m/s], inf where there is none

    @property
    def legs(self) -> int:
        return len(self.nodes) - 1

    @property
    def purely_vertical(self) -> bool:
        horizontal = self.nodes[:, :, :2]
        here = np.nan_to_num(horizontal[:, 0] - horizontal[0, 0], nan=1.0)
        return bool(np.all(here == 0.0) and np.all(np.nan_to_num(horizontal[:, 1:]) == 0.0))

    def trajectory(self, durations: Array) -> PiecewisePolynomial:
        return solve(self.nodes, durations)


def _merit(u: Array, here: Array, unit: float) -> float:
    return float(np.exp(u).sum() / unit - _PENALTY * min(0.0, here.min()))


@dataclass(frozen=True)
class _Model:
    """The linear program around one set of durations."""

    cost: Array  # (M,) slope of the total time over u
    critical: NDArray[np.bool_]  # which of the sampled margins
    slope: Any  # sparse (n, M)

    def step(self, margin: Array, trust: float) -> tuple[Array, float]:
        """Change of u (M,) within the trust region; the gain in merit it promises, present violation left out."""
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

    def sampled(self, durations: Array) -> Array:
        """(B, rows, M, samples): relative margins of B sets of durations (B, M)."""
        legs = self.stretch
        try:
            coefficients = solve_many(legs.nodes, durations)  # (B, M, 10, 4)
        except PlanError:  # pieces too unequal to be solved for
            return np.full((len(durations), *self.tightened.shape, self.samples + 1), -1e3)
        flat = coefficients.reshape(-1, ORDER, 4)
        tau_derivatives = _TABLES[self.samples][:, None] @ flat[None]  # (5, B M, samples, 4)
        scale = durations.reshape(-1) ** -np.arange(_DERIVATIVES)[:, None]
        d = np.moveaxis(tau_derivatives * scale[:, :, None, None], -1, 1)
        d = np.ascontiguousarray(d).reshape(_DERIVATIVES, 4, *durations.shape, -1)
        vertical = legs.purely_vertical
        rotors, force, rate = upright_outputs(d, self.vehicle, vertical)
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

    def check(self, durations: Array) -> Margins:
        """The dense, refined check."""
        trajectory = self.stretch.trajectory(durations)
        return margins(trajectory, self.vehicle, self.limits, segment_speed_max=self.speed_max)

    def holds(self, durations: Array) -> bool:
        """Whether the dense check accepts them, with a little to spare for rounding."""
        return self.check(durations).worst.relative >= _SPARE

    def least(self, durations: Array) -> float:
        """Smallest sampled margin."""
        return float(self.sampled(durations[None]).min())

    def descend(self, durations: Array, trust: float = _TRUST_START, iterations: int = _ITERATIONS) -> Array:
        """Local search; the result may be a little outside the limits, or far outside where it is stuck."""
        u, unit = np.log(durations), durations.sum()
        here = self.sampled(durations[None])[0]
        model: _Model | None = None
        for _ in range(iterations):
            if model is None:
                critical = self._critical(here, trust)
                model = _Model(np.exp(u) / unit, critical, self._slope(u, here, critical))
            change, promised = model.step(here[model.critical], trust)
            now = _merit(u, here, unit)
            gain = promised - _PENALTY * min(0.0, float(here.min()))
            trial = self.sampled(np.exp(u + change)[None])[0]
            if now - _merit(u + change, trial, unit) < 0.5 * gain:  # follow the curved limits (second-order correction)
                corrected, _ = model.step(trial[model.critical] - model.slope @ change, trust)
                second = self.sampled(np.exp(u + corrected)[None])[0]
                if _merit(u + corrected, second, unit) < _merit(u + change, trial, unit):
                    change, trial = corrected, second
            self._report(float(np.exp(u).sum()))
            got = now - _merit(u + change, trial, unit)
            if got > 0.1 * gain:
                u, here, model = u + change, trial, None
                if got > 0.6 * gain:
                    trust = min(2.0 * trust, _TRUST_MAX)
            else:
                trust = min(trust, float(np.abs(change).max())) / 3.0
            if gain < _GAIN_MIN or trust < _TRUST_MIN:
                break
        return np.asarray(np.exp(u))

    def polish(self, durations: Array) -> Array:
        """The optimum nearby, where there are few legs; the sampled margins of the result are no worse than given."""
        start = np.log(durations)
        here = self.sampled(durations[None])[0].ravel()
        near = np.flatnonzero(here < 2.0 * _POLISH_WITHIN)
        steps = _STEP * np.concatenate([np.eye(len(start)), -np.eye(len(start))])

        def slope(u: Array) -> Array:
            up, down = np.split(self.sampled(np.exp(u + steps)).reshape(len(steps), -1)[:, near], 2)
            return np.asarray((up - down).T / (2.0 * _STEP))

        found = minimize(
            lambda u: np.exp(u).sum(),
            start,
            jac=np.exp,
            method="SLSQP",
            bounds=[(u - _POLISH_WITHIN, u + _POLISH_WITHIN) for u in start],
            constraints={"type": "ineq", "fun": lambda u: self.sampled(np.exp(u)[None]).ravel()[near], "jac": slope},
            options={"maxiter": _ITERATIONS, "ftol": 1e-10},
        )
        polished = np.exp(found.x)
        if found.success and self.least(polished) >= min(-_SPARE, float(here.min())):
            return np.asarray(polished)
        return durations

    def _critical(self, here: Array, trust: float) -> NDArray[np.bool_]:
        """Which margins the linear program sees."""
        critical = here < max(_CRITICAL, 4.0 * trust)
        if (
            here.shape[1] > _WINDOW or self.samples == _FINE_SAMPLES
        ):  # only local minima, and what is about to be reached
            near = np.pad(here, ((0, 0), (0, 0), (1, 1)), mode="edge")
            critical &= (here < _ALL_BELOW) | ((here <= near[..., :-2]) & (here <= near[..., 2:]))
        return critical

    def _slope(self, u: Array, here: Array, critical: NDArray[np.bool_]) -> Any:
        """Sparse (critical margins, legs): their slopes over u.

        A leg's duration matters less by 0.6 with each leg, so legs _WINDOW apart are perturbed in one copy of the path.
        """
        legs = len(u)
        copies = min(legs, _WINDOW)
        colour = np.arange(legs) % copies
        perturbed = np.exp(u + _STEP * (colour == np.arange(copies)[:, None]))
        slope = ((self.sampled(perturbed) - here) / _STEP)[:, critical].T  # (n, copies)
        of_leg = np.nonzero(critical)[1]
        by = np.arange(copies)
        leg = by + copies * np.rint((of_leg[:, None] - by) / copies).astype(int)  # the nearest of that colour
        inside = (leg >= 0) & (leg < legs)
        row = np.broadcast_to(np.arange(len(of_leg))[:, None], leg.shape)
        return csr_array((slope[inside], (row[inside], leg[inside])), shape=(len(of_leg), legs))

    def _report(self, total: float) -> None:
        self.iteration += 1
        if self.progress is not None:
            self.progress(total, self.iteration)

    def feasible_scale(self, durations: Array) -> Array:
        """All durations times one factor, the smallest found for which the sampled margins are >= 0; if none is, the
        factor with the least violation."""
        factors = 2.0 ** np.arange(-3.0, 7.0, 0.25)
        least = np.array([self.least(f * durations) for f in factors])
        fits = np.flatnonzero(least >= 0.0)
        if len(fits) == 0:
            return np.asarray(factors[least.argmax()] * durations)
        high = float(factors[fits[0]])
        low = float(factors[fits[0] - 1]) if fits[0] > 0 else high / 2.0
        for _ in range(8):
            middle = np.sqrt(low * high)
            low, high = (low, middle) if self.least(middle * durations) >= 0.0 else (middle, high)
        return high * durations

    def tighten(self, durations: Array, found: Margins) -> None:
        """Ask more where the dense check found peaks that the samples missed."""
        missed = self.sampled(durations[None])[0].min(axis=-1) + self.tightened - found.by_segment
        near = found.by_segment < 0.01
        self.tightened = np.where(near, np.maximum(self.tightened, 1.05 * missed + 1e-6), self.tightened)

    def stretch_until_checked(self, durations: Array, most: float) -> Array | None:
        """The smallest uniform stretch or shrink (down to 0.5 %) that the dense check accepts; None above `most`."""
        high, step = 1.0, 1e-4
        while not self.holds(high * durations):
            high, step = high * (1.0 + step), 2.0 * step
            if high > most:
                return None
        low = 0.995 if high == 1.0 else high / (1.0 + step / 2.0)
        for _ in range(14):
            middle = (low + high) / 2.0
            low, high = (low, middle) if self.holds(middle * durations) else (middle, high)
        return high * durations


def shortest(
    stretch: Stretch, vehicle: Vehicle, limits: Limits, starts: Sequence[Array] = (), progress: Progress | None = None
) -> Array:
    """(M,) durations for which the dense check holds, locally shortest; from `starts` and from three of its own.

    Raises NoDurations.
    """
    search = Search(stretch, vehicle, limits, progress)
    if stretch.legs == 1 and not starts:
        return _single(search)
    guesses = _guesses(stretch)
    if stretch.legs > (_WINDOW if not starts else 8):
        guesses = guesses[1:2]
    tried = [search.feasible_scale(start) for start in guesses] + list(starts)
    found = [search.descend(start) for start in tried]
    order = np.argsort([durations.sum() + 1e3 * max(0.0, -search.least(durations) - 1e-4) for durations in found])
    best: Array | None = None
    for k in order[:2]:
        search.tightened[:] = 0.0
        search.samples = _FINE_SAMPLES
        repaired = _repaired(search, found[k])
        if repaired is not None and (best is None or repaired.sum() < best.sum()):
            best = repaired
        if best is not None:
            break
    for start in starts:  # feasible by themselves, perhaps: never do worse
        if (best is None or start.sum() < best.sum()) and search.holds(start):
            best = start
    if best is None:
        raise infeasible(search.check(found[order[0]]))
    return best


def _guesses(stretch: Stretch) -> list[Array]:
    """Durations by distance: of constant acceleration, of constant speed, and between."""
    positions = stretch.nodes[:, 0, :3]
    known = np.where(np.isnan(positions), 0.0, positions)
    distance = np.maximum(np.linalg.norm(np.diff(known, axis=0), axis=1), 1e-3)
    turn = np.abs(np.nan_to_num(np.diff(stretch.nodes[:, 0, 3])))
    ends = np.ones(stretch.legs)
    ends[0] += 0.4
    ends[-1] += 0.4
    typical = float(np.median(distance))
    return [
        np.maximum(2.0 * ends * (distance / typical) ** power * np.sqrt(typical / 5.0), 0.2 * np.sqrt(turn))
        for power in (0.5, 0.75, 1.0)
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


def _repaired(search: Search, durations: Array) -> Array | None:
    few = len(durations) <= _POLISHED_LEGS
    if few:
        durations = search.polish(durations)
    for _ in range(_REPAIRS):
        found = search.check(durations)
        if found.worst.relative > -2e-5:
            break
        search.tighten(durations, found)
        durations = search.descend(durations, trust=0.01, iterations=20)
        if few:
            durations = search.polish(durations)
    for most in (1.01, 1.1, 8.0):
        stretched = search.stretch_until_checked(durations, most)
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
