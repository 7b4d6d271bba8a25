"""The manoeuvres a mission can name, with their numbers, as waypoints and as items. Why: files and ground stations ask
for the same manoeuvres; what they mean, and what of them an autopilot can store, is said once.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from halfroll.manoeuvres import backflip, figure_eight, flip, half_roll, inverted_leg, power_loop, split_s, window
from halfroll.manoeuvres.place import Axis, after, heading_of
from halfroll.missions.geodesy import DEFAULT_ORIGIN, global_from_local
from halfroll.missions.mission import MissionItem, Waypoint
from halfroll.missions.mission_items import HOME_FRAMES, NO_POSITION_FRAME, Command
from halfroll.wire.frames import attitude_from_degrees, degrees_to_wire, heading_deg_to_yaw, yaw_to_heading_deg

Length = Annotated[float, Field(gt=0.0, le=1000.0, allow_inf_nan=False)]
Degrees = Annotated[float, Field(allow_inf_nan=False)]
Items = list[tuple[MissionItem, list[Waypoint]]]

TRAVEL_M, SWING_M = 0.4, 0.03  # of a half roll, and of a flip on the spot


class Manoeuvre(BaseModel):
    """One manoeuvre; it begins at rest at waypoint `at`, and ends at rest."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    at: Annotated[int, Field(ge=0)]
    kind: str

    @abstractmethod
    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        """After the start, in W (or whatever the start is in); the last one at rest."""

    def entries(self, flown: Sequence[Waypoint]) -> Items:
        """What an autopilot stores of it, and which of the waypoints belong to each item: here, its end."""
        return [(_plain(flown[-1]), list(flown))]


class _Along(Manoeuvre):
    """Along a heading, the nose's if none is given."""

    heading_deg: Degrees | None = None

    def heading(self, start: Waypoint) -> float:
        return start.yaw if self.heading_deg is None else heading_deg_to_yaw(self.heading_deg)


class _About(Manoeuvre):
    """About one of the body's axes. Turns above 0: right wing down, nose up."""

    axis: Axis = "roll"


class HalfRoll(_About):
    kind: Literal["half_roll"]
    turns: Annotated[float, Field(ge=-0.5, le=0.5)] = 0.5
    travel_m: Length = TRAVEL_M

    @field_validator("turns")
    @classmethod
    def _is_half(cls, turns: float) -> float:
        if abs(turns) != 0.5:
            raise ValueError("a half roll turns by 0.5 or -0.5")
        return turns

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        return turned(start, self.axis, self.turns, self.travel_m, SWING_M)

    def entries(self, flown: Sequence[Waypoint]) -> Items:
        return [(_flip_item(self.axis, self.turns), list(flown))]


class Flip(_About):
    kind: Literal["flip"]
    turns: Annotated[float, Field(ge=-5.0, le=5.0, multiple_of=0.5)] = 1.0
    swing_m: Length = SWING_M

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        return turned(start, self.axis, self.turns, TRAVEL_M, self.swing_m)

    def entries(self, flown: Sequence[Waypoint]) -> Items:
        return [(_flip_item(self.axis, self.turns), list(flown))]


class Backflip(_Along):
    kind: Literal["backflip"]
    travel_m: Length = 4.2

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        return backflip.backflip(after(start, self.heading(start)), self.travel_m)


class PowerLoop(_Along):
    kind: Literal["power_loop"]
    size_m: Length = 1.0

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        return power_loop.power_loop(after(start, self.heading(start)), self.size_m)


class SplitS(_About):
    kind: Literal["split_s"]
    height_m: Length = 2.0
    travel_m: Length = TRAVEL_M

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        return split_s.split_s(after(start, heading_of(self.axis, 1.0, start.yaw)), self.height_m, self.travel_m)


class Window(_Along):
    """roll_deg and pitch_deg: how the vehicle stands in the window."""

    kind: Literal["window"]
    roll_deg: Annotated[float, Field(ge=-180.0, le=180.0)] = 0.0
    pitch_deg: Annotated[float, Field(ge=-90.0, le=90.0)] = 0.0
    ahead_m: Length = 4.0
    up_m: Degrees = 0.0

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        attitude = attitude_from_degrees(self.roll_deg, self.pitch_deg, start.yaw)
        return window.window(after(start, self.heading(start)), attitude, self.ahead_m, self.up_m)

    def entries(self, flown: Sequence[Waypoint]) -> Items:
        through = _plain(flown[0])
        heading_deg = yaw_to_heading_deg(flown[0].yaw)
        as_attitude = replace(
            through,
            command=Command.WAYPOINT_USER_1,
            params=(self.roll_deg, self.pitch_deg, math.nan, heading_deg),
        )
        return [(as_attitude, list(flown[:1])), (_plain(flown[-1]), list(flown[1:]))]


class FigureEight(_Along):
    kind: Literal["figure_eight"]
    size_m: Length = 4.0

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        return figure_eight.figure_eight(after(start, self.heading(start)), self.size_m)

    def entries(self, flown: Sequence[Waypoint]) -> Items:
        return [(_plain(point), [point]) for point in flown]


class InvertedLeg(_Along):
    kind: Literal["inverted_leg"]
    length_m: Length = 5.0
    travel_m: Length = TRAVEL_M

    def waypoints(self, start: Waypoint) -> list[Waypoint]:
        return inverted_leg.inverted_leg(after(start, self.heading(start)), self.length_m, self.travel_m)

    def entries(self, flown: Sequence[Waypoint]) -> Items:
        return [
            (inverted_item(True), list(flown[:2])),
            (_plain(flown[2]), list(flown[2:3])),
            (inverted_item(False), list(flown[3:])),
        ]


AnyManoeuvre = Annotated[
    HalfRoll | Flip | Backflip | PowerLoop | SplitS | Window | FigureEight | InvertedLeg, Field(discriminator="kind")
]


def turned(
    start: Waypoint, axis: Axis, turns: float, travel: float = TRAVEL_M, swing: float = SWING_M
) -> list[Waypoint]:
    """About a body axis on the spot, turns being multiples of a half: whole turns where it is, a half one aside by
    travel [m]. After an odd number of half turns it is as upright as it was not."""
    place = after(start, heading_of(axis, turns, start.yaw))
    flown: list[Waypoint] = []
    for _ in range(int(abs(turns))):
        flown += flip.flip(place, swing)
    if abs(turns) % 1.0:
        flown += half_roll.half_roll(place, travel)
    return flown


def rolled_over(start: Waypoint, upright: bool) -> list[Waypoint]:
    """Inverted flight from here on, to the right, or upright again, to the left; nothing where it is so already."""
    if start.upright == upright:
        return []
    return turned(start, "roll", -0.5 if upright else 0.5)


def inverted_item(inverted: bool) -> MissionItem:
    return _no_position(Command.DO_INVERTED_FLIGHT, (float(inverted), 0.0, 0.0, 0.0))


def _flip_item(axis: Axis, turns: float) -> MissionItem:
    return _no_position(Command.USER_1, (1.0 if axis == "roll" else 2.0, turns, math.nan, math.nan))


def _no_position(command: Command, params: tuple[float, float, float, float]) -> MissionItem:
    return MissionItem(command, NO_POSITION_FRAME, params, 0, 0, 0.0)


def _plain(point: Waypoint) -> MissionItem:
    lat_deg, lon_deg, _ = global_from_local(DEFAULT_ORIGIN, point.position)
    params = (0.0, 0.0, 0.0, yaw_to_heading_deg(point.yaw))
    where = degrees_to_wire(lat_deg), degrees_to_wire(lon_deg)
    return MissionItem(Command.WAYPOINT, HOME_FRAMES[0], params, *where, point.position[2])
