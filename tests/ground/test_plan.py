"""Plans in the paper's form: the paper's times, checked limits, waypoints met, files that read back bit for bit."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfroll.errors import InfeasibleSegment, InputError, MissionError
from halfroll.missions.mission import Waypoint
from halfroll.planner.limits import Limits, margins
from halfroll.planner.plan import COLUMNS, Plan, plan_course
from halfroll.vehicle import load_vehicle
from oracle import rigid_body

VP, FP = load_vehicle("mit-vp"), load_vehicle("mit-fp")
SQUARE = [(0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1), (0, 0, 1)]
ZIGZAG = [(0, 0, 1), (2, 1, 2), (4, -1, 1), (6, 1, 2.5), (8, -1, 1), (10, 0, 1.5)]


def points(positions, **everywhere):
    return tuple(Waypoint(tuple(map(float, p)), item=i, **everywhere) for i, p in enumerate(positions))


def rotors_alone(positions, vehicle):
    return plan_course(points(positions), vehicle, Limits.of(vehicle, "rotors"))


@cache
def turning():
    """Three legs with yaw and a hold, mission limits."""
    course = [
        Waypoint((0.0, 0.0, 1.0)),
        Waypoint((2.0, 1.0, 1.5), yaw=1.0),
        Waypoint((4.0, 0.0, 1.0), yaw=1.5, hold_s=0.5),
        Waypoint((4.0, 3.0, 1.0), yaw=2.0),
    ]
    return plan_course(course, VP)


@pytest.mark.parametrize(("vehicle", "T"), [(VP, 0.9145), (FP, 1.0344)])
def test_one_metre_up_takes_the_time_of_the_closed_form(vehicle, T):
    assert pytest.approx(T, rel=1e-4) == rotors_alone([(0, 0, 1), (0, 0, 2)], vehicle).T


@pytest.mark.parametrize(("vehicle", "T"), [(VP, 0.6666), (FP, 0.8952)])
def test_the_paper_s_three_vertical_legs(vehicle, T):
    plan = rotors_alone([(0, 0, 1), (0, 0, 1.25), (0, 0, 1.9), (0, 0, 2)], vehicle)
    assert pytest.approx(T, rel=5e-3) == plan.T
    z = plan.sample()["z_m"]
    assert z.min() > 1.0 - 1e-9
    assert z.max() < 2.0 + 1e-9


@pytest.mark.parametrize(("course", "T"), [(SQUARE, 4.2593), (ZIGZAG, 5.3925), ([(0, 0, 1), (10, 0, 1)], 2.2725)])
def test_known_courses_stay_as_fast_as_they_were(course, T):
    assert pytest.approx(T, rel=2e-3) == rotors_alone(course, FP).T


@settings(max_examples=4, derandomize=True)
@given(seed=st.integers(0, 2**31), n=st.integers(3, 5))
def test_variable_pitch_is_never_slower_than_fixed(seed, n):
    course = np.random.default_rng(seed).uniform((-4, -4, 1), (4, 4, 4), (n, 3))
    assert rotors_alone(course, VP).T <= rotors_alone(course, FP).T


@pytest.mark.parametrize("vehicle", [VP, FP, load_vehicle("race-5in")], ids=lambda v: v.name)
def test_a_plan_keeps_every_limit_between_its_samples_too(vehicle):
    plan, limits = plan_course(points(ZIGZAG), vehicle), Limits.of(vehicle)
    assert plan.certified
    assert plan.violation_N == 0.0
    found = margins(plan.trajectory, vehicle, limits, samples_per_segment=7919)
    assert found.worst.relative > -1e-9
    assert min(plan.rotor_min) >= limits.rotor_min
    assert max(plan.rotor_max) <= limits.rotor_max
    assert found.worst.relative < 1e-3, "some limit is used up"


def test_waypoints_are_met_at_their_times_with_smooth_derivatives():
    plan = plan_course(points(ZIGZAG), VP)
    assert plan.at(np.array(plan.times_s)).position == pytest.approx(np.array(ZIGZAG), abs=1e-9)
    inner, h = np.array(plan.times_s[1:-1]), 1e-9
    before, after = (plan.trajectory.derivatives(inner + side, 9) for side in (-h, h))
    scale = np.abs(after).max(axis=(0, 2)) + 1.0
    assert np.abs(before - after).max(axis=(0, 2)) / scale == pytest.approx(0.0, abs=1e-5)  # 2 ns of the 9th derivative


def test_it_starts_and_ends_at_rest():
    plan = turning()
    for t in (-1.0, 0.0, plan.T, plan.T + 1.0):
        now = plan.at(t)
        for rate in (now.velocity, now.acceleration, now.jerk, now.snap, now.yaw_rate):
            assert rate == pytest.approx(0.0, abs=1e-6)


def test_a_hold_waits_where_it_stands():
    plan = turning()
    arrival = plan.times_s[2]
    t = np.linspace(arrival, arrival + 0.5, 20)
    assert plan.at(t).position == pytest.approx(np.tile([4.0, 0.0, 1.0], (20, 1)), abs=1e-9)
    assert np.linalg.norm(plan.at(arrival + 0.8).velocity) > 0.1


def test_its_rotor_thrusts_fly_it_open_loop():
    plan = turning()
    o = plan.outputs(plan.trajectory.times)
    start = np.concatenate([plan.at(0.0).position, np.zeros(3), o.q_WD[0], np.zeros(3)])
    positions, attitudes = rigid_body.fly_open_loop(
        lambda t: plan.outputs(np.array([t])).rotors[0],
        plan.trajectory.times,
        start,
        mass=VP.mass_kg,
        inertia=VP.inertia_kg_m2,
        arm=VP.arm_m,
        yaw_coefficient=VP.yaw_coefficient_m,
    )
    assert positions == pytest.approx(plan.trajectory.at(plan.trajectory.times)[:, :3], abs=1e-6)
    assert np.abs((attitudes * o.q_WD).sum(axis=1)) == pytest.approx(1.0, abs=1e-9)


def test_one_time_and_many_times_give_the_same_point():
    plan = turning()
    t = np.linspace(0.0, plan.T, 37)
    many = plan.at(t)
    for k, now in enumerate(map(plan.at, t.tolist())):
        for name in ("position", "velocity", "acceleration", "jerk", "snap", "yaw", "yaw_rate", "yaw_acceleration"):
            assert getattr(now, name) == pytest.approx(getattr(many, name)[k], abs=1e-6), name
        assert now.sigma == many.sigma[k] == 1.0


def test_samples_have_the_columns_of_the_csv_and_rest_at_both_ends():
    plan = turning()
    columns = plan.sample(1000.0)
    assert tuple(columns) == COLUMNS
    assert (
        ",".join(COLUMNS) == "t_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,ax_m_s2,ay_m_s2,az_m_s2,jx_m_s3,jy_m_s3,jz_m_s3,"
        "sx_m_s4,sy_m_s4,sz_m_s4,yaw_rad,yaw_rate_rad_s,yaw_acc_rad_s2,sigma,thrust_N,q_w,q_x,q_y,q_z,"
        "f1_N,f2_N,f3_N,f4_N"
    )
    assert columns["t_s"][[0, 1, -1]] == pytest.approx([0.0, 0.001, plan.T])
    for name in ("vx_m_s", "ay_m_s2", "sz_m_s4", "yaw_rate_rad_s"):
        assert columns[name][[0, -1]] == pytest.approx(0.0, abs=1e-6), name
    four = sum(columns[f"f{i}_N"] for i in (1, 2, 3, 4))
    assert four == pytest.approx(columns["thrust_N"])


@pytest.mark.parametrize("rate_hz", [0.0, -100.0, float("nan"), float("inf")])
def test_samples_at_a_rate_that_is_none_are_refused(rate_hz):
    with pytest.raises(InputError, match="more than 0 Hz"):
        turning().sample(rate_hz)


def test_the_table_of_body_rates_reaches_the_end():
    plan = turning()
    table = plan.rates_table(0.01)
    assert table.shape == (int(np.ceil(plan.T / 0.01)) + 1, 3)
    assert table[-1] == pytest.approx(0.0, abs=1e-9)
    assert table[50] == pytest.approx(plan.rates(0.5)[0], abs=1e-9)


@pytest.mark.parametrize("suffix", [".npz", ".json"])
def test_a_saved_plan_reads_back_bit_for_bit(tmp_path, suffix):
    plan, file = turning(), tmp_path / f"plan{suffix}"
    plan.save(file)
    again = Plan.load(file)
    assert again.trajectory.times.tobytes() == plan.trajectory.times.tobytes()
    assert again.trajectory.coefficients.tobytes() == plan.trajectory.coefficients.tobytes()
    assert replace(again, trajectory=plan.trajectory) == plan


def test_the_json_has_the_documented_keys(tmp_path):
    turning().save(tmp_path / "plan.json")
    stored = json.loads((tmp_path / "plan.json").read_text())
    keys = {"vehicle", "mode", "waypoints", "T_s", "times_s", "rotor_min_N", "rotor_max_N", "certified", "violation_N"}
    assert keys <= set(stored)
    assert (stored["vehicle"], stored["mode"], stored["certified"]) == ("mit-vp", "paper", True)


def test_the_csv_has_a_row_per_millisecond(tmp_path):
    plan = turning()
    plan.save(tmp_path / "plan.csv")
    lines = (tmp_path / "plan.csv").read_text().splitlines()
    assert lines[0] == ",".join(COLUMNS)
    assert len(lines) == int(np.ceil(plan.T * 1000)) + 2


def test_files_that_are_no_plans_are_refused(tmp_path):
    (tmp_path / "no.json").write_text('{"vehicle": "mit-vp"}')
    (tmp_path / "broken.json").write_text("{")
    for name, says in [("no.json", "not a plan"), ("broken.json", "not a plan"), ("none.npz", "No such file")]:
        with pytest.raises(InputError, match=says):
            Plan.load(tmp_path / name)
    with pytest.raises(InputError, match="choose one of these endings"):
        turning().save(tmp_path / "plan.xml")


def test_a_speed_limit_applies_to_its_own_leg():
    course = [Waypoint((0.0, 0.0, 1.0)), Waypoint((4.0, 0.0, 1.0), speed_max=1.0), Waypoint((8.0, 2.0, 1.0))]
    plan = plan_course(course, VP)
    t = np.linspace(0.0, plan.T, 4000)
    speed = np.linalg.norm(plan.at(t).velocity, axis=1)
    assert speed[t >= plan.times_s[1]].max() == pytest.approx(1.0, abs=1e-3)
    assert plan.T > 2.0 * plan_course([replace(point, speed_max=None) for point in course], VP).T


def test_given_derivatives_are_met():
    course = [
        Waypoint((0, 0, 1)),
        Waypoint((3, 0, 1.5), velocity=(3, 0, 0), acceleration=(0, 0, -3)),
        Waypoint((6, 2, 1)),
    ]
    plan = plan_course(course, VP)
    now = plan.at(plan.times_s[1])
    assert plan.certified
    assert now.velocity == pytest.approx([3, 0, 0], abs=1e-9)
    assert now.acceleration == pytest.approx([0, 0, -3], abs=1e-9)


def test_the_short_way_round_is_turned():
    plan = plan_course([Waypoint((0, 0, 1), yaw=3.0), Waypoint((3, 0, 1), yaw=-3.0)], VP)
    assert plan.at(plan.T).yaw == pytest.approx(2 * np.pi - 3.0)


def test_a_turn_on_the_spot_is_flown_at_rest():
    plan = plan_course([Waypoint((0, 0, 1)), Waypoint((0, 0, 1), yaw=1.5), Waypoint((3, 0, 1), yaw=1.5)], VP)
    t = np.linspace(0.0, plan.times_s[1], 20)
    assert plan.at(t).position == pytest.approx(np.tile([0, 0, 1], (20, 1)), abs=1e-9)
    assert plan.at(plan.times_s[1]).yaw == pytest.approx(1.5)


def test_repeated_waypoints_are_one_and_their_holds_add_up():
    course = [
        Waypoint((0, 0, 1)),
        Waypoint((3, 0, 1), hold_s=0.25),
        Waypoint((3, 0, 1), hold_s=0.25),
        Waypoint((3, 3, 1)),
    ]
    plan = plan_course(course, VP)
    assert len(plan.times_s) == 4
    assert plan.times_s[1] == plan.times_s[2]
    assert plan.trajectory.durations[1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("course", "error", "says", "item"),
    [
        (points([(0, 0, 1), (0, 0, 1)]), MissionError, "two different waypoints", 0),
        (points([(0, 0, 1), (0, 0, 0.2)]), InfeasibleSegment, "item 1: height 0.20 m is below the floor of 0.5 m", 1),
        (
            (Waypoint((0, 0, 1), velocity=(1, 0, 0), item=7), Waypoint((3, 0, 1))),
            MissionError,
            "item 7.*at rest here",
            7,
        ),
        (
            (Waypoint((0, 0, 1)), Waypoint((3, 0, 1), velocity=(30, 0, 0), item=4), Waypoint((6, 0, 1))),
            InfeasibleSegment,
            "item 4: speed of 30.00 m/s",
            4,
        ),
    ],
)
def test_what_cannot_be_flown_is_refused_by_item(course, error, says, item):
    with pytest.raises(error, match=says) as caught:
        plan_course(course, VP)
    assert caught.value.item == item


def test_rotors_too_weak_for_the_margin_are_named():
    weak = load_vehicle("mit-fp", {"rotor.thrust_max_N": 1.5})  # hovers at 1.40 N, but 10 % margin leaves 1.35 N
    with pytest.raises(InfeasibleSegment, match=r"rotor \d would need 1.40 N where 1.35 N is allowed"):
        plan_course(points([(0, 0, 1), (3, 0, 1)]), weak)


def test_a_path_that_swings_far_out_is_warned_about_with_the_leg_named():
    course = points([(0, 0, 2), (0.5, 0, 2), (0.4, 0.2, 2), (0.2, 0.3, 2)])
    fast = (course[0], replace(course[1], velocity=(5.0, 0.0, 0.0)), *course[2:])
    assert plan_course(course, VP).warnings == ()
    (warning,) = plan_course(fast, VP).warnings
    assert "from item 1 to item 2 the path swings out" in warning


def test_a_plan_says_sigma_of_each_piece_and_draws_itself():
    plan = turning()
    assert plan.piece_sigma.tolist() == [1.0] * len(plan.trajectory.durations)
    labels = [axes.get_ylabel() for axes in plan.plot().axes]
    assert labels == ["west [m]", "speed [m/s]", "tilt [°]", "rotor thrust [N]"]


def test_progress_is_told_in_words():
    said = []
    plan_course(points(SQUARE), VP, progress=said.append)
    assert said
    assert "item 0 to item 4" in said[-1]
