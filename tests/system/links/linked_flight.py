"""A whole mission in one process: firmware and world, the real station and pilot, and two faulty links between them.

Why: hundreds of flights over links that are bad in exactly the same way each time. All time is the vehicle's, also the
clock by which the ground repeats its questions; nothing waits in lockstep, so what comes late is late.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware
from halfroll.errors import HalfrollError, LinkError
from halfroll.missions.geodesy import GeoPoint
from halfroll.missions.mission import Mission, PlanOptions
from halfroll.missions.mission_files import load_mission
from halfroll.planner.course import with_takeoff_and_landing
from halfroll.station.crew import hear_all
from halfroll.station.pilot import Pilot
from halfroll.station.planning import Outcome, PlanRequest, outcome_of
from halfroll.station.record import Record
from halfroll.station.station import Station
from halfroll.vehicle import Vehicle, load_vehicle
from halfroll.wire.link import Link
from halfroll.wire.messages import GCS, GCS_SYSTEM, GROUND
from system.links.faulty_link import Faults, Way

A, B = 0, 1  # links: ground station, ground control station
TO_ALL = 255
PLANNING_S = 1.0  # vehicle time from request to plan
FAILSAFE_SHOWN_S = 8.0  # after its text: the vehicle has settled in what it fell back to
LONGEST_S = 150.0
TICK_MS = 10
_STATUSTEXT = 253


@dataclass(frozen=True)
class Errand:
    """What is flown, and how it is planned."""

    name: str
    mission: Mission
    vehicle: Vehicle
    options: PlanOptions

    @classmethod
    def of(
        cls,
        file: Path,
        vehicle: str = "mit-vp",
        options: PlanOptions = PlanOptions.of("fast"),  # noqa: B008
    ) -> Errand:
        mission, _ = with_takeoff_and_landing(load_mission(file))
        return cls(file.stem, mission, load_vehicle(vehicle), options)


class RememberedPlans:
    """A planner that takes `PLANNING_S` of vehicle time. A whole mission is planned once for all starts that only noise
    tells apart, so a flight is the same whichever was flown before it; what is left of one is planned each time."""

    _whole: list[tuple[PlanRequest, Outcome | HalfrollError]] = []  # noqa: RUF012

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock, self._request, self._due_s = clock, None, 0.0

    def submit(self, request: PlanRequest) -> None:
        self._request, self._due_s = request, self._clock() + PLANNING_S

    def poll(self) -> Outcome | HalfrollError | None:
        request = self._request
        if request is None or self._clock() < self._due_s:
            return None
        self._request = None
        if request.start is not None:
            return outcome_of(request)
        alike = _without_noise(request)
        known = next((outcome for known, outcome in self._whole if known == alike), None)
        if known is None:
            known = outcome_of(alike)
            self._whole.append((alike, known))
        return known

    def progress(self) -> str | None:
        return None


def _without_noise(request: PlanRequest) -> PlanRequest:
    """The heading to a twentieth of a radian, home to a decimetre."""
    lat, lon, alt = request.home
    home = GeoPoint(round(lat, 6), round(lon, 6), round(alt, 1))
    return replace(request, start_yaw=round(20.0 * request.start_yaw) / 20.0, home=home)


@dataclass
class Account:
    """What became of one flight."""

    ended: str = ""  # "completed by the plan", "completed on board", "failsafe", or what went wrong
    t_s: float = 0.0
    texts: list[str] = field(default_factory=list)  # what the autopilot said, lost on the way or not
    said: list[str] = field(default_factory=list)  # the station's events
    suffered: Counter[str] = field(default_factory=Counter)
    broken: list[str] = field(default_factory=list)  # invariants
    crashed: bool = False
    armed: bool = True
    hovers: bool = False  # upright, at rest, in the air
    by_plan_s: float = 0.0  # flown by the plan

    def __str__(self) -> str:
        faults = ", ".join(f"{kind} {n}" for kind, n in sorted(self.suffered.items()))
        return f"{self.ended} after {self.t_s:.1f} s, {self.by_plan_s:.1f} s by plan ({faults or 'no fault'})"


class LinkedFlight:
    """One vehicle, its links, and who listens there."""

    ends = ((A, 0), (B, 0))  # link and slot, as the vehicle knows who is there

    def __init__(self, errand: Errand, faults: Faults, seed: int, scenario: str = "nominal") -> None:
        numbers = [f"{key}={number:.17g}" for key, number in errand.vehicle.numbers().items()]
        setup = _firmware.vehicle_setup("mit-vp" if errand.vehicle.variable_pitch else "mit-fp", numbers)
        self.errand, self._seed = errand, seed
        self.autopilot = _firmware.Autopilot(setup.vehicle, setup.params)
        self.world = _firmware.World(setup.plant, scenario, seed)
        self._thrusts = setup.vehicle.thrust_min, setup.vehicle.thrust_max
        self._commanded: list[NDArray[np.float32]] = []  # since the last tick
        self._armed = False  # at that
        self._upward = [Way(faults, f"{seed} up {end}") for end in range(len(self.ends))]
        self._downward = [Way(faults, f"{seed} down {end}") for end in range(len(self.ends))]
        self.account = Account()
        self._pilot_link = Link(self._end(B), GCS, GCS_SYSTEM)
        self.start_station()
        self.pilot = Pilot(
            self._pilot_link,
            errand.mission,
            lambda: self.station.outcome is not None,
            lambda: self.station.plan_error,
            clock=self.clock,
        )

    def clock(self) -> float:
        return self.autopilot.t_us * 1e-6

    def _end(self, end: int) -> _End:
        return _End(self._upward[end], self._downward[end], self.clock)

    def start_station(self) -> None:
        """In the place of one that was there before, and knows nothing of it."""
        self._alive = True
        self._station_link = Link(self._end(A), GROUND)
        self.station = Station(
            self._station_link,
            self.errand.vehicle,
            RememberedPlans(self.clock),
            self.errand.options,
            finer=self.errand.mission,
            report=lambda event: self.account.said.append(event.kind),
            clock=self.clock,
        )

    def end_station(self) -> None:
        """From one millisecond to the next, without a word."""
        self._alive = False

    def step(self) -> None:
        """To the next moment at which anything is said or heard, 10 ms at most, and what the ground does then."""
        now_s = self.clock()
        for way, (link, slot) in zip(self._upward, self.ends, strict=True):
            for datagram in way.arrived(now_s):
                self._carry(self.autopilot.service(datagram, link, slot, self.autopilot.t_us))
        until_tick = TICK_MS - self.autopilot.t_us // 1000 % TICK_MS
        until_due_s = min(way.next_s for way in (*self._upward, *self._downward)) - now_s
        steps = until_tick if until_due_s > 1e-3 * until_tick else max(1, math.ceil(1e3 * until_due_s - 1e-6))
        commanded, frames = self.autopilot.fly_until_heard(self.world, steps)
        self._commanded.append(commanded)
        self._carry(frames)
        at_tick = self.autopilot.t_us % (1000 * TICK_MS) == 0
        if at_tick:
            self._check()
        if at_tick or min(way.next_s for way in self._downward) <= self.clock():
            self._turn()

    def _turn(self) -> None:
        if self._alive:
            hear_all([self._station_link], [self.station.hear])
            try:
                self.station.go_on()
            except LinkError:  # as run_ground does
                self.start_station()
        else:
            self._downward[A].arrived(self.clock())
        hear_all([self._pilot_link], [self.pilot.hear])
        self.pilot.go_on()

    def _carry(self, frames: list[tuple[int, int, bytes]]) -> None:
        for link, to, frame in frames:
            for way, (here, slot) in zip(self._downward, self.ends, strict=True):
                if link == here and to in (slot, TO_ALL):
                    way.post(self.clock(), frame)
            if link == B and int.from_bytes(frame[7:10], "little") == _STATUSTEXT:
                self.account.texts.append(frame[11 : 10 + frame[1]].split(b"\0")[0].decode())

    def _check(self) -> None:
        """What holds in every flight: of the commands in each millisecond, of the state in each tick."""
        commanded, armed = np.concatenate(self._commanded), self.autopilot.armed and self._armed
        self._commanded, self._armed = [], self.autopilot.armed
        least, most = self._thrusts if armed else (min(0.0, self._thrusts[0]), self._thrusts[1])  # or they stand
        w, e = self.world, self.autopilot.estimate
        if not (least <= commanded.min() and commanded.max() <= most):  # of which neither passes over a NaN
            self.account.broken.append(f"{self.clock():.3f} s: rotor commands {commanded}")
        state = np.concatenate((w.p_WB, w.v_WB, w.w_WB_B, e.p_WB, e.v_WB, e.w_WB_B))
        if not math.isfinite(state.sum()):
            self.account.broken.append(f"{self.clock():.3f} s: not finite: {state}")
        for q in (w.q_WB, e.q_WB):
            if not abs(float(q @ q) - 1.0) < 1e-3:
                self.account.broken.append(f"{self.clock():.3f} s: no unit quaternion: {q}")

    def fly(self) -> Account:
        """Until the pilot is done, or some seconds after a failsafe ended the flight by plan."""
        account, failed_s = self.account, math.inf
        try:
            while not self.pilot.done and self.clock() < min(LONGEST_S, failed_s + FAILSAFE_SHOWN_S):
                self.step()
                if failed_s == math.inf and any("Failsafe: " in text for text in account.texts):
                    failed_s = self.clock()
            by_plan = "handed-back" in account.said and "left" not in account.said
            complete = "completed by the plan" if by_plan else "completed on board"
            account.ended = complete if self.pilot.done else "failsafe" if failed_s < math.inf else "never ended"
        except HalfrollError as error:
            account.ended = "failsafe" if failed_s < math.inf else f"{type(error).__name__}: {error}"
        account.t_s, account.crashed = self.clock(), self.world.crashed
        account.armed, account.hovers = self.autopilot.armed, self.hovers
        for way in (*self._upward, *self._downward):
            account.suffered += way.suffered
        account.by_plan_s = 0.01 * len(self.record.error_m) if self.record else 0.0
        return account

    @property
    def record(self) -> Record | None:
        """Of the flight by plan, as the station has it."""
        return self.station.following.record if self.station.following else None

    @property
    def up(self) -> float:
        """Cosine of the tilt."""
        _, x, y, _ = self.world.q_WB
        return float(1.0 - 2.0 * (x * x + y * y))

    @property
    def hovers(self) -> bool:
        return bool(self.up > 0.99 and np.linalg.norm(self.world.v_WB) < 0.2 and self.world.p_WB[2] > 0.5)

    def say(self, command: int, *params: float) -> None:
        """A user, at the ground control station."""
        self._pilot_link.send(self._pilot_link.command(command, *params))


class _End:
    """The ground's end of one link."""

    def __init__(self, upward: Way, downward: Way, clock: Callable[[], float]) -> None:
        self._upward, self._downward, self._clock = upward, downward, clock

    def send(self, datagram: bytes) -> None:
        self._upward.post(self._clock(), datagram)

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        return self._downward.arrived(self._clock())
