"""What all runs of a campaign share, made once: the mission as it is stored, its plan, the words of the pilot.

Why: a run should cost its flight. All of this can be pickled, and is sent to each worker once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from halfroll import _firmware
from halfroll.campaign.space import Setup, Space, SpaceError
from halfroll.errors import MissionError
from halfroll.missions.geodesy import GeoPoint
from halfroll.missions.mission import Mission, PlanOptions
from halfroll.missions.mission_files import load_mission
from halfroll.planner.course import endless, home_of, with_takeoff_and_landing
from halfroll.scenario import Scenario
from halfroll.station import planning
from halfroll.station.planning import Planned, PlanRequest
from halfroll.vehicle import Vehicle
from halfroll.wire import conversations
from halfroll.wire import messages as wire
from halfroll.wire.conversations import Talk
from halfroll.wire.link import Link
from halfroll.wire.messages import GCS, GCS_SYSTEM, GROUND

_PILOT_LINK = 1


@dataclass(frozen=True)
class Commands:
    """Frames that every run sends: of the pilot to start, of the ground station to take over."""

    start: tuple[bytes, ...]
    take_over: bytes


@dataclass(frozen=True)
class Prepared:
    space: Space
    mission: Mission  # with take-off and landing
    origin: GeoPoint
    planned: Planned
    image: bytes  # of the mission, as the autopilot stores it
    commands: Commands

    def planned_for(self, setup: Setup) -> Planned:
        """The plan of a run: the one of the space, or its own. Raises PlanError."""
        if setup.plan.once:
            return self.planned
        return plan_of(self.mission, self.origin, setup)


def prepare(space: Space) -> Prepared:
    """Raises MissionError and PlanError for what cannot be flown."""
    mission, _ = with_takeoff_and_landing(load_mission(space.mission))
    if error := endless(mission.items):
        raise error
    origin, nominal = home_of(mission), space.nominal
    planned = plan_of(mission, origin, nominal)
    return Prepared(space, mission, origin, planned, _stored(mission, origin, nominal), _commands(nominal))


def plan_of(mission: Mission, origin: GeoPoint, setup: Setup) -> Planned:
    """As the ground station plans what is stored, from a vehicle that stands at the origin, nose to the north."""
    told = setup.plan
    request = PlanRequest(
        items=mission.items,
        origin=origin,
        home=origin,
        takeoff_altitude=float(firmware_setup(setup.known).params["MIS_TAKEOFF_ALT"]),
        start_yaw=0.0,
        vehicle=setup.known,
        options=PlanOptions.of(told.mode, told.limits, told.margin),
        waypoints=mission.waypoints,
        rules=mission.rules,
    )
    outcome = planning.plan_mission(request)
    if not isinstance(outcome, Planned):
        raise MissionError("nothing to plan: it ends before it has two different positions; add a waypoint")
    return outcome


def firmware_setup(vehicle: Vehicle) -> _firmware.VehicleSetup:
    """Any vehicle as firmware and world have it. Raises SpaceError for one that they do not fly."""
    numbers = [f"{key}={number:.17g}" for key, number in vehicle.numbers().items()]
    try:
        return _firmware.vehicle_setup("mit-vp" if vehicle.variable_pitch else "mit-fp", numbers)
    except ValueError as error:
        raise SpaceError(str(error)) from None


def switched_on(setup: Setup, origin: GeoPoint, image: bytes, seed: int) -> _firmware.Sortie:
    """The vehicle of a run on the ground, with its mission stored."""
    known, world = firmware_setup(setup.known), firmware_setup(setup.vehicle)
    params = known.params.copy()
    if not setup.scenario.effects.drag:  # the firmware knows the air it flies in
        params["VEH_DRAG"] = 0.0
    place = (round(origin.lat_deg * 1e7), round(origin.lon_deg * 1e7), round(origin.alt * 1e3))
    return _firmware.Sortie(known.vehicle, params, world.plant, world_setup(setup.scenario), seed, place, image)


def world_setup(scenario: Scenario) -> _firmware.Scenario:
    return _firmware.scenario_setup("ideal", [f"{key}={x:.17g}" for key, x in scenario.numbers().items()])


class _Wire:
    """To an autopilot that answers at once. With none, what is sent is kept."""

    def __init__(self, sortie: _firmware.Sortie | None = None) -> None:
        self._sortie, self.sent = sortie, list[bytes]()
        self._answers: list[bytes] = []

    def send(self, datagram: bytes) -> None:
        self.sent.append(bytes(datagram))
        if self._sortie:
            self._answers += self._sortie.service(bytes(datagram), _PILOT_LINK)

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        answers, self._answers = self._answers, []
        return answers or (self._sortie.service(b"", _PILOT_LINK) if self._sortie else [])


def _link(transport: _Wire, setup: Setup, component: int, system: int | None = None) -> Link:
    link = Link(transport, component, system)
    link.address(int(firmware_setup(setup.known).params["MAV_SYS_ID"]))
    return link


def _stored(mission: Mission, origin: GeoPoint, setup: Setup) -> bytes:
    """The mission uploaded as a pilot does, and what the autopilot stores of it."""
    sortie = switched_on(setup, origin, b"", seed=0)
    link = _link(_Wire(sortie), setup, GCS, GCS_SYSTEM)
    talk = Talk(link, conversations.upload(link, mission.items))
    while not talk.done:
        for message in link.receive():
            talk.hear(message)
        talk.go_on()
    return sortie.stored_mission


def _commands(setup: Setup) -> Commands:
    pilots, grounds = _Wire(), _Wire()
    pilot, ground = _link(pilots, setup, GCS, GCS_SYSTEM), _link(grounds, setup, GROUND)
    pilot.send(pilot.command(conversations.SET_MODE, *_mode(wire.MISSION)))
    pilot.send(pilot.command(conversations.ARM_DISARM, 1.0))
    ground.send(ground.command(conversations.SET_MODE, *_mode(wire.OFFBOARD)))
    return Commands(tuple(pilots.sent), grounds.sent[0])


def _mode(mode: int) -> Sequence[float]:
    return 1.0, float(mode >> 16 & 0xFF), float(mode >> 24)
