"""What the ladder flies where its levels end outside the limits."""

from dataclasses import replace

import pytest

from halfroll import _planner as kernel
from halfroll.missions.mission import Waypoint, Yaw
from halfroll.planner.course_nodes import checked_nodes
from halfroll.planner.kernel_problem import Setup
from halfroll.planner.ladder import Rung, Search, recipe_for
from halfroll.planner.limits import Limits
from halfroll.planner.warm_start import warm_start
from halfroll.vehicle import load_vehicle

VEHICLE = load_vehicle("mit-vp")
LIMITS = Limits.of(VEHICLE)
SQUARE = [Waypoint(position=place) for place in ((0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 0, 1))]
ENOUGH, TOO_FEW = 16, 12  # samples a piece, for the first level to be proven as it is


class Rushing(Search):
    """Its solver ends in less than half the time that is possible, from the level of so many pieces on."""

    rushes_from = 1
    samples = 0  # of the level that is searched now

    def minimise(
        self,
        problem: kernel.Problem,
        constraints: kernel.Constraints,
        rung: Rung,
        start: tuple[float, float],
        spare: float = 0.0,
    ) -> kernel.Problem:
        self.samples = rung.samples
        found = super().minimise(problem, constraints, rung, start, spare)
        return found if rung.pieces < self.rushes_from else found.stretched(0.4)


@pytest.fixture
def start() -> tuple[kernel.Problem, kernel.Constraints]:
    setup = Setup.of(checked_nodes(SQUARE, VEHICLE, LIMITS), VEHICLE, LIMITS, Yaw(), [])
    constraints = setup.constraints(LIMITS)
    return warm_start(setup, constraints), constraints


def searched(moving: bool, rushes_from: int, samples: int = ENOUGH) -> Rushing:
    ladder = (Rung(1, samples, 0.3, 60, 3e-4), Rung(3, samples, 3e-3, 120, 1e-4))
    recipe = replace(recipe_for("fast", len(SQUARE) - 1, LIMITS), ladder=ladder)
    search = Rushing(recipe, moving, lambda _: None)
    search.rushes_from = rushes_from
    return search


def test_where_the_last_level_cannot_be_proven_the_level_before_is_flown(start):
    problem, constraints = start
    search = searched(moving=True, rushes_from=2)
    flown = search.planned(problem, constraints)
    assert search.proven(flown, constraints)
    assert flown.total < problem.total


def test_where_no_level_can_be_proven_a_start_that_is_proven_is_flown(start):
    problem, constraints = start
    search = searched(moving=True, rushes_from=1)
    slow = problem.stretched(2.0)
    assert search.proven(slow, constraints)
    assert search.planned(slow, constraints).total == slow.total


def test_where_nothing_can_be_proven_and_a_velocity_is_given_there_is_no_flight(start):
    problem, constraints = start
    assert searched(moving=True, rushes_from=1).planned(problem.stretched(0.4), constraints) is None


def test_from_rest_to_rest_what_is_too_quick_is_slowed_until_it_is_proven(start):
    problem, constraints = start
    search = searched(moving=False, rushes_from=1)
    flown = search.planned(problem.stretched(0.8), constraints)
    assert search.proven(flown, constraints)
    assert flown.total > 0.8 * problem.total


@pytest.mark.parametrize(("moving", "samples"), [(True, ENOUGH), (False, ENOUGH), (False, TOO_FEW)])
def test_ctrl_c_while_all_is_searched_again_ends_with_the_best_that_was_proven(start, moving, samples):
    """From rest to rest, also with what is proven only once it is slowed down a little."""
    problem, constraints = start
    search = searched(moving, 2, samples)

    def interrupts(_: float) -> None:
        if search.samples == 3 * samples:
            raise KeyboardInterrupt

    uninterrupted = searched(True, 2).planned(start[0], constraints)
    search.progress = interrupts
    flown = search.planned(problem, constraints)
    assert search.interrupted
    assert search.proven(flown, constraints)
    assert flown.total < 1.05 * uninterrupted.total < 0.9 * problem.total
