"""Flights inside this process: firmware and world as halfroll-sitl has them, the ground's references at 100 Hz through
MAVLink bytes, in lockstep.

Why: many short flights, each a hundred times faster than through processes and sockets, with the truth of every
millisecond at hand. The paper's figures are flown this way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware
from halfroll.body_axes import body_up
from halfroll.errors import FlightError
from halfroll.scenario import Scenario
from halfroll.station import references
from halfroll.station.references import PARAMETERS, Path
from halfroll.vehicle import Vehicle
from halfroll.wire.link import Link
from halfroll.wire.messages import GCS, GCS_SYSTEM, GROUND, OFFBOARD, Telemetry

Array = NDArray[np.float64]

TICK_MS = 10
_TAKEOFF, _ARM, _SET_MODE = 22, 400, 176  # MAV_CMD
_CLIMB_MS, _NEAR_M = 10_000, 0.3
_SETTLE_S = 1.5


class AttitudeSetpoint(Protocol):
    @property
    def q_WD(self) -> NDArray[Any]: ...
    @property
    def w_WD_D(self) -> NDArray[Any]: ...
    @property
    def thrust(self) -> float: ...


@dataclass(frozen=True)
class Flown:
    """The truth, a row each sample; the first row is where it began."""

    t: Array  # (N,) [s] since then
    p_WB: Array  # (N, 3)
    v_WB: Array
    q_WB: Array  # (N, 4)
    w_WB_B: Array  # (N, 3) [rad/s]
    rotors: Array  # (N, 4) [N]

    @property
    def up_axis(self) -> Array:
        """(N, 3) the body's z in W."""
        return body_up(self.q_WB)


class StreamedFlight:
    """On the ground at the origin, one second after switch-on. settings: of the world, as `--scenario-set` takes them;
    the autopilot knows nothing of them."""

    def __init__(self, vehicle: Vehicle, scenario: Scenario, seed: int = 0, settings: Sequence[str] = ()) -> None:
        numbers = [f"{key}={number:.17g}" for key, number in vehicle.numbers().items()]
        setup = _firmware.vehicle_setup("mit-vp" if vehicle.variable_pitch else "mit-fp", numbers)
        params = setup.params
        if not scenario.effects.drag:
            params["VEH_DRAG"] = 0.0
        world = [f"{key}={number:.17g}" for key, number in scenario.numbers().items()]
        self.vehicle = vehicle
        self.autopilot = _firmware.Autopilot(setup.vehicle, params)
        self.world = _firmware.World(setup.plant, _firmware.scenario_setup("ideal", [*world, *settings]), seed)
        self._ground = Link(_Wire(self.autopilot, 0), GROUND)
        self._gcs = Link(_Wire(self.autopilot, 1), GCS, GCS_SYSTEM)
        for link in (self._ground, self._gcs):
            link.address(int(params["MAV_SYS_ID"]))
        values = {name: params[name] for name in PARAMETERS}
        self._full_thrust = values["VEH_T_REF"]
        self.references = references.for_vehicle(vehicle, values, link_delay=0.0)
        self.fly(1000)

    def fly(self, milliseconds: int) -> None:
        """Nobody streams."""
        self.autopilot.fly(self.world, milliseconds)

    def command(self, number: int, *params: float) -> None:
        self._gcs.send(self._gcs.command(number, *params))

    def take_off(self, height: float) -> None:
        """To hover at `height` over the origin, within ten seconds. Raises FlightError."""
        self.command(_TAKEOFF, 0, 0, 0, 0, 0, 0, height)
        self.command(_ARM, 1.0)
        self.fly(_CLIMB_MS)
        if not self.autopilot.armed or abs(self.world.p_WB[2] - height) > _NEAR_M:
            raise FlightError(f"it took off to {self.world.p_WB[2]:.2f} m instead of {height:.2f} m")

    def settle(self, position: Sequence[float], yaw: float = 0.0) -> None:
        """Take over from the autopilot and hover at this position, as a plan is begun."""
        way = references.approach(self.state(), position, yaw)
        self.stream(self._along(way), way.duration + _SETTLE_S, TICK_MS)

    def state(self) -> Telemetry:
        """The autopilot's estimate, as its telemetry shows it."""
        e = self.autopilot.estimate
        double = [np.asarray(x, dtype=np.float64) for x in (e.q_WB, e.w_WB_B, e.p_WB, e.v_WB)]
        return Telemetry(self.autopilot.t_us, *double)

    def follow(self, path: Path, seconds: float, sample_ms: int = 1) -> Flown:
        """Fly `path` from now."""
        return self.stream(self._along(path), seconds, sample_ms)

    def stream(self, setpoint: Callable[[Telemetry], AttitudeSetpoint], seconds: float, sample_ms: int = 1) -> Flown:
        """In OFFBOARD, one setpoint each 10 ms; the truth each sample_ms."""
        start_us = self.world.t_us
        rows = [self._row(start_us)]
        for _ in range(round(seconds * 1000) // TICK_MS):
            here = self.state()
            wanted = setpoint(here)
            thrust = wanted.thrust / self._full_thrust
            self._ground.send(self._ground.attitude_target(here.t_us, wanted.q_WD, wanted.w_WD_D, thrust))
            if self.autopilot.mode != "Offboard":
                self.command(_SET_MODE, 1.0, float(OFFBOARD >> 16 & 0xFF))
            for _ in range(TICK_MS // sample_ms):
                self.fly(sample_ms)
                rows.append(self._row(start_us))
        table = np.array(rows)
        return Flown(table[:, 0], *np.split(table[:, 1:], (3, 6, 10, 13), axis=1))

    def _along(self, path: Path) -> Callable[[Telemetry], AttitudeSetpoint]:
        start_us = self.autopilot.t_us
        self.references.begin(self.state())
        return lambda here: self.references.setpoint(path, start_us, here)

    def _row(self, start_us: int) -> list[float]:
        w = self.world
        return [(w.t_us - start_us) * 1e-6, *w.p_WB, *w.v_WB, *w.q_WB, *w.w_WB_B, *w.rotor_thrust]


class _Wire:
    """To the autopilot, at once; what it answers is not heard."""

    def __init__(self, autopilot: _firmware.Autopilot, link: int) -> None:
        self._autopilot, self._link = autopilot, link

    def send(self, datagram: bytes) -> None:
        self._autopilot.service(datagram, link=self._link)

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        return []
