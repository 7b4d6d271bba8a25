"""Near-optimal plans: close to the least time, inside the limits at every time and proven so, whatever the course."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from halfroll import _planner as kernel
from halfroll.errors import InfeasibleSegment
from halfroll.missions.mission import Waypoint, Yaw
from halfroll.planner.course_nodes import checked_nodes
from halfroll.planner.flatness import UPRIGHT, inverse_dynamics
from halfroll.planner.kernel_problem import Setup
from halfroll.planner.ladder import Search, recipe_for
from halfroll.planner.limits import Limits
from halfroll.planner.near_optimal import limits_of, plan_near_optimal
from halfroll.planner.plan import Plan, plan_course
from halfroll.planner.segments import solve_many
from halfroll.planner.warm_start import warm_start
from halfroll.vehicle import GRAVITY, load_vehicle

VP, FP = load_vehicle("mit-vp"), load_vehicle("mit-fp")
CLIMB = [(0, 0, 1), (0, 0, 2)]
LINE = [(0, 0, 1), (10, 0, 1)]
SQUARE = [(0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1), (0, 0, 1)]
ZIGZAG = [(0, 0, 1), (2, 1, 2), (4, -1, 1), (6, 1, 2.5), (8, -1, 1), (10, 0, 1.5)]
GATES = [(-1.1, -1.6, 3.6), (9.2, 6.6, 1), (9.2, -4, 1.2), (-4.5, -6, 3.5), (-4.5, -6, 0.8), (4.75, -0.9, 1.2),
         (-2.8, 6.8, 1.2)]  # fmt: skip
CIRCUIT = [(-5, 4.5, 1.2), *(GATES[k % 7] for k in range(19)), (4.75, -0.9, 1.2)]
CLOUD = np.random.default_rng(2021).uniform((-5, -5, 0.5), (5, 5, 3.5), (25, 3)).round(2).tolist()
COURSES = {"climb": CLIMB, "line": LINE, "square": SQUARE, "zigzag": ZIGZAG, "circuit": CIRCUIT, "cloud": CLOUD}
# Least times known of the full optimal-control problem, rotor limits alone, by multiple shooting.
LEAST = {
    "climb": {"mit-fp": 0.6379, "mit-vp": 0.4934},
    "line": {"mit-fp": 1.6493, "mit-vp": 1.6197},
    "square": {"mit-fp": 3.0538, "mit-vp": 3.0246},
    "zigzag": {"mit-fp": 3.5941, "mit-vp": 3.5392},
    "circuit": {"mit-fp": 23.6057, "mit-vp": 23.5772},
    "cloud": {"mit-fp": 22.2516, "mit-vp": 22.2065},
}
# How close to these a plan must come.
BEST = {
    "climb": {"mit-fp": 1.015, "mit-vp": 1.02},
    "line": {"mit-fp": 1.015, "mit-vp": 1.02},
    "square": {"mit-fp": 1.015, "mit-vp": 1.02},
    "zigzag": {"mit-fp": 1.015, "mit-vp": 1.02},
    "circuit": {"mit-fp": 1.01, "mit-vp": 1.012},
    "cloud": {"mit-fp": 1.01, "mit-vp": 1.012},
}
FAST = {"climb": 1.03, "line": 1.03, "square": 1.04, "zigzag": 1.04, "circuit": 1.03, "cloud": 1.03}


def points(positions, **everywhere):
    return tuple(Waypoint(tuple(map(float, p)), item=i, **everywhere) for i, p in enumerate(positions))


@cache
def planned(name, vehicle_name, mode="fast", kind="rotors"):
    vehicle = load_vehicle(vehicle_name)
    return plan_near_optimal(points(COURSES[name]), vehicle, limits_of(vehicle, kind), mode)


def dense(plan):
    t = np.arange(0.0, plan.T, 1e-4)
    derivatives = plan.trajectory.derivatives(t)
    return derivatives, inverse_dynamics(t, derivatives, plan.vehicle, (), UPRIGHT)


def assert_inside(plan, limits):
    """Every limit at 10 kHz, by the Python inverse dynamics."""
    derivatives, out = dense(plan)
    assert plan.certified
    assert plan.violation_N == 0.0
    assert out.rotors.max() <= limits.rotor_max + 1e-9
    assert out.rotors.min() >= limits.rotor_min - 1e-9
    if limits.speed_max is not None:
        assert np.linalg.norm(derivatives[:, 1, :3], axis=1).max() <= limits.speed_max + 1e-9
    if limits.body_rate_max is not None:
        assert np.linalg.norm(out.w_WD_D, axis=1).max() <= limits.body_rate_max + 1e-9
    if limits.floor is not None:
        assert derivatives[:, 0, 2].min() >= limits.floor - 1.001e-3
    if limits.force_z_min is not None and not (plan.vehicle.variable_pitch and out.vertical.all()):
        assert out.force[:, 2].min() >= limits.force_z_min - 1e-9


@pytest.mark.parametrize("vehicle", ["mit-fp", "mit-vp"])
@pytest.mark.parametrize("name", COURSES)
def test_fast_plans_are_within_a_few_percent_of_the_least_time_and_inside_the_rotor_limits(name, vehicle):
    plan = planned(name, vehicle)
    assert LEAST[name][vehicle] <= plan.T <= FAST[name] * LEAST[name][vehicle]
    assert_inside(plan, limits_of(plan.vehicle, "rotors"))


@pytest.mark.parametrize("vehicle", ["mit-fp", "mit-vp"])
@pytest.mark.parametrize("name", COURSES)
def test_best_plans_are_within_two_percent_of_the_least_time_and_inside_the_rotor_limits(name, vehicle):
    plan = planned(name, vehicle, "best")
    assert LEAST[name][vehicle] <= plan.T <= BEST[name][vehicle] * LEAST[name][vehicle]
    assert_inside(plan, limits_of(plan.vehicle, "rotors"))


@pytest.mark.parametrize("vehicle", ["mit-fp", "mit-vp"])
@pytest.mark.parametrize("name", ["climb", "line", "square", "zigzag"])
def test_every_limit_of_a_mission_holds_at_every_time(name, vehicle):
    plan = planned(name, vehicle, kind="mission")
    assert_inside(plan, Limits.of(plan.vehicle))
    assert plan.T < plan_course(points(COURSES[name]), plan.vehicle).T


@pytest.mark.parametrize("mode", ["fast", "best"])
@pytest.mark.parametrize("name", COURSES)
def test_variable_pitch_is_never_slower_than_fixed_pitch(name, mode):
    assert planned(name, "mit-vp", mode).T <= planned(name, "mit-fp", mode).T + 1e-9


@pytest.mark.parametrize("kind", ["rotors", "mission"])
@pytest.mark.parametrize("vehicle", ["mit-fp", "mit-vp"])
@pytest.mark.parametrize("name", ["line", "square", "zigzag"])
def test_best_is_never_slower_than_fast(name, vehicle, kind):
    best, fast = (planned(name, vehicle, mode, kind) for mode in ("best", "fast"))
    assert best.T <= fast.T
    assert_inside(best, limits_of(best.vehicle, kind))


def test_waypoints_are_met_at_the_times_that_the_plan_says_and_everything_is_continuous():
    plan = planned("zigzag", "mit-vp")
    there = plan.trajectory.at(plan.times_s)[:, :3]
    assert np.abs(there - ZIGZAG).max() < 1e-9
    knots, eps = plan.trajectory.times[1:-1], 1e-9
    for d, scale in enumerate([1.0, 1.0, 10.0, 100.0, 1e4]):
        jump = plan.trajectory.at(knots + eps, d) - plan.trajectory.at(knots - eps, d)
        assert np.abs(jump).max() < 1e-4 * scale


def test_the_same_course_gives_the_same_plan():
    again = plan_near_optimal(points(ZIGZAG), FP, limits_of(FP, "rotors"), "fast")
    assert np.array_equal(again.trajectory.coefficients, planned("zigzag", "mit-fp").trajectory.coefficients)


def test_a_plan_reads_back_as_it_was_written(tmp_path):
    plan = planned("square", "mit-fp")
    plan.save(tmp_path / "plan.npz")
    read = Plan.load(tmp_path / "plan.npz")
    assert read.mode == "fast"
    assert read.T == plan.T
    assert np.array_equal(read.sample()["f1_N"], plan.sample()["f1_N"])


def test_the_kernel_and_the_python_inverse_dynamics_agree_on_every_rotor():
    plan = planned("zigzag", "mit-vp")
    out = dense(plan)[1]
    assert np.allclose(out.rotors.min(axis=0), plan.rotor_min, atol=1e-3)
    assert np.allclose(out.rotors.max(axis=0), plan.rotor_max, atol=1e-3)


def test_a_planted_millinewton_is_refused_and_its_piece_named():
    plan = planned("zigzag", "mit-fp")
    out = dense(plan)[1]
    t = 1e-4 * np.unravel_index(out.rotors.argmax(), out.rotors.shape)[0]
    piece = int(np.searchsorted(plan.trajectory.times, t, side="right")) - 1
    vehicle = kernel.Vehicle(
        mass=FP.mass_kg, inertia=FP.inertia_kg_m2, arm=FP.arm_m, yaw_coefficient=FP.yaw_coefficient_m, gravity=GRAVITY
    )
    allowed = kernel.Constraints(vehicle, kernel.Limits(rotor_min=0.15, rotor_max=3.0), False)
    less = kernel.Constraints(vehicle, kernel.Limits(rotor_min=0.15, rotor_max=out.rotors.max() - 1e-3), False)
    T = plan.trajectory.durations
    no_limit = [kernel.PieceLimits()] * len(T)
    assert kernel.certify(plan.trajectory.coefficients, T, no_limit, allowed).proven
    refused = kernel.certify(plan.trajectory.coefficients, T, no_limit, less)
    assert not refused.proven
    assert piece in refused.unproven
    lifted = plan.trajectory.coefficients.copy()
    lifted[3, 9, 2] += 20.0  # one piece alone is made impossible
    assert kernel.certify(lifted, T, no_limit, allowed).unproven == [3]


DEGENERATE = {
    "two points 1 cm apart": [(0, 0, 1), (0.01, 0, 1)],
    "repeated points": [(0, 0, 1), (2, 0, 1), (2, 0, 1), (4, 1, 1)],
    "a leg of 1 cm between long ones": [(0, 0, 1), (5, 0, 1), (5.01, 0, 1), (10, 0, 1)],
    "a leg of 1 km": [(0, 0, 1), (1000, 0, 1), (1001, 0, 1)],
    "collinear": [(0, 0, 1), (1, 0, 1), (2, 0, 1), (7, 0, 1)],
    "there and back": [(0, 0, 1), (5, 0, 1), (0, 0, 1)],
    "down": [(0, 0, 6), (0, 0, 1)],
    "up and down": [(0, 0, 1), (0, 0, 5), (0, 0, 2)],
    "a slanted drop": [(0, 0, 6), (1, 0, 1)],
}


@pytest.mark.parametrize("kind", ["rotors", "mission"])
@pytest.mark.parametrize("vehicle", [FP, VP], ids=lambda v: v.name)
@pytest.mark.parametrize("course", DEGENERATE.values(), ids=DEGENERATE.keys())
def test_whatever_the_course_the_plan_is_proven_and_meets_its_points(course, vehicle, kind):
    limits = limits_of(vehicle, kind)
    plan = plan_near_optimal(points(course), vehicle, limits, "fast")
    assert_inside(plan, limits)
    assert np.abs(plan.trajectory.at(plan.times_s)[:, :3] - course).max() < 1e-6


@settings(max_examples=8, derandomize=True)
@given(
    st.lists(st.tuples(*[st.floats(-5, 5)] * 2, st.floats(0.6, 4)), min_size=2, max_size=5, unique=True), st.booleans()
)
def test_random_courses_are_flown_inside_all_limits_of_a_mission(course, variable_pitch):
    vehicle = VP if variable_pitch else FP
    assume(max(np.linalg.norm(np.subtract(p, course[0])) for p in course) > 2e-3)
    plan = plan_near_optimal(points(course), vehicle, mode="fast")
    assert_inside(plan, Limits.of(vehicle))


def test_holds_given_velocities_and_speed_limits_are_kept():
    course = [
        Waypoint((0.0, 0.0, 1.0), speed_max=2.0),
        Waypoint((3.0, 0.0, 1.0), velocity=(1.5, 0.0, 0.0)),
        Waypoint((6.0, 1.0, 1.5), hold_s=0.5, yaw=1.0),
        Waypoint((8.0, 3.0, 1.0), yaw=1.0),
    ]
    plan = plan_near_optimal(course, VP, mode="fast")
    assert_inside(plan, Limits.of(VP))
    velocity = plan.trajectory.at(np.linspace(0.0, plan.times_s[1], 2000), 1)[:, :3]
    assert np.linalg.norm(velocity, axis=1).max() <= 2.0 + 1e-9
    assert np.allclose(plan.trajectory.at(plan.times_s[1], 1)[0, :3], (1.5, 0.0, 0.0), atol=1e-6)
    assert np.allclose(plan.trajectory.at(plan.times_s[2] + 0.25)[0], (6.0, 1.0, 1.5, 1.0), atol=1e-12)
    assert plan.trajectory.at(plan.T)[0, 3] == pytest.approx(1.0)


def test_a_given_heading_is_kept_and_costs_time():
    course = points([(0, 0, 1), (4, 0, 1), (4, 4, 1)], yaw=0.5)
    given_yaw = plan_near_optimal(course, FP, limits_of(FP, "rotors"), "fast", yaw=Yaw("given"))
    free_yaw = plan_near_optimal(course, FP, limits_of(FP, "rotors"), "fast")
    assert np.allclose(given_yaw.trajectory.at(given_yaw.times_s)[:, 3], 0.5)
    assert free_yaw.T < 1.005 * given_yaw.T


def test_what_no_flight_can_meet_is_refused_by_name():
    too_fast = [Waypoint((0.0, 0.0, 1.0)), Waypoint((3.0, 0.0, 1.0), velocity=(20.0, 0.0, 0.0), item=7),
                Waypoint((6.0, 0.0, 1.0))]  # fmt: skip
    with pytest.raises(InfeasibleSegment, match=r"item 7: speed of 20.00 m/s is above the limit"):
        plan_near_optimal(too_fast, FP)
    impossible = [replace(too_fast[0]), replace(too_fast[1], velocity=None, acceleration=(0.0, 0.0, 40.0)), too_fast[2]]
    with pytest.raises(InfeasibleSegment, match=r"item 7.*: rotor \d would be exceeded by .* N"):
        plan_near_optimal(impossible, FP)


def test_stopped_by_hand_it_returns_the_best_proven_flight_so_far():
    said = []

    def stop_after_a_while(words):
        said.append(words)
        if len(said) == 70:
            raise KeyboardInterrupt

    plan = plan_near_optimal(points(ZIGZAG), FP, limits_of(FP, "rotors"), "best", stop_after_a_while)
    assert_inside(plan, limits_of(FP, "rotors"))
    assert planned("zigzag", "mit-fp", "best").T <= plan.T < 7.0


def test_the_kernel_s_pieces_are_those_of_the_python_hermite_form():
    nodes = np.arange(40.0).reshape(2, 5, 4) / 10.0
    problem = kernel.Problem(nodes, [0.8], np.ones((2, 5, 4), bool), [0], [kernel.PieceLimits()], [False] * 4, True)
    assert np.allclose(problem.coefficients, solve_many(nodes, np.array([[0.8]]))[0], rtol=1e-12)


def test_a_long_course_is_planned_and_proven():
    rng = np.random.default_rng(3)
    course = rng.uniform((-5, -5, 0.5), (5, 5, 3.5), (120, 3))
    plan = plan_near_optimal(points(course), FP, limits_of(FP, "rotors"), "fast")
    assert plan.certified
    assert plan.T / 119 < 0.96


def test_what_fails_in_a_long_flight_is_flown_anew_in_a_window_and_the_rest_stays():
    course = np.random.default_rng(3).uniform((-5, -5, 0.5), (5, 5, 3.5), (120, 3))
    limits = limits_of(FP, "rotors")
    setup = Setup.of(checked_nodes(points(course), FP, limits), FP, limits, Yaw("free"), ())
    constraints = setup.constraints(limits)
    search = Search(recipe_for("fast", 119, limits), False, lambda _: None)
    flight = search.planned(warm_start(setup, constraints), constraints)

    assert search.proven(flight, constraints)
    hasty = flight.with_part(60, flight.part(60, 62).stretched(0.97))  # three nodes are passed too fast
    assert not search.proven(hasty, constraints)
    mended = search.mended(hasty, constraints, search.recipe.ladder[-1])
    assert search.proven(mended, constraints)
    assert mended.durations[:40] + mended.durations[80:] == flight.durations[:40] + flight.durations[80:]


@pytest.mark.long
def test_ten_thousand_random_points_are_planned_and_proven():
    course = np.random.default_rng(1).uniform((-5, -5, 0.5), (5, 5, 3.5), (10_000, 3))
    plan = plan_near_optimal(points(course), FP, limits_of(FP, "rotors"), "fast")
    assert plan.certified
    assert plan.T / 9999 < 0.945


TURNS = [(0, 0, 1), (6, -4, 3), (2, -10, 4), (-5, -4, 3), (5, 5, 5), (0, 10, 2), (0, 0, 1)]
REVERSALS = np.random.default_rng(3).uniform((-10, -10, 1), (10, 10, 5), (7, 3)).round(1).tolist()


@pytest.mark.parametrize(("points", "room", "more"), [(TURNS, 0.0, 1.02), (TURNS, 3.0, 1.02), (REVERSALS, 0.1, 1.5)])
def test_a_nose_along_the_path_costs_little_whatever_the_turns_and_under_a_ceiling(points, room, more):
    """What fits at once hardly moves, and a search that begins there would end there."""
    ceiling = max(point[2] for point in points) + room
    limits = replace(limits_of(VP), ceiling=ceiling)
    route = [Waypoint(position=tuple(point)) for point in points]
    free, plan = (plan_near_optimal(route, VP, limits, "fast", yaw=Yaw(rule)) for rule in ("free", "path"))
    assert plan.certified
    slower = plan.T / free.T
    assert slower < more
    assert plan.trajectory.at(np.linspace(0.0, plan.T, 4001))[:, 2].max() < ceiling + 0.002
