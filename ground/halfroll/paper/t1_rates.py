"""T1: references come 100 times a second, the attitude loop runs 1000 times.

Why: what happens between two references decides whether 100 a second are enough for 1000 degrees a second.
"""

from __future__ import annotations

import numpy as np

from halfroll.paper import paths
from halfroll.paper.claims import above, near
from halfroll.paper.flights import START_M, backflips, fly
from halfroll.paper.part import Part
from halfroll.scenario import load_scenario
from halfroll.station.references import path_of
from halfroll.streamed import AttitudeSetpoint, StreamedFlight
from halfroll.vehicle import Vehicle, load_vehicle
from halfroll.wire.messages import Telemetry


def reproduce(seeds: int) -> Part:
    flights = backflips("mit-vp", seeds)
    held = fly(flights.plan, seeds, flown_by=load_vehicle("mit-vp", {"params.REF_EXTRAP": 0.0}))
    references, commands = _rates_hz()
    claims = (
        near("T1", "references a second of flight", references, 100.0, "Hz", off=0.0, paper=100.0),
        near("T1.attitude", "new rotor commands a second of flight", commands, 1000.0, "Hz", off=0.0, paper=1000.0),
        above(
            "T1.held",
            "error of Fig 3 with references held still for 10 ms, over that with references turned on by their rate",
            held.worst_position / flights.worst_position,
            1.0,
            note=f"{1e3 * held.worst_position:.0f} mm and {held.worst_attitude_deg:.0f} deg when held",
        ),
    )
    return Part("T1: rates of the two loops", claims)


def _rates_hz() -> tuple[float, float]:
    """Counted over the backflip, by the vehicle's time."""
    vehicle = load_vehicle("mit-vp")
    plan = paths.backflip(vehicle, START_M)
    path = path_of(plan)
    flight = _Watched(vehicle)
    flight.take_off(START_M)
    flight.settle(plan.waypoints[0].position)
    flight.references.begin(flight.state())
    flight.commands, sent_us = [], []
    start_us = flight.autopilot.t_us

    def counted(here: Telemetry) -> AttitudeSetpoint:
        sent_us.append(here.t_us)
        return flight.references.setpoint(path, start_us, here)

    flight.stream(counted, plan.T)
    commands = np.array(flight.commands)
    new = np.any(np.diff(commands, axis=0) != 0.0, axis=1)
    return 1e6 / float(np.mean(np.diff(sent_us))), 1000.0 * float(new.mean())


class _Watched(StreamedFlight):
    """Keeps the rotor commands of each millisecond."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.commands: list[list[float]] = []
        super().__init__(vehicle, load_scenario("nominal"))

    def fly(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            out = self.autopilot.step(self.world.gyro, self.world.accelerometer, self.world.pose)
            self.world.step(out.thrust)
            self.commands.append(out.thrust)
