"""The ladder: the kernel on one stretch from rest to rest, from coarse to fine, repaired between the samples, proven.

Why: how many pieces a leg gets, how exact each level is and what happens where a proof fails are choices of their own,
made by measurement; near_optimal.py knows only that it is given a proven flight or none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from halfroll import _planner as kernel
from halfroll.planner.limits import Limits

Mode = Literal["fast", "best"]

SPARE = 1e-5  # relative margin left for the proof
_SPARES = 4  # times as much is asked where the proof fails, so many times
_LONG = 100  # pieces, beyond which what fails is mended in windows:
_WINDOWS, _MENDED = (6, 12, 24), 0.5  # so many pieces on either side, and at most this share of all
_HOPELESS = 0.1  # relative excess of a limit from which nothing is repaired where speeds or times are given
_DURATION_MIN = {True: 0.002, False: 0.012}  # [s] of a piece, tied or not: free knots would otherwise make slivers
# Where the barrier starts (what it costs, as a share of the time), and below which relative margin the limits start
# shifted:
_COLD, _REFINED, _FINER, _REPAIR, OTHER_LIMITS = (1.0, 0.02), (0.2, 0.01), (0.1, 0.01), (0.02, 0.003), (0.03, 0.003)
_STRETCHES = (1.00005, 1.0001, 1.0002, 1.0004, 1.001, 1.003, 1.008)
_SLOWINGS = (1.01, 1.03, 1.1, 1.3, 1.7, 2.5)  # of the start


@dataclass(frozen=True)
class Rung:
    """One level of refinement: pieces a leg, samples a piece, what the barrier may cost in the end (share of the time),
    at most so many steps."""

    pieces: int
    samples: int
    gap: float
    steps: int
    negligible: float = 3e-5  # a step that promises less, as a share of the time, ends a stage


@dataclass(frozen=True)
class Recipe:
    ladder: tuple[Rung, ...]  # what `fast` climbs
    tied: bool  # the pieces of a leg keep their shares of its time
    finer: Rung | None = None  # where `best` goes on from there
    two_starts: bool = False  # variable pitch also from its own start, not only from the fixed-pitch flight
    gap_factor: float = 0.15  # from stage to stage
    curvature: float = 0.4  # share of the constraints': 0 takes more but cheaper steps, 1 is often indefinite
    elastic: bool = True  # limits yield to long steps; of very many, some always would
    # Variable pitch is left out where the multipliers of the first flight promise too little. On few legs they may be
    # those of a flight that is not the shortest nearby, and a second search finds per cents that no price has promised.
    trusts_price: bool = False

    @property
    def rungs(self) -> tuple[Rung, ...]:
        return self.ladder if self.finer is None else (*self.ladder, self.finer)


def recipe_for(mode: Mode, legs: int, limits: Limits) -> Recipe:
    """Short courses get many knots, on one or two legs with free times; long ones few. The first level need not be
    exact: where it stops, the next begins. For thrusts alone on one or two legs walls are quicker; where motor speeds
    are limited, they end in flights that are easier to follow."""
    coarse = Rung(1, 16, 0.3, 60, 3e-4)
    best = mode == "best"
    walls = limits.drive is not None and limits.drive.of_speed
    if legs <= 2:
        ladder = (replace(coarse, samples=20), Rung(4, 20, 2e-3, 120, 1e-4))
        rates = limits.drive is not None or limits.rotor_rate_max is not None
        return Recipe(ladder, False, Rung(8, 24, 1e-3, 150) if best else None, elastic=rates and not walls)
    if legs <= 8:
        ladder = (replace(coarse, samples=12), Rung(3, 12, 3e-3, 120, 1e-4))
        return Recipe(ladder, True, Rung(9, 24, 1e-3, 150) if best else None, two_starts=best, elastic=not walls)
    if legs <= 100:
        ladder = (coarse, Rung(2, 16, 5e-3, 120, 1e-4))
        finest = Rung(4, 16, 2e-3, 150) if best else None
        return Recipe(ladder, True, finest, elastic=not walls, trusts_price=not best)
    return Recipe((Rung(1, 24, 1e-2, 80, 1e-3),), True, elastic=False, trusts_price=not best)


@dataclass
class Search:
    """The kernel on one stretch from rest to rest."""

    recipe: Recipe
    moving: bool  # a velocity or higher derivative other than zero is given somewhere
    progress: Callable[[float], None]
    interrupted: bool = False
    push_price: float = 0.0  # [s/N] of the last flight: what less of the least rotor thrust would save, to first order

    def minimise(
        self,
        problem: kernel.Problem,
        constraints: kernel.Constraints,
        rung: Rung,
        start: tuple[float, float],
        spare: float = 0.0,
    ) -> kernel.Problem:
        """The solver, once; the problem itself if it is stopped before it has found anything inside the limits."""
        gap, shift = start
        better, feasible, interrupted, self.push_price = kernel.minimise_time(
            problem,
            constraints,
            samples=rung.samples,
            gap_start=gap,
            gap_end=rung.gap,
            gap_factor=self.recipe.gap_factor,
            negligible=rung.negligible,
            iterations=rung.steps,
            duration_min=_DURATION_MIN[problem.tied],
            shift=shift,
            curvature=self.recipe.curvature,
            elastic=self.recipe.elastic,
            spare=spare,
            progress=self._told,
        )
        self.interrupted |= interrupted
        return problem if interrupted and not feasible else better

    def _told(self, total: float) -> bool:
        try:
            self.progress(total)
        except KeyboardInterrupt:
            return False
        return True

    def planned(self, start: kernel.Problem, constraints: kernel.Constraints) -> kernel.Problem | None:
        """The recipe; where forces turn too quickly for its samples, again with three times as many; else, and
        where it is stopped, the shortest of what the levels have found, repaired, and the start."""
        finer = tuple(replace(rung, samples=3 * rung.samples) for rung in self.recipe.ladder[:2])
        flights, coarse = [start], []
        for ladder, tied in ((self.recipe.ladder, self.recipe.tied), (finer, True)):
            start.tied = tied
            climbed = list(self.climb(start, constraints, ladder))
            better = self.repaired(climbed[-1], constraints, ladder[len(climbed) - 1]) if climbed else None
            if better is not None and not self.interrupted:
                return better
            flights += climbed if better is None else (*climbed, better)
            coarse += list(zip(climbed[:-1], ladder, strict=False))
            if self.interrupted:
                break
        self.push_price = math.inf  # of a flight that may be another
        mended = (self.repaired(flight, constraints, rung) for flight, rung in reversed(coarse))
        flights += [flight for flight in mended if flight is not None]
        proven = [flight for flight in flights if self.proven(flight, constraints)]
        if not proven and not self.moving:
            return self._slowed(start, constraints, 4 * self.recipe.ladder[0].samples, _SLOWINGS)
        return min(proven, key=lambda flight: flight.total, default=None)

    def climb(
        self, problem: kernel.Problem, constraints: kernel.Constraints, ladder: Sequence[Rung]
    ) -> Iterator[kernel.Problem]:
        """From coarse to fine: splitting a piece does not change the path, so each level starts where one ended. The
        last looks between its samples too."""
        pieces = 1
        for k, rung in enumerate(ladder):
            if self.interrupted:
                break
            problem = problem.split(rung.pieces // pieces)
            pieces = rung.pieces
            spare = SPARE if rung is ladder[-1] else 0.0
            problem = self.minimise(problem, constraints, rung, _COLD if k == 0 else _REFINED, spare)
            yield problem

    def refined(self, flight: kernel.Problem, constraints: kernel.Constraints) -> kernel.Problem:
        """The flight with more knots, if that makes it shorter."""
        rung = self.recipe.finer
        if rung is None or self.interrupted:
            return flight
        parts = rung.pieces * len(set(flight.leg)) // len(flight.durations)
        problem = self.minimise(flight.split(max(parts, 1)), constraints, rung, _FINER, SPARE)
        return shorter(flight, self.repaired(problem, constraints, rung)) or flight

    def proven(self, problem: kernel.Problem, constraints: kernel.Constraints) -> bool:
        return not self._unproven(problem, constraints)

    def _unproven(self, problem: kernel.Problem, constraints: kernel.Constraints) -> list[int]:
        return kernel.certify(problem.coefficients, problem.durations, problem.limits, constraints).unproven

    def mended(self, problem: kernel.Problem, constraints: kernel.Constraints, rung: Rung) -> kernel.Problem:
        """With what could not be proven flown anew, where that is little of a long flight: in windows of pieces between
        nodes that stay as they are, wider each time."""
        price = self.push_price  # of the whole, not of a window
        for width in _WINDOWS if len(problem.durations) > _LONG else ():
            unproven = self._unproven(problem, constraints)
            if not unproven or 2 * width * len(unproven) > _MENDED * len(problem.durations) or self.interrupted:
                break
            for first, last in _windows(unproven, width, len(problem.durations)):
                part = self.minimise(problem.part(first, last), constraints, rung, _REPAIR, 0.5 * SPARE)
                problem = problem.with_part(first, part)
        self.push_price = price
        return problem

    def repaired(self, problem: kernel.Problem, constraints: kernel.Constraints, rung: Rung) -> kernel.Problem | None:
        """The problem with a trajectory that is proven to stay inside the limits, or None.

        Where the proof fails the solver goes on with more to spare; what is left then is stretched away.
        """
        spare = SPARE
        problem = self.mended(problem, constraints, rung)
        for _ in range(_SPARES):
            if self.proven(problem, constraints):
                return problem
            hopeless = self.moving and problem.least_margin(constraints, rung.samples) < -_HOPELESS
            if self.interrupted or hopeless:
                break
            spare *= 4.0
            problem = self.minimise(problem, constraints, rung, _REPAIR, spare)
        return None if self.moving else self._slowed(problem, constraints, rung.samples, _STRETCHES)

    def _slowed(
        self, problem: kernel.Problem, constraints: kernel.Constraints, samples: int, factors: Sequence[float]
    ) -> kernel.Problem | None:
        """The least of these slowings-down by which the proof succeeds. Where a speed is given it would change."""
        for factor in factors:
            slower = problem.stretched(factor)
            if slower.least_margin(constraints, 8 * samples) >= 0.5 * SPARE and self.proven(slower, constraints):
                return slower
        return None


def shorter(one: kernel.Problem | None, other: kernel.Problem | None) -> kernel.Problem | None:
    if one is None or other is None:
        return one or other
    return one if one.total <= other.total else other


def _windows(pieces: Sequence[int], width: int, count: int) -> list[tuple[int, int]]:
    """(first, last + 1) around each of these pieces, rising, of `count`; those that overlap are one."""
    windows: list[tuple[int, int]] = []
    for piece in pieces:
        first, last = max(0, piece - width), min(count, piece + width + 1)
        if windows and first <= windows[-1][1]:
            first = windows.pop()[0]
        windows.append((first, last))
    return windows
