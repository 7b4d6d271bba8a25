"""The flight at one look, for whoever watches it in a terminal. Why: a person reads ten figures a second, so they are
put together ten times a second and not at each tick.
"""

from __future__ import annotations

from halfroll.station.pilot import Pilot
from halfroll.station.record import Glance
from halfroll.station.station import State, Station
from halfroll.wire.link import Link
from halfroll.wire.messages import MODE_NAMES
from halfroll.wire.transport import Clock, wall_s

EVERY_S = 0.1  # wall clock
_SET_MESSAGE_INTERVAL, _ACTUATOR_OUTPUT_STATUS, _INTERVAL_US = 511, 375, 100_000


class Lookout:
    """link: the pilot's, which is asked for the rotors' commands."""

    def __init__(self, station: Station, pilot: Pilot, link: Link, items: int, clock: Clock = wall_s) -> None:
        self._station, self._pilot, self._link, self._items, self._clock = station, pilot, link, items, clock
        self._asked = False
        self._before = (clock(), 0, 0)  # wall clock, references sent, vehicle time

    def glance(self) -> Glance:
        """Call it every EVERY_S."""
        if not self._asked and self._link.vehicle_system is not None:
            self._asked = True
            self._link.send(
                self._link.command(_SET_MESSAGE_INTERVAL, float(_ACTUATOR_OUTPUT_STATUS), float(_INTERVAL_US))
            )
        following = self._station.following if self._station.state is State.FLYING else None
        here, record = self._station.here, following.record if following else None
        sent, t_us = record.references_sent if record else 0, here.t_us if here else 0
        now = (self._clock(), sent, t_us)
        wall = max(now[0] - self._before[0], 1e-6)
        rate, speedup = max(now[1] - self._before[1], 0) / wall, max(now[2] - self._before[2], 0) * 1e-6 / wall
        self._before = now
        return Glance(
            mode=MODE_NAMES.get(self._pilot.mode, str(self._pilot.mode)),
            armed=bool(self._pilot.armed),
            item=self._pilot.item,
            items=self._items,
            speed_m_s=float((here.v_WB @ here.v_WB) ** 0.5) if here else 0.0,
            error_m=record.error_m[-1] if record and record.error_m else None,
            rotors=self._pilot.rotors,
            link_rate_Hz=rate,
            vehicle_rate=speedup,
        )
