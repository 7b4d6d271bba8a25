"""Flights inside this process: firmware and world as halfroll-sitl has them, the ground's references at 100 Hz through
real MAVLink bytes, in lockstep. What the campaigns fly, a hundred times faster than through sockets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfroll import _dialect, _firmware
from halfroll.frames import to_wire
from halfroll.link import GROUND, OFFBOARD
from halfroll.references import PARAMETERS, Path, References
from halfroll.vehicle import load_vehicle

Array = NDArray[np.float64]
TICK_MS = 10


@dataclass(frozen=True)
class State:
    """The autopilot's estimate, as its telemetry shows it."""

    t_us: int
    q_WB: Array
    w_WB_B: Array
    p_WB: Array
    v_WB: Array


class StreamedFlight:
    """On the ground at the origin, one second after switch-on."""

    def __init__(
        self,
        vehicle: str = "mit-vp",
        scenario: str = "nominal",
        settings: Sequence[str] = (),
        seed: int = 0,
        vehicle_settings: Sequence[str] = (),
    ) -> None:
        setup = _firmware.vehicle_setup(vehicle, list(vehicle_settings))
        params = setup.params
        if scenario == "ideal":
            params["VEH_DRAG"] = 0.0
        self.vehicle = load_vehicle(vehicle)
        self.autopilot = _firmware.Autopilot(setup.vehicle, params)
        self.world = _firmware.World(setup.plant, _firmware.scenario_setup(scenario, list(settings)), seed)
        self._gcs = _dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self._ground = _dialect.MAVLink(None, srcSystem=1, srcComponent=GROUND)
        values = {name: params[name] for name in PARAMETERS}
        self._full_thrust = values["VEH_T_REF"]
        self.references = References.for_vehicle(self.vehicle, values, link_delay=0.0)
        self.fly(1000)

    def fly(self, milliseconds: int) -> None:
        self.autopilot.fly(self.world, milliseconds)

    def command(self, number: int, *params: float) -> None:
        filled = (*params, *([0.0] * (7 - len(params))))
        message = self._gcs.command_long_encode(1, 1, number, 0, *filled)
        self.autopilot.service(message.pack(self._gcs), link=1)

    def take_off(self, height: float) -> None:
        """To hover at `height` over the origin, within ten seconds."""
        self.command(_dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, height)
        self.command(_dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
        self.fly(10000)
        assert self.autopilot.armed
        assert abs(self.world.p_WB[2] - height) < 0.3, f"took off to {self.world.p_WB[2]:.2f} m"

    def offboard(self) -> None:
        self.command(_dialect.MAV_CMD_DO_SET_MODE, 1.0, float(OFFBOARD >> 16 & 0xFF))

    def state(self) -> State:
        e = self.autopilot.estimate
        return State(self.autopilot.t_us, e.q_WB, e.w_WB_B, e.p_WB, e.v_WB)

    def follow(self, path: Path, seconds: float) -> tuple[Array, Array]:
        """Fly `path` from now. Times since its start (N,) and true positions (N, 3), every tick, the start included."""
        start_us = self.autopilot.t_us
        self.references.begin(self.state())
        t, positions = [(self.world.t_us - start_us) * 1e-6], [self.world.p_WB]
        for _ in range(round(seconds * 1000) // TICK_MS):
            setpoint = self.references.setpoint(path, start_us, self.state())
            self._send(
                self._ground.set_attitude_target_encode(
                    self.autopilot.t_us // 1000,
                    *(1, 1, 0),
                    to_wire(setpoint.q_WD).tolist(),
                    *to_wire(setpoint.w_WD_D).tolist(),
                    float(np.clip(setpoint.thrust / self._full_thrust, -1.0, 1.0)),
                )
            )
            if len(t) == 1:
                self.offboard()
            self.fly(TICK_MS)
            t.append((self.world.t_us - start_us) * 1e-6)
            positions.append(self.world.p_WB)
        return np.array(t), np.array(positions)

    def _send(self, message: object) -> None:
        self.autopilot.service(message.pack(self._ground), link=0)  # type: ignore[attr-defined]
        self._ground.seq = (self._ground.seq + 1) % 256
