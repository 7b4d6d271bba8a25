"""What can be known before flying: what a mission asks for, what is not supported, and its plan.

Why: the arrows Mission → Course → Plan in one place, for Python users and the command line alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from halfroll.errors import HalfrollError, InputError, MissionError
from halfroll.missions.geodesy import DEFAULT_ORIGIN
from halfroll.missions.mission import LimitsKind, Mission, PlanMode, PlanOptions
from halfroll.missions.mission_check import Finding, check_items
from halfroll.missions.mission_files import load_mission
from halfroll.planner.course import Course, course, endless, home_of, require_an_end, with_takeoff_and_landing
from halfroll.vehicle import Vehicle, built_vehicle

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan

Overrides = Mapping[str, str | float]
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Preflight:
    """What `check` found. There is no plan when items stand in its way (`refusals`), when none is needed, or when none
    is possible (`no_plan` says why).
    """

    mission: Mission
    vehicle: Vehicle
    added: tuple[str, ...]  # what `fly` adds to the mission, a sentence each
    findings: tuple[Finding, ...]
    course: Course | None
    plan: Plan | None
    no_plan: HalfrollError | None
    never_ends: MissionError | None = None

    @property
    def refusals(self) -> tuple[Finding, ...]:
        return tuple(finding for finding in self.findings if finding.is_error)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is not flown as the file says."""
        return (*self.mission.warnings, *(str(note) for note in (self.course.notes if self.course else ())))

    @property
    def supported(self) -> bool:
        return not self.refusals

    @property
    def error(self) -> HalfrollError | None:
        """Why `fly` would not fly it."""
        if self.refusals:
            first, more = self.refusals[0], len(self.refusals) - 1
            return MissionError(f"{first}{f' (and {more} more)' if more else ''}", first.index)
        return self.never_ends or self.no_plan


def planning_mode(name: str) -> PlanMode:
    """Raises InputError for a name that is none."""
    modes: dict[str, PlanMode] = {mode: mode for mode in get_args(PlanMode)}
    if name not in modes:
        raise InputError(f"mode {name!r} is not known; give one of {', '.join(modes)}")
    return modes[name]


def plan(
    mission: Mission | str | Path,
    vehicle: Vehicle | str | Path = "mit-vp",
    *,
    mode: str = "paper",
    limits: LimitsKind = "mission",
    margin: float | None = None,
    changes: Mapping[str, float | None] | None = None,
    yaw: str | None = None,
    overrides: Overrides | None = None,
    progress: Progress = lambda _: None,
) -> Plan:
    """The shortest certified flight found through a mission, from its first to its last point.

    mode: "paper" (one polynomial a leg), "fast" or "best" (near the optimum, proven). limits: "mission" (all) or
    "rotors" (rotor thrust alone); margin: share of the rotors' thrust that is kept free, None for the limits' own;
    changes: limits by name (limits.SETTABLE), None switches one off; yaw: "free" (the fastest), "given", "path" or
    "NORTH,WEST" of a point to look at; overrides: numbers of the vehicle by dotted key. Raises InputError and
    PlanError.
    """
    options = PlanOptions.of(planning_mode(mode), limits, margin, changes, yaw)
    mission, vehicle = _mission(mission), built_vehicle(vehicle, overrides)
    flown = course(mission, mission.planned_home or DEFAULT_ORIGIN)
    if len(flown.waypoints) < 2:
        raise MissionError("nothing to plan: it ends before it has two different positions; add a waypoint")
    return _plan(flown, vehicle, options, progress)


def check(
    mission: Mission | str | Path,
    vehicle: Vehicle | str | Path = "mit-vp",
    *,
    mode: str = "paper",
    limits: LimitsKind = "mission",
    margin: float | None = None,
    changes: Mapping[str, float | None] | None = None,
    yaw: str | None = None,
    overrides: Overrides | None = None,
    progress: Progress = lambda _: None,
) -> Preflight:
    """Everything about a mission that a person should know before `fly`; the vehicle stands where `fly` puts it.

    Raises InputError only for what cannot be read at all.
    """
    mission, vehicle = _mission(mission), built_vehicle(vehicle, overrides)
    options = PlanOptions.of(planning_mode(mode), limits, margin, changes, yaw)
    complete, added = with_takeoff_and_landing(mission)
    origin = home_of(mission)
    findings = tuple(check_items(complete.items, origin))
    flown, planned, no_plan = None, None, None
    if not any(finding.is_error for finding in findings):
        try:
            flown = course(complete, origin)
            if len(flown.waypoints) >= 2:
                planned = _plan(flown, vehicle, options, progress)
        except HalfrollError as error:
            no_plan = error
    never_ends = None if any(finding.is_error for finding in findings) else endless(complete.items)
    return Preflight(complete, vehicle, tuple(added), findings, flown, planned, no_plan, never_ends)


def _mission(mission: Mission | str | Path) -> Mission:
    return mission if isinstance(mission, Mission) else load_mission(mission)


def _plan(flown: Course, vehicle: Vehicle, options: PlanOptions, progress: Progress) -> Plan:
    require_an_end(flown.waypoints, vehicle.speed_max_m_s if options.limits == "mission" else None)
    from halfroll.planner.near_optimal import plan_in_mode

    return plan_in_mode(flown.waypoints, vehicle, options, flown.rules, progress, flown.demands)
