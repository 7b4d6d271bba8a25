"""Times and sizes, as ratios within one run where that is possible. Writes a list of {name, value, unit}.

Why: speed is a feature, and a feature without a number is a hope. Nothing here passes or fails.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from link_figures import instruction_figures, upload_figures
from page_figures import page_figures

from halfroll import _dialect, _firmware, _planner, preflight
from halfroll.errors import PlanError
from halfroll.manoeuvres.library import Backflip, Flip, HalfRoll, InvertedLeg, PowerLoop, SplitS
from halfroll.missions.mission import PlanOptions, Waypoint
from halfroll.planner.limits import Limits
from halfroll.planner.near_optimal import limits_of, plan_in_mode, plan_near_optimal
from halfroll.planner.plan import Plan, plan_course
from halfroll.planner.segments import node, rest, solve, solve_with_slopes
from halfroll.vehicle import GRAVITY, Vehicle, load_vehicle

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "sim"))
import course_d

from oracle import banded_polynomials

VEHICLES = (("mit-fp", "FP"), ("mit-vp", "VP"))
SHARED = Path(__file__).parents[3] / "shared" / "courses"


def seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """Best of a few runs: the machine's noise only ever adds."""
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best


def hovering(scenario: str) -> tuple[_firmware.Autopilot, _firmware.World]:
    """An autopilot that was armed and sent to 2.5 m by MAVLink, 10 s ago."""
    setup = _firmware.vehicle_setup("mit-vp")
    autopilot, world = _firmware.Autopilot(setup.vehicle, setup.params), _firmware.World(setup.plant, scenario, 1)
    gcs = _dialect.MAVLink(None, srcSystem=255, srcComponent=190)
    autopilot.fly(world, 1000)
    for command, p1 in ((_dialect.MAV_CMD_NAV_TAKEOFF, 0.0), (_dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)):
        height = 2.5 if command == _dialect.MAV_CMD_NAV_TAKEOFF else 0.0
        message = _dialect.MAVLink_command_long_message(1, 1, command, 0, p1, 0, 0, 0, 0, 0, height)
        autopilot.service(message.pack(gcs), link=1)
    autopilot.fly(world, 10000)
    assert world.p_WB[2] > 2.0, "the benchmark's vehicle did not take off"
    return autopilot, world


def loop_figures() -> list[dict[str, object]]:
    """One core, in its own time, the best of short runs: what it would be on a machine that does nothing else."""
    steps = 10000
    figures = []
    for scenario in ("ideal", "nominal", "full"):
        autopilot, world = hovering(scenario)
        loop = cpu_seconds(partial(autopilot.fly, world, steps), 25, time.thread_time)
        figures.append((f"closed_loop_{scenario}_x_realtime", steps * 1e-3 / loop, "x"))
    autopilot, world = hovering("ideal")
    gyro, accelerometer = np.array(world.gyro), np.array(world.accelerometer)
    imu, poses = recorded(autopilot.copy(), world.copy(), steps)
    firmware = cpu_seconds(lambda: autopilot.copy().step_many(imu, poses), 50, time.thread_time)
    estimator = cpu_seconds(lambda: _firmware.Estimator(autopilot.params).step_many(imu, poses), 50, time.thread_time)

    def single() -> None:
        for _ in range(2000):
            autopilot.step(gyro, accelerometer)

    figures.append(("firmware_step_ns", firmware / steps * 1e9, "ns"))
    figures.append(("firmware_step_without_estimator_ns", (firmware - estimator) / steps * 1e9, "ns"))
    figures.append(("estimator_step_ns", estimator / steps * 1e9, "ns"))
    batch = seconds(lambda: autopilot.copy().step_many(imu, poses))
    figures.append(("python_batch_step_ns", batch / steps * 1e9, "ns"))
    figures.append(("python_step_us", seconds(single) / 2000 * 1e6, "us"))
    figures.append(("batch_scaling_2_threads_x", batch_scaling(), "x"))
    return [{"name": name, "value": value, "unit": unit} for name, value, unit in figures]


def recorded(autopilot: _firmware.Autopilot, world: _firmware.World, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """What the sensors said in each millisecond of a flight whose poses are not late: (steps, 6) and (steps, 7)."""
    imu, poses = np.empty((steps, 6), dtype=np.float32), np.full((steps, 7), np.nan, dtype=np.float32)
    for k in range(steps):
        imu[k] = *world.gyro, *world.accelerometer
        if (pose := world.pose) is not None:
            poses[k] = *pose.p_WB, *pose.q_WB
        autopilot.fly(world, 1)
    return imu, poses


def batch_scaling(flights: int = 16, steps: int = 1000) -> float:
    """How much faster two threads fly a batch than one does; by turns, so that both see the same machine."""
    autopilot, world = hovering("full")
    autopilots, worlds = [autopilot.copy() for _ in range(flights)], [world.copy() for _ in range(flights)]
    best = {1: float("inf"), 2: float("inf")}
    for threads in (1, 2) * 25:
        work = partial(_firmware.World.run_batch, autopilots, worlds, steps, threads)
        best[threads] = min(best[threads], seconds(work, repeats=1))
    return best[1] / best[2]


def lockstep_figure() -> list[dict[str, object]]:
    """A plan flown through real MAVLink: vehicle time over wall clock, from its start to the hand-back."""
    from halfroll.flight import fly

    seen: dict[str, tuple[float, float]] = {}  # event -> vehicle time, wall clock
    mission = Path(__file__).parents[2] / "examples" / "first_flight.plan"
    with tempfile.TemporaryDirectory() as folder:
        fly(
            mission,
            seed=1,
            log_path=Path(folder) / "flight.ulg",
            report=lambda event: seen.setdefault(event.kind, (event.t_s, time.perf_counter())),
        )
    (t0, wall0), (t1, wall1) = seen["flying"], seen["handed-back"]
    return [{"name": "lockstep_mavlink_x_realtime", "value": (t1 - t0) / (wall1 - wall0), "unit": "x"}]


def closed_form_figures() -> list[dict[str, object]]:
    """The kernel, the numpy form that is its oracle in the tests, and slopes; bytes of the eliminated equations. Of the
    three sizes, how much longer a node takes in the slowest than in the quickest, in the kernel alone."""
    rng = np.random.default_rng(1)
    figures: list[dict[str, object]] = []
    a_node: list[float] = []
    for n in (100, 1000, 10000):
        nodes = np.stack([rest(p) if k in (0, n - 1) else node(p) for k, p in enumerate(rng.uniform(-5, 5, (n, 4)))])
        durations = rng.uniform(0.5, 1.5, n - 1)
        path, slopes = solve_with_slopes(nodes, durations)
        repeats = max(20, 200000 // n)
        for name, work in (
            ("", lambda a=nodes, b=durations: solve(a, b)),
            ("_numpy", lambda a=nodes, b=durations: banded_polynomials.solve(a, b)),
            ("_slopes", lambda s=slopes, c=path.coefficients: s(c)),
        ):
            figures.append(
                {
                    "name": f"closed_form{name}_{n}_ms",
                    "value": 1e3 * cpu_seconds(work, repeats, time.thread_time),
                    "unit": "ms",
                }
            )
        kernel = partial(_planner.ClosedForm, nodes, durations)
        a_node.append(cpu_seconds(kernel, repeats, time.thread_time) / n)
        size = kernel().bytes
        figures.append({"name": f"closed_form_{n}_bytes_a_node", "value": size / n, "unit": "B"})
    figures.append(
        {"name": "closed_form_a_node_slowest_over_quickest", "value": max(a_node) / min(a_node), "unit": "x"}
    )
    return figures


def plan_figures() -> list[dict[str, object]]:
    """Times against the best known ones of the full optimal-control problem, where those are at hand."""
    if not SHARED.is_dir():
        return []
    courses = json.loads((SHARED / "courses.json").read_text())["courses"]
    best = json.loads((SHARED / "reference.json").read_text())["courses"]
    figures: list[dict[str, object]] = []
    for course, (name, column), mode in itertools.product(courses, VEHICLES, ("paper", "fast", "best")):
        waypoints = [Waypoint(position=tuple(p)) for p in course["waypoints"]]
        vehicle, key = load_vehicle(name), f"plan_{course['name']}_{name}_{mode}"
        try:
            plan = planned(waypoints, vehicle, mode)
        except PlanError as error:
            print(f"{key}: {error}", file=sys.stderr)
            continue
        solve_s = cpu_seconds(partial(planned, waypoints, vehicle, mode), 1 if mode == "paper" else 3)
        figures.append({"name": f"{key}_T_s", "value": plan.T, "unit": "s"})
        if course["name"] in best:
            figures.append({"name": f"{key}_ratio", "value": plan.T / best[course["name"]][column]["T"], "unit": ""})
        figures.append({"name": f"{key}_solve_s", "value": solve_s, "unit": "s"})
    return figures


def manoeuvre_figures() -> list[dict[str, object]]:
    """What mode best saves where the vehicle turns over, and in the mission that mixes such with a survey."""
    start, vehicle = Waypoint((0.0, 0.0, 8.0)), load_vehicle("mit-vp")
    kinds = (HalfRoll, Flip, Backflip, SplitS, PowerLoop, InvertedLeg)
    names = ("half_roll", "flip", "backflip", "split_s", "power_loop", "inverted_leg")
    mission = Path(__file__).parents[2] / "examples" / "aerobatics.toml"
    figures: list[dict[str, object]] = []
    for mode in ("paper", "best"):
        for kind, name in zip(kinds, names, strict=True):
            flown = kind(at=0, kind=name).waypoints(start)
            T = plan_in_mode((start, *flown), vehicle, PlanOptions(mode=mode)).T
            figures.append({"name": f"manoeuvre_{name}_{mode}_T_s", "value": T, "unit": "s"})
        T = preflight.plan(mission, mode=mode).T
        figures.append({"name": f"mission_aerobatics_{mode}_T_s", "value": T, "unit": "s"})
    return figures


def proof_figures() -> list[dict[str, object]]:
    """A thousand random points, and what the certificate alone takes there and on a zigzag."""
    vehicle = load_vehicle("mit-fp")
    figures: list[dict[str, object]] = []
    rng = np.random.default_rng(1)
    thousand = [tuple(p) for p in rng.uniform((-5.0, -5.0, 0.5), (5.0, 5.0, 3.5), (1000, 3)).tolist()]
    zigzag = [(0, 0, 1), (2, 1, 2), (4, -1, 1), (6, 1, 2.5), (8, -1, 1), (10, 0, 1.5)]
    for name, points, mode in (("thousand", thousand, "fast"), ("zigzag", zigzag, "best")):
        waypoints = [Waypoint(position=p) for p in points]
        start = time.process_time()
        plan = planned(waypoints, vehicle, mode)
        solve_s = time.process_time() - start
        path = plan.trajectory
        no_limit = [_planner.PieceLimits()] * len(path.durations)
        proof = partial(_planner.certify, path.coefficients, path.durations, no_limit, rotors_alone(vehicle))
        proof_s = cpu_seconds(proof, 5)
        if name == "thousand":
            figures.append({"name": "plan_thousand_s_a_leg", "value": plan.T / (len(points) - 1), "unit": "s"})
            figures.append({"name": "plan_thousand_solve_s", "value": solve_s, "unit": "s"})
        figures.append({"name": f"certificate_{name}_ms", "value": 1e3 * proof_s, "unit": "ms"})
    return figures


def weak_rotor_figures(seeds: int = 50) -> list[dict[str, object]]:
    """Flights of the zigzag that arrive in Dryden wind with one rotor at 85 %, by mode and margin of the plan."""
    figures: list[dict[str, object]] = []
    for mode, margin in (("paper", 0.1), ("fast", 0.1), ("fast", 0.15), ("fast", 0.2)):
        flown = course_d.campaign("mit-vp", mode, "windy", course_d.WINDY_AND_WEAK, seeds, margin)
        share = 100.0 * sum(one.complete for one in flown) / seeds
        figures.append({"name": f"weak_rotor_{mode}_margin_{margin:.0%}_complete", "value": share, "unit": "%"})
    return figures


def rotors_alone(vehicle: Vehicle) -> _planner.Constraints:
    body = _planner.Vehicle(
        mass=vehicle.mass_kg,
        inertia=list(vehicle.inertia_kg_m2),
        arm=vehicle.arm_m,
        yaw_coefficient=vehicle.yaw_coefficient_m,
        gravity=GRAVITY,
    )
    limits = limits_of(vehicle, "rotors", 0.0)
    return _planner.Constraints(body, _planner.Limits(rotor_min=limits.rotor_min, rotor_max=limits.rotor_max), False)


def cpu_seconds(work: Callable[[], object], repeats: int, clock: Callable[[], float] = time.process_time) -> float:
    """Of one core, best of a few runs: other programs of the machine do not count; with time.thread_time, neither do
    numpy's threads that wait for work."""
    best = float("inf")
    for _ in range(repeats):
        start = clock()
        work()
        best = min(best, clock() - start)
    return best


def planned(waypoints: list[Waypoint], vehicle: Vehicle, mode: str) -> Plan:
    if mode == "paper":
        return plan_course(waypoints, vehicle, Limits.of(vehicle, "rotors", 0.0))
    return plan_near_optimal(
        waypoints, vehicle, limits_of(vehicle, "rotors", 0.0), "best" if mode == "best" else "fast"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("build/bench.json"))
    output = parser.parse_args().output
    figures: list[dict[str, object]] = []
    parts = (
        loop_figures,
        lockstep_figure,
        instruction_figures,
        upload_figures,
        closed_form_figures,
        plan_figures,
        manoeuvre_figures,
        proof_figures,
        weak_rotor_figures,
        page_figures,
    )
    for part in parts:
        for figure in part():
            print(f"{figure['name']:40s} {figure['value']:12.4g} {figure['unit']}", flush=True)
            figures.append(figure)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
