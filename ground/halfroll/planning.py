"""Planning beside flying: from stored items to a certified plan, in a process of its own.

Why: a plan takes seconds of a whole core, while references must go out every 10 ms. The worker is spawned once, ignores
Ctrl-C (its parent decides) and ends with its parent, however that ends.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

from halfroll.course import Course, flown_waypoints
from halfroll.course import course as course_of
from halfroll.errors import HalfrollError, LinkError, MissionError
from halfroll.geodesy import GeoPoint, Vector
from halfroll.mission import Mission, MissionItem, Waypoint
from halfroll.mission_check import Severity, check_items
from halfroll.references import Path, path_of
from halfroll.vehicle import Vehicle

if TYPE_CHECKING:
    from halfroll.plan import Plan

Progress = Callable[[str], None]
Limits = Literal["mission", "rotors"]


@dataclass(frozen=True)
class PlanRequest:
    """Everything a plan depends on; equal requests give equal plans. home: where it is armed; start_yaw [rad] in W.

    waypoints: the mission's own, from home, where they say more than its items. from_item and start (hovering there, W)
    ask for the rest of a mission only, by its items.
    """

    items: tuple[MissionItem, ...]
    origin: GeoPoint
    home: GeoPoint
    takeoff_altitude: float
    start_yaw: float
    vehicle: Vehicle
    limits: Limits = "mission"
    margin: float | None = None
    waypoints: tuple[Waypoint, ...] | None = None
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
    from halfroll import plan as planner

    for finding in check_items(request.items, request.home):
        if finding.severity is not Severity.NOTE:
            raise MissionError(f"mission item {finding.index}: {finding.why}", finding.index)
    course = _course(request)
    if len(course.waypoints) < 2:
        return NothingToPlan(course)
    limits = planner.Limits.of(request.vehicle, request.limits, request.margin)
    plan = planner.plan_course(course.waypoints, request.vehicle, limits, progress)
    return Planned(course, plan, path_of(plan))


def _course(request: PlanRequest) -> Course:
    where = (request.origin, request.home, request.takeoff_altitude, request.start_yaw)
    if request.waypoints and request.start is None:
        return course_of(Mission("stored", request.items, waypoints=request.waypoints), *where)
    return flown_waypoints(request.items, *where, from_item=request.from_item, start=request.start)


class PlanningProcess:
    """A Planner in one worker process. Close it, or use it as a context."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._context, self._said = context, context.SimpleQueue()
        self._pool = self._start()
        self._future: Future[Outcome] | None = None
        self._pool.submit(_warm_up)

    def _start(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(1, self._context, initializer=_start_worker, initargs=(self._said,))

    def submit(self, request: PlanRequest) -> None:
        try:
            self._future = self._pool.submit(_plan_in_worker, request)
        except BrokenProcessPool:  # the worker was ended while it had nothing to do
            self._pool = self._start()
            self._future = self._pool.submit(_plan_in_worker, request)

    def poll(self) -> Outcome | HalfrollError | None:
        if self._future is None or not self._future.done():
            return None
        future, self._future = self._future, None
        try:
            return future.result()
        except HalfrollError as error:
            return error
        except BrokenProcessPool:
            return LinkError("the planner's process was ended from outside; is the machine out of memory?")

    def progress(self) -> str | None:
        latest = None
        while not self._said.empty():
            latest = self._said.get()
        return latest

    def close(self) -> None:
        """Ends the worker now, whatever it is doing."""
        workers = list((self._pool._processes or {}).values())
        self._pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.terminate()
        for worker in workers:
            worker.join()
        self._said.close()

    def __enter__(self) -> PlanningProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


_report: Any = None  # the worker's end of the queue


def _start_worker(said: Any) -> None:
    global _report
    _report = said
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)


def _warm_up() -> None:
    """Imports now what the first plan needs."""
    with contextlib.suppress(ImportError):
        import halfroll.plan  # noqa: F401


def _plan_in_worker(request: PlanRequest) -> Outcome:
    return plan_mission(request, _report.put)
