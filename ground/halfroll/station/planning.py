"""Planning beside flying: from stored items to a certified plan, in a process of its own.

Why: a plan takes seconds of a whole core, while references must go out every 10 ms. The worker never hears Ctrl-C
(its parent decides), is ended by a newer request, and ends with its parent, however that ends.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Protocol

from halfroll.errors import HalfrollError, LinkError, MissionError, PlanError
from halfroll.missions.geodesy import GeoPoint, Vector
from halfroll.missions.mission import DEFAULT_OPTIONS, NO_RULES, Mission, MissionItem, PlanOptions, Rules, Waypoint
from halfroll.missions.mission_check import Severity, check_items
from halfroll.planner.course import Course, flown_waypoints, require_an_end
from halfroll.planner.course import course as course_of
from halfroll.station.references import Path, path_of
from halfroll.vehicle import Vehicle

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan

Progress = Callable[[str], None]


@dataclass(frozen=True)
class PlanRequest:
    """Everything a plan depends on; equal requests give equal plans. home: where it is armed; start_yaw [rad] in W.

    waypoints and rules: the mission's own, from home, where they say more than its items. from_item and start (hovering
    there, W) ask for the rest of a mission only, by its items.
    """

    items: tuple[MissionItem, ...]
    origin: GeoPoint
    home: GeoPoint
    takeoff_altitude: float
    start_yaw: float
    vehicle: Vehicle
    options: PlanOptions = DEFAULT_OPTIONS
    waypoints: tuple[Waypoint, ...] | None = None
    rules: Rules = NO_RULES
    from_item: int | None = None
    start: Vector | None = None


@dataclass(frozen=True)
class Planned:
    course: Course
    plan: Plan
    path: Path  # the plan's table


@dataclass(frozen=True)
class NothingToPlan:
    """Fewer than two waypoints: the autopilot flies such a mission alone."""

    course: Course


Outcome = Planned | NothingToPlan


class Planner(Protocol):
    """Plans one request at a time without being waited for."""

    def submit(self, request: PlanRequest) -> None: ...

    def poll(self) -> Outcome | HalfrollError | None:
        """The outcome of the last request, once; None while there is none."""
        ...

    def progress(self) -> str | None:
        """The latest word from the planner since it was last asked."""
        ...


def plan_mission(request: PlanRequest, progress: Progress = lambda _: None) -> Outcome:
    """Check the items, walk them, plan what has to be planned. Raises MissionError or PlanError naming the item."""
    for finding in check_items(request.items, request.home):
        if finding.severity is not Severity.NOTE:
            raise MissionError(f"mission item {finding.index}: {finding.why}", finding.index)
    course = _course(request)
    if len(course.waypoints) < 2:
        return NothingToPlan(course)
    limited = request.options.limits == "mission"
    require_an_end(course.waypoints, request.vehicle.speed_max_m_s if limited else None)
    plan = _planned(course, request, progress)
    return Planned(course, plan, path_of(plan))


def _planned(course: Course, request: PlanRequest, progress: Progress) -> Plan:
    from halfroll.planner.near_optimal import plan_in_mode

    rules = request.rules.in_world(request.origin, request.home)
    return plan_in_mode(course.waypoints, request.vehicle, request.options, rules, progress, course.demands)


def _course(request: PlanRequest) -> Course:
    where = (request.origin, request.home, request.takeoff_altitude, request.start_yaw)
    if request.waypoints and request.start is None:
        return course_of(Mission("stored", request.items, waypoints=request.waypoints), *where)
    return flown_waypoints(request.items, *where, from_item=request.from_item, start=request.start)


class PlanningProcess:
    """A Planner in one worker process. Close it, or use it as a context."""

    def __init__(self) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._busy, self._latest = False, ""
        self._outcome: Outcome | HalfrollError | None = None
        self._start()

    def _start(self) -> None:
        self._connection, theirs = self._context.Pipe()
        self._worker = self._context.Process(target=_work, args=(theirs,), daemon=True)
        with _deaf_to_ctrl_c():
            self._worker.start()
        theirs.close()

    def _end(self) -> None:
        self._worker.kill()  # it holds nothing that needs an orderly end
        self._worker.join()
        self._connection.close()

    def submit(self, request: PlanRequest) -> None:
        """A request that is still being planned is dropped: only the newest one counts."""
        if self._busy or not self._worker.is_alive():
            self._end()
            self._start()
        self._busy, self._latest, self._outcome = True, "", None
        with contextlib.suppress(ConnectionError):  # it was ended just now; poll says so
            self._connection.send(request)

    def poll(self) -> Outcome | HalfrollError | None:
        self._read()
        outcome, self._outcome = self._outcome, None
        return outcome

    def progress(self) -> str | None:
        self._read()
        latest, self._latest = self._latest, ""
        return latest or None

    def _read(self) -> None:
        try:
            while self._busy and self._connection.poll():
                said = self._connection.recv()
                if isinstance(said, str):
                    self._latest = said
                else:
                    self._busy, self._outcome = False, said
        except (EOFError, ConnectionError):
            self._busy = False
            self._outcome = LinkError("the planner's process was ended from outside; is the machine out of memory?")

    def close(self) -> None:
        """Ends the worker now, whatever it is doing."""
        self._end()

    def __enter__(self) -> PlanningProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class ReadyPlan:
    """A Planner whose plan was made before: every request is answered by it."""

    def __init__(self, planned: Planned) -> None:
        self._planned, self._asked = planned, False

    def submit(self, request: PlanRequest) -> None:
        self._asked = True

    def poll(self) -> Outcome | None:
        asked, self._asked = self._asked, False
        return self._planned if asked else None

    def progress(self) -> str | None:
        return None

    def __enter__(self) -> ReadyPlan:
        return self

    def __exit__(self, *_: object) -> None:
        pass


@contextlib.contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """What is started meanwhile never hears Ctrl-C, not even while Python itself starts; here it comes afterwards."""
    resource_tracker.ensure_running()  # else it is started on the way and lets Ctrl-C in again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _work(connection: Connection) -> None:
    """The worker: a request comes, what is said on the way and the outcome go back."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with contextlib.suppress(ImportError):  # now, what the first plan needs
        import halfroll.planner.plan  # noqa: F401
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            request = connection.recv()
            connection.send(outcome_of(request, connection.send))


def outcome_of(request: PlanRequest, progress: Progress = lambda _: None) -> Outcome | HalfrollError:
    """plan_mission's, with whatever it raises as an error for people."""
    try:
        return plan_mission(request, progress)
    except HalfrollError as error:
        return error
    except MemoryError:
        return PlanError("the plan does not fit into memory; split the mission, or shorten its holds and legs")
    except Exception as error:
        return PlanError(f"the planner failed ({type(error).__name__}: {error}); simplify the mission, and report this")


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)
