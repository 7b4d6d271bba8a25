"""Manoeuvres as plans: inside the rotor limits all the way, through zero force too, and as upright as they say."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from halfroll import preflight
from halfroll.errors import MissionError
from halfroll.manoeuvres.library import (
    Backflip,
    FigureEight,
    Flip,
    HalfRoll,
    InvertedLeg,
    Manoeuvre,
    PowerLoop,
    SplitS,
    Window,
    rolled_over,
    turned,
)
from halfroll.missions.geodesy import DEFAULT_ORIGIN, global_from_local
from halfroll.missions.mission import MissionItem, PlanOptions, Waypoint
from halfroll.planner.course import flown_waypoints
from halfroll.planner.near_optimal import plan_in_mode
from halfroll.planner.plan import Plan
from halfroll.vehicle import load_vehicle
from halfroll.wire.frames import degrees_to_wire
from oracle import rigid_body

VP, FP = load_vehicle("mit-vp"), load_vehicle("mit-fp")
START = Waypoint((0.0, 0.0, 8.0), yaw=0.7)
LIMIT = 2.7  # [N], with the margin of a mission


def planned(flown: list[Waypoint], mode: str = "paper", start: Waypoint = START) -> Plan:
    return plan_in_mode((start, *flown), VP, PlanOptions(mode=mode))


def is_flyable(plan: Plan) -> bool:
    """The rotors stay inside their limits, looked at ten times as densely as the planner does, and it ends at rest."""
    t = np.linspace(0.0, plan.T, 20001)
    out = plan.outputs(t)
    assert plan.certified
    assert np.abs(out.rotors).max() < LIMIT + 1e-4
    assert np.linalg.norm(out.w_WD_D, axis=1).max() < 20.0 + 1e-3
    assert np.abs(np.diff(out.q_WD, axis=0)).max() < 0.02  # the attitude never jumps
    assert np.abs(np.diff(out.rotors, axis=0)).max() < 0.1  # nor does a rotor, at F = 0 either
    assert plan.at(plan.T).velocity == pytest.approx(0.0, abs=1e-6)
    return True


def up_axis(plan: Plan, t: float) -> np.ndarray:
    return plan.outputs(np.array([t])).thrust_axis[0]


@pytest.fixture(scope="module")
def half_roll() -> Plan:
    return planned(turned(START, "roll", 0.5))


def test_a_half_roll_ends_upside_down_beside_where_it_began_with_the_nose_where_it_was(half_roll: Plan) -> None:
    assert is_flyable(half_roll)
    assert len(half_roll.flips) == len(half_roll.sigma_events) == 1
    assert up_axis(half_roll, half_roll.T) == pytest.approx([0.0, 0.0, -1.0], abs=1e-6)
    nose = rigid_body.rotation(half_roll.outputs(np.array([0.0, half_roll.T])).q_WD[1])[:, 0]
    assert nose == pytest.approx([math.cos(0.7), math.sin(0.7), 0.0], abs=1e-6)
    right = np.array([math.sin(0.7), -math.cos(0.7), 0.0])
    assert half_roll.at(half_roll.T).position == pytest.approx([0.0, 0.0, 8.0] + 0.4 * right, abs=1e-6)


def test_its_rotor_thrusts_fly_a_free_rigid_body_through_zero_force_to_upside_down(half_roll: Plan) -> None:
    """The oracle knows nothing of charts, signs or flips."""
    plan, path = half_roll, half_roll.trajectory

    def thrusts(now: float) -> np.ndarray:
        return plan.outputs(np.array([now])).rotors[0]

    q = plan.outputs(np.array([0.0])).q_WD[0]
    start = np.concatenate([plan.at(0.0).position, np.zeros(3), q, np.zeros(3)])
    flip = plan.flips[0]
    breaks = np.array([0.0, flip - 2e-4, flip, flip + 2e-4, plan.T])
    body = {
        "mass": VP.mass_kg,
        "inertia": VP.inertia_kg_m2,
        "arm": VP.arm_m,
        "yaw_coefficient": VP.yaw_coefficient_m,
    }
    positions, attitudes = rigid_body.fly_open_loop(thrusts, breaks, start, rtol=1e-6, **body)
    assert positions == pytest.approx(path.at(breaks)[:, :3], abs=1e-4)
    assert rigid_body.rotation(attitudes[-1])[2, 2] == pytest.approx(-1.0, abs=1e-4)


def test_it_takes_as_long_in_any_direction_that_is_as_far_from_the_nose(half_roll: Plan) -> None:
    assert (
        pytest.approx(half_roll.T, rel=1e-3)
        == planned(turned(replace(START, yaw=-2.0), "pitch", -0.5), start=replace(START, yaw=-2.0)).T
    )


def test_a_flip_on_the_spot_turns_once_and_is_back() -> None:
    plan = planned(turned(START, "pitch", 1.0))
    assert is_flyable(plan)
    assert len(plan.flips) == len(plan.sigma_events) == 2
    assert plan.at(plan.T).position == pytest.approx(START.position, abs=1e-6)
    n = plan.outputs(np.linspace(0.0, plan.T, 4001)).thrust_axis
    back = n @ np.array([-math.cos(0.7), -math.sin(0.7), 0.0])
    turn = np.unwrap(np.arctan2(back, n[:, 2]))  # nose up: the thrust axis goes backwards
    assert np.degrees(turn[-1] - turn[0]) == pytest.approx(360.0, abs=1e-3)
    assert plan.sample()["z_m"].min() > 7.9


MANOEUVRES: list[tuple[Manoeuvre, int]] = [
    (HalfRoll(at=0, kind="half_roll"), 1),
    (Flip(at=0, kind="flip"), 2),
    (Backflip(at=0, kind="backflip"), 2),
    (SplitS(at=0, kind="split_s"), 2),
    (PowerLoop(at=0, kind="power_loop"), 2),
    (InvertedLeg(at=0, kind="inverted_leg"), 2),
    (Window(at=0, kind="window", roll_deg=60.0), 0),
    (FigureEight(at=0, kind="figure_eight"), 0),
]
EXAMPLE = Path(__file__).parents[2] / "examples" / "aerobatics.toml"
PAGE = Path(__file__).parents[2] / "docs" / "aerobatics.md"


@cache
def plan_of(number: int, mode: str) -> Plan:
    return planned(MANOEUVRES[number][0].waypoints(START), mode)


@pytest.mark.long
@pytest.mark.parametrize("mode", ["paper", "fast", "best"])
@pytest.mark.parametrize("number", range(len(MANOEUVRES)), ids=[m.kind for m, _ in MANOEUVRES])
def test_every_manoeuvre_stays_inside_the_limits_and_turns_over_as_often_as_it_should(number: int, mode: str) -> None:
    plan, changes = plan_of(number, mode), MANOEUVRES[number][1]
    assert is_flyable(plan)
    assert len(plan.sigma_events) == changes
    assert up_axis(plan, plan.T)[2] == pytest.approx(-1.0 if changes % 2 else 1.0, abs=1e-6)


@pytest.mark.long
def test_mode_best_saves_the_seconds_that_the_page_says() -> None:
    rows = {m.kind: [plan_of(k, mode).T for mode in ("paper", "best")] for k, (m, _) in enumerate(MANOEUVRES)}
    rows["examples/aerobatics.toml"] = [preflight.plan(EXAMPLE, mode=mode).T for mode in ("paper", "best")]
    for name, (paper, best) in rows.items():
        print(f"| `{name}` | {paper:.2f} | {best:.2f} | {100.0 * (1.0 - best / paper):.0f} % |")
        assert best < 0.98 * paper, name
    table = re.findall(r"\| `(\S+)` \| ([\d.]+) \| ([\d.]+) \| \d+ % \|", PAGE.read_text(encoding="utf-8"))
    assert {name for name, *_ in table} == set(rows)
    for name, *told in table:
        assert [float(seconds) for seconds in told] == pytest.approx(rows[name], abs=0.02), name


def test_a_best_half_roll_is_shorter_flyable_and_as_smooth_where_its_thrust_turns_over(half_roll: Plan) -> None:
    plan = planned(turned(START, "roll", 0.5), "best")
    assert is_flyable(plan)
    assert plan.T < 0.92 * half_roll.T
    assert plan.sample()["z_m"].min() > half_roll.sample()["z_m"].min() - 2e-3
    path, piece = plan.trajectory, int(np.argmin(np.abs(plan.trajectory.times - plan.flips[0])))
    scale = path.durations[:, None] ** np.arange(10)
    powers = np.array([math.perm(i, 5) if i >= 5 else 0 for i in range(10)])
    before = (powers[:, None] * path.coefficients[piece - 1] / path.durations[piece - 1] ** 5).sum(axis=0)
    after = 120.0 * path.coefficients[piece][5] / scale[piece, 5]
    assert before == pytest.approx(after, rel=1e-6, abs=1e-3 * np.abs(after).max())


@pytest.mark.parametrize("mode", [pytest.param("paper", marks=pytest.mark.long), "fast"])
def test_an_attitude_is_met_with_its_roll_pitch_and_heading(mode: str) -> None:
    attitude = Window(at=0, kind="window", roll_deg=40.0, pitch_deg=-10.0).waypoints(START)[0].q_WB
    assert attitude is not None
    through = Waypoint((3.0, 1.0, 8.5), q_WB=attitude)
    plan = planned([through, Waypoint((6.0, 0.0, 8.0))], mode)
    assert is_flyable(plan)
    q = plan.outputs(np.array([0.0, plan.times_s[1]])).q_WD[1]
    assert abs(float(q @ np.array(attitude))) == pytest.approx(1.0, abs=1e-6)


def test_a_body_rate_is_met_where_attitude_and_thrust_are_given() -> None:
    level = (1.0, 0.0, 0.0, 0.0)
    rate = (0.5, -1.2, 0.3)
    through = Waypoint((3.0, 0.0, 8.0), q_WB=level, thrust=6.0, body_rate=rate)
    plan = planned([through, Waypoint((6.0, 0.0, 8.0))], start=replace(START, yaw=0.0))
    out = plan.outputs(np.array([plan.times_s[1]]))
    assert out.w_WD_D[0] == pytest.approx(rate, abs=1e-5)
    assert out.thrust[0] == pytest.approx(6.0, abs=1e-6)


def test_inverted_legs_are_flown_by_the_same_rotors_as_their_mirror_image() -> None:
    there = Waypoint((3.0, 1.0, 8.0), upright=False).standing
    inverted = rolled_over(START, upright=False)
    plan = planned([*inverted, there, *rolled_over(there, upright=True)], "fast")
    assert is_flyable(plan)
    assert plan.at((plan.flips[0] + plan.flips[1]) / 2.0).sigma == -1.0
    leg = 0.5 * (plan.turns or ())[0][1] + 0.5 * (plan.turns or ())[1][0]
    assert up_axis(plan, leg)[2] < 0.0
    assert plan.outputs(np.array([leg])).thrust[0] < 0.0


@pytest.mark.parametrize(
    ("flown", "why"),
    [
        (turned(Waypoint((0.0, 0.0, 1.0)), "roll", 1.0), "begin at 2.0 m or higher"),
        ([Waypoint((3.0, 0.0, 8.0), q_WB=(1.0, 0.0, 0.0, 0.0), thrust=20.0), Waypoint((6.0, 0.0, 8.0))], "may give"),
        (
            [Waypoint((3.0, 0.0, 8.0), q_WB=(1.0, 0.0, 0.0, 0.0), thrust=-5.0), Waypoint((6.0, 0.0, 8.0))],
            "more than 0 N",
        ),
        ([Waypoint((3.0, 0.0, 8.0), q_WB=(0.0, 1.0, 0.0, 0.0)), Waypoint((6.0, 0.0, 8.0))], "ends at 140 deg"),
        ([Waypoint((3.0, 0.0, 8.0), upright=False)], "cannot turn upside down while it stands"),
    ],
)
def test_what_cannot_be_flown_is_said_in_a_sentence_with_its_item(flown: list[Waypoint], why: str) -> None:
    numbered = [replace(point, item=7) for point in flown]
    height = numbered[-1].position[2]
    with pytest.raises(MissionError, match="item 7.*" + why) as refused:
        planned(numbered, start=Waypoint((0.0, 0.0, height), item=0))
    assert refused.value.item == 7
    assert refused.value.exit_code == 2


@pytest.mark.parametrize("flown", [turned(START, "roll", 0.5), Backflip(at=0, kind="backflip").waypoints(START)])
def test_rotors_that_only_push_up_refuse_what_turns_over(flown: list[Waypoint]) -> None:
    with pytest.raises(MissionError, match="fixed pitch"):
        plan_in_mode((START, *flown), FP, PlanOptions())


def test_a_flip_outside_the_plane_of_its_neighbours_says_so() -> None:
    falling, end = turned(START, "roll", 0.5)
    with pytest.raises(MissionError, match="off the vertical plane"):
        planned([Waypoint((2.0, 0.0, 8.0)), falling, end])


# ---- as items

NAN = math.nan


def at(
    x: float, y: float, z: float, command: int = 16, params: tuple[float, ...] = (0.0, 0.0, 0.0, NAN)
) -> MissionItem:
    lat, lon, _ = global_from_local(DEFAULT_ORIGIN, (x, y, z))
    return MissionItem(command, 3, params, degrees_to_wire(lat), degrees_to_wire(lon), z)  # type: ignore[arg-type]


def turn(command: int, *params: float) -> MissionItem:
    return MissionItem(command, 2, (*params, *([NAN] * (4 - len(params)))), 0, 0, 0.0)  # type: ignore[arg-type]


def test_items_turn_the_mission_over_where_they_stand_and_the_plan_ends_upright() -> None:
    items = (at(0, 0, 8, 22), at(4, 0, 8), turn(210, 1), at(8, 0, 8), turn(31010, 1, 1.0), turn(20))
    flown = flown_waypoints(items).waypoints
    upright = [point.upright for point in flown]
    assert upright[:2] == [True, True]
    assert upright[2:5] == [False, False, False]
    assert upright[-1]
    assert [point.item for point in flown[:5]] == [0, 1, 2, 2, 3]
    assert {point.item for point in flown[5:9]} == {4}
    assert flown[1].stands
    assert flown[4].stands


def test_an_attitude_item_gives_attitude_and_speed_along_the_way() -> None:
    items = (at(0, 0, 8, 22), at(4, 0, 8, 31000, (30.0, 0.0, 3.0, 0.0)), at(8, 0, 8))
    _, through, _ = flown_waypoints(items).waypoints
    assert through.q_WB == pytest.approx((math.cos(math.radians(15)), math.sin(math.radians(15)), 0.0, 0.0), abs=1e-6)
    assert through.velocity == pytest.approx((3.0, 0.0, 0.0), abs=0.02)


def test_the_rest_of_a_mission_that_was_inverted_begins_by_turning_over() -> None:
    items = (at(0, 0, 8, 22), turn(210, 1), at(4, 0, 8), at(8, 0, 8))
    flown = flown_waypoints(items, from_item=3, start=(3.0, 0.0, 8.0)).waypoints
    assert [point.upright for point in flown[:4]] == [True, False, False, False]


@pytest.mark.parametrize(
    ("items", "item", "why"),
    [
        ((turn(210, 1), at(0, 0, 8), at(4, 0, 8)), 0, "before there is a place"),
        ((at(0, 0, 8), at(4, 0, 8, 31000, (30.0, 0.0, 0.0, 0.0)), at(8, 0, 8)), 1, "nothing stands still at an angle"),
        (
            (at(0, 0, 8), at(4, 0, 8, 31000, (30.0, 0.0, NAN, 0.0)), turn(31010, 1, 1.0), at(8, 0, 8)),
            2,
            "begins at rest",
        ),
        (
            (at(0, 0, 8), at(4, 0, 8, 31000, (30.0, 0.0, NAN, 0.0)), at(4, 0, 8, 31000, (-30.0, 0.0, NAN, 0.0))),
            2,
            "no way between them",
        ),
    ],
)
def test_items_that_contradict_each_other_are_refused(items: tuple[MissionItem, ...], item: int, why: str) -> None:
    with pytest.raises(MissionError, match=why) as refused:
        flown_waypoints(items)
    assert refused.value.item == item


def test_a_flip_keeps_the_height_and_the_time_its_item_asks_for() -> None:
    def asks(least: float, longest: float) -> Plan:
        course = flown_waypoints((at(0, 0, 8, 22), at(2, 0, 8), turn(31010, 1, 0.5, least, longest)))
        return plan_in_mode(course.waypoints, VP, PlanOptions(), demands=course.demands)

    assert asks(7.9, 2.0).certified
    with pytest.raises(MissionError, match="it is to stay above"):
        asks(8.5, 2.0)
    with pytest.raises(MissionError, match="it is to take at most"):
        asks(NAN, 0.1)
