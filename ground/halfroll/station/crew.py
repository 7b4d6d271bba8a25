"""The crew of a flight: ground station and, where there is one, pilot, in one loop of one process.

Why: references go out every 10 ms whatever else the machine does, so this process does nothing else; and in lockstep
time stands still while any question of either is open, which takes one loop that hears both links.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from halfroll.errors import HalfrollError, LinkError
from halfroll.missions.mission import DEFAULT_OPTIONS, Mission, PlanOptions
from halfroll.station.lookout import EVERY_S as LOOK_EVERY_S
from halfroll.station.lookout import Lookout
from halfroll.station.pilot import Pilot
from halfroll.station.planning import Planned, PlanningProcess, ReadyPlan
from halfroll.station.record import Event, Record
from halfroll.station.station import Station
from halfroll.station.telling import Teller
from halfroll.vehicle import Vehicle
from halfroll.wire.link import Link
from halfroll.wire.messages import GCS, GCS_SYSTEM, GROUND, Message
from halfroll.wire.tlog import RecordedTransport
from halfroll.wire.transport import LOOPBACK, Transport, UdpTransport, wait_for_any, wall_s

_POLL_S = 0.02  # how long the planner's outcome may lie unseen
SILENT_S = 10.0  # wall clock
_TIME_EVERY_S = 0.2  # wall clock: whoever watches hears where the flight is


@dataclass(frozen=True)
class Orders:
    """What to fly; core: of the processor, to stay on while flying; told_port: of whoever watches; watched: a person
    sees how it goes, and wants to know what the rotors do; tlog: where the raw link is recorded."""

    mission: Mission
    vehicle: Vehicle
    options: PlanOptions = DEFAULT_OPTIONS
    core: int | None = None
    told_port: int | None = None
    watched: bool = False
    planned: Planned | None = None  # of this mission, in place of planning it
    tlog: Path | None = None


@dataclass(frozen=True)
class Debriefing:
    """How it went; record is None when the autopilot flew alone."""

    record: Record | None
    lockstep: bool
    texts: tuple[str, ...]


def fly_together(
    station: Station, pilot: Pilot, links: Sequence[tuple[Link, UdpTransport]], watch: Callable[[], None]
) -> None:
    """Until the pilot is done. links: the station's and the pilot's; watch: called again and again.

    Raises LinkError when the autopilot falls silent: its heartbeat comes even while its time stands.
    """
    hearers: tuple[Callable[[Message], None], ...] = (station.hear, pilot.hear)
    heard_s = wall_s()
    while not pilot.done:
        wait_for_any([transport for _, transport in links], _POLL_S)
        with links[0][0].gathering():
            if hear_all([link for link, _ in links], hearers):
                heard_s = wall_s()
            station.go_on()
            pilot.go_on()
            station.answer_time(others_wait=pilot.awaits_answer)
        if wall_s() - heard_s > SILENT_S:
            raise LinkError(f"the autopilot has been silent for {SILENT_S:.0f} s; is its process stopped? fly again")
        watch()


def hear_all(links: Sequence[Link], hearers: Sequence[Callable[[Message], None]]) -> bool:
    """Whether anything was there to hear."""
    heard = False
    for link, hear in zip(links, hearers, strict=True):
        for message in link.receive():
            hear(message)
            heard = True
    return heard


def fly_mission(
    orders: Orders,
    offboard: UdpTransport,
    gcs: UdpTransport,
    report: Callable[[Event], None] = lambda _: None,
    watch: Callable[[], None] = lambda: None,
    told: Transport | None = None,
) -> Debriefing:
    """One mission from upload to shutdown of the vehicle; told: where whoever watches hears of it. Raises what ended
    it."""
    raw = None if orders.tlog is None else RecordedTransport(offboard, orders.tlog)
    offboard_link = Link(raw or offboard, GROUND)
    gcs_link = Link(gcs, GCS, GCS_SYSTEM, also=("ACTUATOR_OUTPUT_STATUS",) if orders.watched else ())
    if raw is not None:
        raw.time_us = lambda: offboard_link.t_us
    with PlanningProcess() if orders.planned is None else ReadyPlan(orders.planned) as planner:
        if orders.core is not None:  # the planner has begun, and goes where it likes
            os.sched_setaffinity(0, {orders.core})
        station = Station(
            offboard_link,
            orders.vehicle,
            planner,
            orders.options,
            finer=orders.mission,
            other_links=[gcs_link],
            report=report,
        )
        pilot = Pilot(gcs_link, orders.mission, lambda: station.outcome is not None, lambda: station.plan_error, report)
        lookout = Lookout(station, pilot, gcs_link, len(orders.mission.items))
        teller = None if told is None else Teller(told)
        told_s = wall_s()

        def look_around() -> None:
            nonlocal told_s
            if teller:
                teller.tell(station)
            if wall_s() - told_s > (LOOK_EVERY_S if orders.watched else _TIME_EVERY_S):
                told_s = wall_s()
                watch()
                glance = lookout.glance() if orders.watched else None
                report(Event("time", offboard_link.t_us * 1e-6, "", item=pilot.item, glance=glance))

        fly_together(station, pilot, ((offboard_link, offboard), (gcs_link, gcs)), look_around)
    if raw is not None:
        raw.close()
    record = station.following.record if station.following else None
    return Debriefing(record, station.lockstep, tuple(pilot.texts))


def main() -> None:
    """A process of its own: descriptors of a connection to its parent and of the two bound sockets as arguments.

    It receives Orders, sends Events, and at the end a Debriefing or the error; it ends when its parent does.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # closing the planner's process on the way
    parent, offboard, gcs = (int(word) for word in sys.argv[1:4])
    with Connection(parent) as connection:
        orders = connection.recv()

        def watch() -> None:
            if connection.poll():  # nothing is ever sent: this is the end of the parent
                os._exit(1)

        ours, pilots = (UdpTransport(socket.socket(fileno=descriptor)) for descriptor in (offboard, gcs))
        told = None if orders.told_port is None else UdpTransport.bind(0, (LOOPBACK, orders.told_port))
        try:
            connection.send(fly_mission(orders, ours, pilots, connection.send, watch, told))
        except HalfrollError as error:
            connection.send(error)
        except ConnectionError:
            sys.exit(1)
