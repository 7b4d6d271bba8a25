"""Every limit that a person can give holds at every time, also between samples; what cannot hold is refused by name."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from halfroll import preflight
from halfroll.errors import HalfrollError, InfeasibleSegment, InputError, MissionError
from halfroll.missions.mission import Fence, PlanOptions, Rules, Waypoint, Yaw
from halfroll.planner.flatness import UPRIGHT, inverse_dynamics
from halfroll.planner.limits import RATE_ROOM, SETTABLE, Drive, Limits, changed
from halfroll.planner.near_optimal import limits_of, plan_in_mode, plan_near_optimal
from halfroll.vehicle import load_vehicle

VP, FP = load_vehicle("mit-vp"), load_vehicle("mit-fp")
VEHICLES = pytest.mark.parametrize("vehicle", [VP, FP], ids=lambda vehicle: vehicle.name)
SQUARE = [(0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1), (0, 0, 1)]
EXAMPLES = Path(__file__).parents[2] / "examples"
ZIGZAG = [(0, 0, 1), (2, 1, 2), (4, -1, 1), (6, 1, 2.5), (8, -1, 1), (10, 0, 1.5)]


def points(positions, **everywhere):
    return [Waypoint(tuple(map(float, p)), item=i, **everywhere) for i, p in enumerate(positions)]


def dense(plan):
    """Times, derivatives (n, 6, 4) and inverse dynamics at 10 kHz, independent of the kernel."""
    t = np.arange(0.0, plan.T, 1e-4)
    derivatives = plan.trajectory.derivatives(t)
    return t, derivatives, inverse_dynamics(t, derivatives, plan.vehicle, (), UPRIGHT)


def within(plan, first, last):
    """Of dense(plan): the times between two waypoints."""
    t = dense(plan)[0]
    return (t >= plan.times_s[first]) & (t <= plan.times_s[last])


def rotor_rates(plan):
    """(thrusts, their rates) by differences, away from the knots, where rates may jump."""
    t, _, out = dense(plan)
    rates = (out.rotors[2:] - out.rotors[:-2]) / 2e-4
    smooth = np.abs(t[1:-1, None] - plan.trajectory.times[None, :]).min(axis=1) > 1.5e-4
    return out.rotors[1:-1][smooth], rates[smooth]


# ---- how quickly rotors change


@VEHICLES
def test_rotors_are_asked_for_nothing_that_they_cannot_follow(vehicle):
    limits = Limits.of(vehicle)
    plan = plan_near_optimal(points(ZIGZAG), vehicle, limits, "fast")
    f, rate = rotor_rates(plan)
    drive, spare = limits.drive, 1e-3
    assert np.abs(rate).max() <= limits.rotor_rate_max + 0.1
    if vehicle.variable_pitch:  # the command that a first-order lag of thrust needs
        command = f + drive.lag_up * rate
    else:  # of motor speed, the root of thrust
        speed = np.sqrt(f) + np.where(rate > 0, drive.lag_up, drive.lag_down) * rate / (2.0 * np.sqrt(f))
        command = np.maximum(speed, 0.0) ** 2
    assert command.max() <= drive.command_max + spare
    assert command.min() >= drive.command_min - spare
    assert plan.certified


def test_without_that_limit_the_slow_motors_would_be_asked_for_twice_their_thrust():
    free = replace(Limits.of(FP), drive=None, rotor_rate_max=None)
    f, rate = rotor_rates(plan_near_optimal(points(ZIGZAG), FP, free, "fast"))
    assert ((np.sqrt(f) + FP.rotor.lag_s * rate / (2.0 * np.sqrt(f))) ** 2).max() > 6.0


def test_a_thrust_rate_limit_of_one_s_own_is_obeyed_and_costs_time():
    limits = Limits.of(VP)
    slow = plan_near_optimal(points(SQUARE), VP, changed(limits, [("rotor_rate_N_s", 15.0)]), "fast")
    assert np.abs(rotor_rates(slow)[1]).max() <= 15.0 + 0.05
    assert slow.T > plan_near_optimal(points(SQUARE), VP, limits, "fast").T


@pytest.mark.parametrize("vehicle", [VP, FP], ids=lambda vehicle: vehicle.name)
def test_straight_up_the_rates_are_limited_too(vehicle):
    limits = Limits.of(vehicle)
    plan = plan_near_optimal(points([(0, 0, 1), (0, 0, 4)]), vehicle, limits, "best")
    f, rate = rotor_rates(plan)
    if vehicle.variable_pitch:
        assert (f + limits.drive.lag_up * rate).max() <= limits.drive.command_max + 1e-3
        assert (f + limits.drive.lag_up * rate).min() >= limits.drive.command_min - 1e-3
    else:
        assert (np.sqrt(f) + limits.drive.lag_up * rate / (2 * np.sqrt(f))).max() <= np.sqrt(
            limits.drive.command_max
        ) + 1e-3


def test_the_drive_of_a_vehicle_is_what_its_file_says():
    assert Drive.of(FP, 0.45, 2.7) == Drive(RATE_ROOM * 0.12, RATE_ROOM * 0.12, True, 0.45, 2.7)
    assert Drive.of(VP, -2.7, 2.7) == Drive(RATE_ROOM * 0.018, RATE_ROOM * 0.018, False, -2.7, 2.7)
    assert Limits.of(VP, "rotors").drive is None


# ---- where and how it may fly


@VEHICLES
def test_tilt_ceiling_and_floor_hold_at_every_time(vehicle):
    options = PlanOptions("fast", changes=(("tilt_deg", 35.0), ("ceiling_m", 2.6), ("floor_m", 0.9)))
    plan = plan_in_mode(points(ZIGZAG), vehicle, options)
    _, derivatives, out = dense(plan)
    assert np.degrees(np.arccos(out.thrust_axis[:, 2])).max() <= 35.0 + 1e-6
    assert derivatives[:, 0, 2].max() <= 2.6 + 1.001e-3
    assert derivatives[:, 0, 2].min() >= 0.9 - 1.001e-3
    assert plan.certified


def test_in_paper_mode_tilt_ceiling_and_floor_hold_too():
    plan = plan_in_mode(points(SQUARE), VP, PlanOptions("paper", changes=(("tilt_deg", 20.0), ("ceiling_m", 1.5))))
    _, derivatives, out = dense(plan)
    assert np.degrees(np.arccos(out.thrust_axis[:, 2])).max() <= 20.0 + 1e-6
    assert derivatives[:, 0, 2].max() <= 1.5
    assert plan.T > plan_in_mode(points(SQUARE), VP, PlanOptions("paper")).T


def test_each_leg_keeps_its_own_speed():
    course = points(ZIGZAG)
    course[1], course[2] = replace(course[1], speed_max=1.0), replace(course[2], speed_max=5.0)
    plan = plan_in_mode(course, VP, PlanOptions("fast"))
    speed = np.linalg.norm(dense(plan)[1][:, 1, :3], axis=1)
    assert speed[within(plan, 1, 2)].max() <= 1.0 + 1e-6
    assert 1.0 < speed[within(plan, 2, 3)].max() <= 5.0 + 1e-6


def test_body_rate_is_limited():
    plan = plan_in_mode(points(ZIGZAG), VP, PlanOptions("fast", changes=(("body_rate_deg_s", 200.0),)))
    assert np.degrees(np.linalg.norm(dense(plan)[2].w_WD_D, axis=1)).max() <= 200.0 + 1e-6


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ([("tilt", 30.0)], "limit 'tilt' is not known; there are speed_m_s"),
        ([("tilt_deg", 90.0)], "the horizon is at 90"),
        ([("speed_m_s", 0.0)], "nothing could fly"),
        ([("ceiling_m", float("nan"))], "a finite number is wanted"),
        ([("ceiling_m", 0.4)], r"floor of 0\.5 m is not below the ceiling of 0\.4 m"),
    ],
)
def test_limits_that_make_no_sense_are_refused_in_words(changes, complaint):
    with pytest.raises(InputError, match=complaint):
        changed(Limits.of(VP), changes)


def test_every_settable_limit_is_one_of_limits_and_can_be_switched_off():
    for name, setting in SETTABLE.items():
        assert getattr(changed(Limits.of(VP), [(name, None)]), setting.field) is None


def test_a_waypoint_above_the_ceiling_is_named_with_its_height():
    with pytest.raises(InfeasibleSegment, match=r"item 3: height 2\.50 m is above the ceiling of 2 m"):
        plan_in_mode(points(ZIGZAG), VP, PlanOptions("fast", changes=(("ceiling_m", 2.0),)))


# ---- where the nose points


@pytest.mark.parametrize("rule", ["path", "point"])
def test_the_nose_follows_the_path_or_a_point(rule):
    yaw = Yaw(rule, (5.0, 8.0))
    plan = plan_in_mode(points(ZIGZAG), VP, PlanOptions("fast", yaw=yaw))
    _, d, _ = dense(plan)
    look = d[:, 1, :2] if rule == "path" else np.array(yaw.point) - d[:, 0, :2]
    off = np.abs(np.angle(np.exp(1j * (d[:, 0, 3] - np.arctan2(look[:, 1], look[:, 0])))))
    far = np.linalg.norm(look, axis=1) > (3.0 if rule == "path" else 1.0)
    assert far.mean() > 0.5
    assert np.degrees(off[far]).max() <= 35.0
    assert plan.certified


def test_given_headings_are_met_exactly_and_free_ones_are_not_slower():
    course = [replace(point, yaw=0.4 * i) for i, point in enumerate(points(ZIGZAG))]
    met = plan_in_mode(course, FP, PlanOptions("fast", yaw=Yaw("given")))
    assert met.trajectory.at(met.times_s)[:, 3] == pytest.approx([point.yaw for point in course], abs=1e-9)
    free = plan_in_mode(course, FP, PlanOptions("fast", yaw=Yaw("free")))
    assert free.T < 1.005 * met.T


def test_yaw_in_words():
    assert Yaw.parsed("path") == Yaw("path")
    assert Yaw.parsed("3,-4.5") == Yaw("point", (3.0, -4.5))
    with pytest.raises(MissionError, match="give free, given, path, or NORTH,WEST"):
        Yaw.parsed("sideways")


# ---- fences

FIELD = Fence(True, ((-1, -2), (11, -2), (11, 1.905), (-1, 1.905)), "field")
POND = Fence(False, ((4.5, 0.6), (5.5, 0.6), (5.5, 3), (4.5, 3)), "pond")
CORNER = Fence(True, ((-1, -1), (5, -1), (5, 5), (3.6, 5), (3.6, 0.3), (-1, 0.3)), "yard")  # not convex


@VEHICLES
def test_the_path_stays_inside_a_fence_and_outside_of_what_is_forbidden(vehicle):
    course = points([(0, 0, 1), (2.5, 1.9, 1), (5, 0.2, 1), (7.5, 1.9, 1), (10, 0, 1)])
    free = plan_in_mode(course, vehicle, PlanOptions("fast"))
    fenced = plan_in_mode(course, vehicle, PlanOptions("fast"), Rules((FIELD, POND)))
    assert dense(free)[1][:, 0, 1].max() > 1.905
    x, y = dense(fenced)[1][:, 0, 0], dense(fenced)[1][:, 0, 1]
    assert y.max() <= 1.905 + 1e-6
    assert not ((x > 4.5 + 1e-6) & (x < 5.5 - 1e-6) & (y > 0.6 + 1e-6)).any()
    assert fenced.T > free.T
    assert fenced.certified


def test_a_fence_need_not_be_convex():
    course = points([(0, 0, 1), (4, 0, 1), (4.4, 4.5, 1)])
    plan = plan_in_mode(course, VP, PlanOptions("fast"), Rules((CORNER,)))
    x, y = dense(plan)[1][:, 0, 0], dense(plan)[1][:, 0, 1]
    assert not ((x < 3.6 - 1e-6) & (y > 0.3 + 1e-6)).any()
    assert x.max() <= 5.0 + 1e-6
    assert y.max() <= 5.0 + 1e-6


def test_waypoints_and_legs_outside_are_refused_by_name():
    with pytest.raises(InfeasibleSegment, match=r"item 2 is 3\.\d+ m outside the field; move it, or the fence"):
        plan_in_mode(points([(0, 0, 1), (3, 1, 1), (5, 5, 1)]), VP, PlanOptions("fast"), Rules((FIELD,)))
    with pytest.raises(InfeasibleSegment, match=r"item 1 is 0\.50 m inside the pond"):
        plan_in_mode(points([(0, 0, 1), (5, 1.5, 1), (9, 1, 1)]), VP, PlanOptions("fast"), Rules((POND,)))
    with pytest.raises(
        InfeasibleSegment, match=r"0 to item 1: .* crosses the pond, by 0\.40 m at [45]\.\d+ m north, 1\.00 m west"
    ):
        plan_in_mode(points([(0, 1, 1), (10, 1, 1)]), VP, PlanOptions("fast"), Rules((POND,)))


def test_paper_mode_cannot_bend_its_path_and_says_where_it_leaves_the_fence():
    narrow = Fence(True, ((-0.1, -0.1), (4.1, -0.1), (4.1, 4.1), (-0.1, 4.1)), "field")
    with pytest.raises(InfeasibleSegment, match=r"to item \d the path leaves the field by 0\.\d+ m at .* north, "):
        plan_in_mode(points(SQUARE), VP, PlanOptions("paper"), Rules((narrow,)))


# ---- given times, free positions, given derivatives


@VEHICLES
def test_given_times_of_arrival_are_met_to_the_microsecond(vehicle):
    course = points(ZIGZAG)
    course[2], course[5] = replace(course[2], time_s=4.0), replace(course[5], time_s=9.0)
    plan = plan_in_mode(course, vehicle, PlanOptions("fast"))
    assert plan.times_s[2] == pytest.approx(4.0, abs=1e-9)
    assert plan.times_s[5] == pytest.approx(9.0, abs=1e-9)
    assert plan.certified
    assert np.abs(plan.trajectory.at(plan.times_s)[:, :3] - ZIGZAG).max() < 1e-9
    limits, out = Limits.of(vehicle), dense(plan)[2]
    assert limits.rotor_min <= out.rotors.min() <= out.rotors.max() <= limits.rotor_max


def test_only_what_is_timed_is_slowed_down():
    course = points(ZIGZAG)
    course[2] = replace(course[2], time_s=6.0)
    plan = plan_in_mode(course, VP, PlanOptions("fast"))
    assert plan.times_s[2] == pytest.approx(6.0, abs=1e-9)
    assert plan.T - 6.0 < plan_in_mode(points(ZIGZAG), VP, PlanOptions("fast")).T


def test_times_that_cannot_be_met_are_named_with_what_is_missing():
    course = points(ZIGZAG)
    early = [*course[:3], replace(course[3], time_s=1.2), *course[4:]]
    with pytest.raises(
        InfeasibleSegment, match=r"item 3: arrival at 1\.2 s is \d\.\d+ s too early: .* needs \d\.\d+ s"
    ):
        plan_in_mode(early, VP, PlanOptions("fast"))
    hasty = [*course[:3], replace(course[3], time_s=0.3), *course[4:]]
    with pytest.raises(InfeasibleSegment, match=r"item 3: arrival at 0\.3 s needs .* m/s above the limit of 12 m/s"):
        plan_in_mode(hasty, VP, PlanOptions("fast"))
    back = [course[0], replace(course[1], time_s=3.0), replace(course[2], time_s=2.0), *course[3:]]
    with pytest.raises(MissionError, match=r"item 2: arrival at 2 s is not after 3 s, when item 1 is left"):
        plan_in_mode(back, VP, PlanOptions("fast"))


@pytest.mark.parametrize("mode", ["paper", "fast", "best"])
def test_a_free_position_is_found_by_the_planner_and_costs_no_time(mode):
    course = points([(0, 0, 1), (4, 3, 1), (8, 0, 1)])
    course[1] = replace(course[1], free=(False, True, False))
    plan = plan_in_mode(course, VP, PlanOptions(mode))
    straight = plan_in_mode(points([(0, 0, 1), (4, 0, 1), (8, 0, 1)]), VP, PlanOptions(mode))
    assert plan.trajectory.at(plan.times_s[1])[0, [0, 2]] == pytest.approx([4.0, 1.0], abs=1e-6)
    assert plan.waypoints[1].position == pytest.approx(plan.trajectory.at(plan.times_s[1])[0, :3])
    assert plan.T < 1.02 * straight.T


def test_a_free_place_to_be_at_a_given_velocity_is_found():
    course = points([(0, 0, 1), (4, 1, 1), (8, 0, 1)])
    course[1] = replace(course[1], free=(True, True, True), velocity=(2.0, 0.0, 0.5))
    plan = plan_in_mode(course, VP, PlanOptions("fast"))
    assert plan.trajectory.at(plan.times_s[1], 1)[0, :3] == pytest.approx([2.0, 0.0, 0.5], abs=1e-6)
    assert plan.certified


def test_the_position_of_a_hold_cannot_be_free():
    course = points([(0, 0, 1), (4, 3, 1), (8, 0, 1)])
    course[1] = replace(course[1], free=(True, True, True), hold_s=1.0)
    with pytest.raises(MissionError, match=r"item 1: the vehicle is at rest here .* cannot be free"):
        plan_in_mode(course, VP, PlanOptions("fast"))


@VEHICLES
def test_given_velocity_acceleration_jerk_and_snap_are_met(vehicle):
    course = points([(0, 0, 1), (3, 0, 1.5), (6, 1, 1)])
    asked = {"velocity": (2.0, 0.2, 0.0), "acceleration": (0.5, 1.0, -1.0), "jerk": (2.0, 0, 0), "snap": (0, 10.0, 0)}
    course[1] = replace(course[1], **asked)
    plan = plan_in_mode(course, vehicle, PlanOptions("fast"))
    for d, wanted in enumerate(asked.values(), start=1):
        assert plan.trajectory.at(plan.times_s[1], d)[0, :3] == pytest.approx(wanted, abs=1e-6)
    assert plan.certified


def test_an_acceleration_beyond_the_rotors_says_which_rotor_and_by_how_much():
    course = points([(0, 0, 1), (3, 0, 1.5), (6, 1, 1)])
    course[1] = replace(course[1], acceleration=(0.0, 0.0, 40.0))
    with pytest.raises(InfeasibleSegment, match=r"item [12]: .*rotor \d would be exceeded by \d+(\.\d+)? N"):
        plan_in_mode(course, VP, PlanOptions("fast"))


def test_the_example_of_everything_at_once_keeps_all_of_it():
    plan = preflight.plan(EXAMPLES / "inspection.toml", "mit-vp", mode="fast")
    _, d, out = dense(plan)
    x, y, z = d[:, 0, 0], d[:, 0, 1], d[:, 0, 2]
    assert plan.certified
    assert plan.times_s[2] == pytest.approx(8.0, abs=1e-9)
    assert not ((np.abs(x - 10) < 1 - 1e-6) & (np.abs(y) < 1 - 1e-6)).any()
    assert (np.abs(y) <= 9 + 1e-6).all()
    assert z.max() <= 9.0
    assert np.degrees(np.arccos(out.thrust_axis[:, 2])).max() <= 50.0 + 1e-6
    assert np.linalg.norm(d[:, 1, :3], axis=1).max() <= 6.0 + 1e-9
    assert plan.trajectory.at(plan.times_s[3], 1)[0, :3] == pytest.approx([-3.0, 0.0, 0.0], abs=1e-6)
    distance, ahead = np.hypot(10.0 - x, y), np.cos(d[:, 0, 3]) * (10.0 - x) - np.sin(d[:, 0, 3]) * y
    assert (ahead >= np.cos(np.radians(15.0)) * np.hypot(distance, 0.1) - 0.1 - 1e-9).all()  # the nose, docs/planner.md


# ---- whatever the mission


def planned_or_refused(waypoints, vehicle, options):
    try:
        return plan_in_mode(waypoints, vehicle, options), ""
    except HalfrollError as error:
        return None, str(error)


place = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(0.6, 5))


@settings(max_examples=8, derandomize=True)
@given(
    st.lists(place, min_size=2, max_size=5, unique=True),
    st.sampled_from([VP, FP]),
    st.fixed_dictionaries(
        {},
        optional={
            "tilt_deg": st.floats(5, 80),
            "ceiling_m": st.floats(2, 6),
            "speed_m_s": st.floats(0.2, 10),
            "rotor_rate_N_s": st.floats(2, 100),
            "body_rate_deg_s": st.floats(30, 600),
        },
    ),
    st.booleans(),
)
def test_random_missions_are_flown_inside_all_their_limits_or_refused_in_words(course, vehicle, changes, held):
    waypoints = points(course)
    waypoints[len(course) // 2] = replace(waypoints[len(course) // 2], hold_s=0.3 if held else 0.0)
    options = PlanOptions("fast", changes=tuple(changes.items()))
    plan, refusal = planned_or_refused(waypoints, vehicle, options)
    if plan is None:
        assert "item" in refusal
        return
    limits = changed(limits_of(vehicle), options.changes)
    _, d, out = dense(plan)
    upright = out.thrust_axis[:, 2]
    assert plan.certified
    assert np.abs(plan.trajectory.at(plan.times_s)[:, :3] - course).max() < 2e-3
    assert out.rotors.max() <= limits.rotor_max + 1e-9
    assert out.rotors.min() >= limits.rotor_min - 1e-9
    assert np.linalg.norm(d[:, 1, :3], axis=1).max() <= limits.speed_max + 1e-9
    if limits.ceiling is not None:
        assert d[:, 0, 2].max() <= limits.ceiling + 1.001e-3
    if limits.tilt_max is not None and not out.vertical.all():
        assert upright.min() >= np.cos(limits.tilt_max) - 1e-9


SYMMETRIES = {
    "mirrored": lambda p: p * [1, -1, 1],
    "turned about the vertical": lambda p: np.stack(
        [0.6 * p[:, 0] - 0.8 * p[:, 1], 0.8 * p[:, 0] + 0.6 * p[:, 1], p[:, 2]], axis=1
    ),
    "moved": lambda p: p + np.array([100, -50, 0]),
    "backwards": lambda p: p[::-1],
}


@pytest.mark.long
@pytest.mark.parametrize("name", SYMMETRIES)
@settings(max_examples=3, derandomize=True)
@given(place, place)
def test_the_time_of_a_leg_does_not_change_when_it_is_moved_or_flown_backwards(name, start, end):
    """Rotors without lag, for their limits read the same in both directions of time. The search ends within a percent
    or two of the optimum, not on it; on longer courses it may also end in another one."""
    limits = replace(limits_of(VP), drive=None)
    here = np.array([start, end])
    assume(np.linalg.norm(here[1] - here[0]) > 0.5)
    plan, other = (plan_near_optimal(points(p), VP, limits, "best") for p in (here, SYMMETRIES[name](here)))
    assert abs(other.T - plan.T) < 2e-2 * plan.T


@pytest.mark.long
@settings(max_examples=3, derandomize=True)
@given(
    st.lists(place, min_size=3, max_size=4, unique=True),
    st.sampled_from(
        [
            ("tilt_deg", 40.0),
            ("speed_m_s", 3.0),
            ("rotor_rate_N_s", 20.0),
            ("ceiling_m", 6.0),
            ("body_rate_deg_s", 150.0),
        ]
    ),
)
def test_a_plan_is_never_slower_when_a_limit_is_relaxed(course, limit):
    tight = plan_in_mode(points(course), VP, PlanOptions("best", changes=(limit,)))
    relaxed = plan_in_mode(points(course), VP, PlanOptions("best", changes=((limit[0], 1.5 * limit[1]),)))
    assert relaxed.T <= 1.005 * tight.T
