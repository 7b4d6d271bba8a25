"""The items the autopilot knows, as data. Why: one table says what each number may be and who flies it;
mission_check.py and course.py only walk it. The autopilot holds the same table in firmware/link.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, IntEnum, auto

from halfroll.missions.mission import NOT_GIVEN, MissionItem

ABSOLUTE_FRAMES = (0, 5)  # heights above mean sea level
HOME_FRAMES = (3, 6)  # heights above home
NO_POSITION_FRAME = 2


class Command(IntEnum):
    """MAV_CMD numbers that mean something to us; the rest of the table is stored and skipped."""

    WAYPOINT = 16
    LOITER_UNLIM = 17
    LOITER_TIME = 19
    RETURN_TO_LAUNCH = 20
    LAND = 21
    TAKEOFF = 22
    SPLINE_WAYPOINT = 82
    DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_YAW = 115
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_LAND_START = 189
    DO_INVERTED_FLIGHT = 210
    WAYPOINT_USER_1 = 31000
    USER_1 = 31010


class Role(Enum):
    """What the planner makes of an item."""

    SKIP = auto()
    TAKEOFF = auto()
    WAYPOINT = auto()  # p1 hold where `holds`, p4 heading
    LOITER = auto()  # for ever
    END = auto()  # LAND, RETURN_TO_LAUNCH: the autopilot's
    WAIT = auto()
    YAW = auto()
    JUMP = auto()
    SPEED = auto()
    HOME = auto()
    INVERT = auto()  # p1: upside down from here on, or upright
    FLIP = auto()  # p1 axis, p2 turns, p3 least height, p4 longest time


class Place(Enum):
    """What latitude, longitude and height mean for an item."""

    NONE = auto()
    ZERO = auto()  # nothing, and latitude and longitude must be 0
    OPTIONAL = auto()  # 0, 0 or NOT_GIVEN is "here", NaN height the default
    REQUIRED = auto()
    UNLESS_P1 = auto()  # required where p1 is 0, else nothing


@dataclass(frozen=True)
class Param:
    """What one of p1..p4 may be; infinite values are never allowed."""

    meaning: str
    least: float = -math.inf
    most: float = math.inf
    nan: bool = True
    step: float = 0.0  # multiples of this only
    also: tuple[float, ...] = ()  # allowed besides
    above: bool = False  # `least` itself is not allowed
    nonzero: bool = False

    def complaint(self, value: float) -> str | None:
        """Why `value` is not allowed, None if it is."""
        if math.isnan(value):
            return None if self.nan else f"{self.meaning} is not given, a number is needed"
        if not math.isfinite(value):
            return f"{self.meaning} is infinite"
        if value in self.also:
            return None
        if not self.least <= value <= self.most or (self.above and value == self.least):
            return f"{self.meaning} is {value:g}, {self._allowed()}"
        if self.nonzero and value == 0:
            return f"{self.meaning} is 0, any other is allowed"
        if self.step and not (value / self.step).is_integer():
            return f"{self.meaning} is {value:g}, only multiples of {self.step:g} are allowed"
        return None

    def _allowed(self) -> str:
        if self.least == self.most == 0:
            return "only 0 is allowed"
        if math.isinf(self.most):
            text = f"{'more than' if self.above else 'at least'} {self.least:g} is allowed"
        else:
            text = f"{self.least:g} to {self.most:g} is allowed"
        return text + (f" or {', '.join(f'{v:g}' for v in self.also)}" if self.also else "")


@dataclass(frozen=True)
class ItemKind:
    """One row. `not_flown` says what the planner does not do of it yet."""

    name: str
    role: Role
    place: Place = Place.NONE
    params: tuple[Param, Param, Param, Param] = (Param("param 1"), Param("param 2"), Param("param 3"), Param("param 4"))
    frames: tuple[int, ...] = (0, 2, 3, 5, 6)
    any_height: bool = False
    not_flown: str | None = None

    @property
    def holds(self) -> bool:
        return self.params[0] is _HOLD

    @property
    def turns(self) -> bool:
        return self.params[3] is _YAW

    def place_of(self, item: MissionItem) -> Place:
        """What place means for this very item: never UNLESS_P1."""
        if self.place is not Place.UNLESS_P1:
            return self.place
        return Place.REQUIRED if item.params[0] == 0 else Place.NONE

    @property
    def ends_a_leg(self) -> bool:
        """Takes time to reach, so a jump loop with one of these in it does not spin."""
        return self.role in (Role.TAKEOFF, Role.WAYPOINT, Role.LOITER, Role.END)


_UNUSED = Param("an unused parameter", 0, 0)
_ANY = Param("a free parameter")
_HOLD = Param("hold time [s]", 0, nan=False)
_RADIUS = Param("radius [m]", 0, nan=False)
_YAW = Param("heading [deg]")
_PRECISION = Param("precision land mode", 0, 2, nan=False, step=1)
_COUNT_MAX = 65535
_SPEED = Param("speed [m/s]", 0, nan=False, also=(-1, -2), above=True)
_HERE = Param("use current position", 0, 1, nan=False, step=1)
_POSITION = (0, 3, 5, 6)

TABLE: dict[int, ItemKind] = {
    16: ItemKind("WAYPOINT", Role.WAYPOINT, Place.REQUIRED, (_HOLD, _RADIUS, _UNUSED, _YAW), _POSITION),
    82: ItemKind("SPLINE_WAYPOINT", Role.WAYPOINT, Place.REQUIRED, (_HOLD, _UNUSED, _UNUSED, _UNUSED), _POSITION),
    31000: ItemKind(
        "WAYPOINT_USER_1",
        Role.WAYPOINT,
        Place.REQUIRED,
        (Param("roll [deg]", -180, 180), Param("pitch [deg]", -90, 90), Param("speed [m/s]", 0), _YAW),
        _POSITION,
    ),
    17: ItemKind("LOITER_UNLIM", Role.LOITER, Place.REQUIRED, (_ANY, _ANY, _ANY, _YAW), _POSITION),
    19: ItemKind("LOITER_TIME", Role.WAYPOINT, Place.REQUIRED, (_HOLD, _ANY, _ANY, _ANY), _POSITION),
    22: ItemKind("TAKEOFF", Role.TAKEOFF, Place.OPTIONAL, (_ANY, _UNUSED, _UNUSED, _YAW), _POSITION),
    21: ItemKind("LAND", Role.END, Place.OPTIONAL, (_ANY, _PRECISION, _UNUSED, _YAW), _POSITION, any_height=True),
    20: ItemKind("RETURN_TO_LAUNCH", Role.END, Place.NONE, (_UNUSED, _UNUSED, _UNUSED, _UNUSED)),
    93: ItemKind("DELAY", Role.WAIT, Place.ZERO, (Param("delay [s]", 0, nan=False, also=(-1,)), _ANY, _ANY, _ANY)),
    112: ItemKind("CONDITION_DELAY", Role.WAIT, Place.NONE, (Param("delay [s]", 0, nan=False), _ANY, _ANY, _ANY)),
    115: ItemKind(
        "CONDITION_YAW",
        Role.YAW,
        Place.NONE,
        (Param("heading [deg]", nan=False), _ANY, Param("direction", -1, 1, step=1), Param("relative", 0, 1, step=1)),
    ),
    177: ItemKind(
        "DO_JUMP",
        Role.JUMP,
        Place.NONE,
        (
            Param("target item", 0, _COUNT_MAX, nan=False, step=1),
            Param("repeats", -1, _COUNT_MAX, nan=False, step=1),
            _ANY,
            _ANY,
        ),
    ),
    178: ItemKind(
        "DO_CHANGE_SPEED",
        Role.SPEED,
        Place.NONE,
        (Param("speed type", 0, 3, nan=False, step=1), _SPEED, _ANY, _ANY),
    ),
    179: ItemKind("DO_SET_HOME", Role.HOME, Place.UNLESS_P1, (_HERE, _ANY, _ANY, _ANY)),
    189: ItemKind("DO_LAND_START", Role.SKIP),
    210: ItemKind(
        "DO_INVERTED_FLIGHT",
        Role.INVERT,
        Place.NONE,
        (Param("inverted", 0, 1, nan=False, step=1), _ANY, _ANY, _ANY),
    ),
    31010: ItemKind(
        "USER_1 (flip)",
        Role.FLIP,
        Place.NONE,
        (
            Param("axis (1 roll, 2 pitch)", 1, 2, nan=False, step=1),
            Param("turns", -5, 5, nan=False, step=0.5, nonzero=True),
            Param("least height [m]"),
            Param("longest time [s]", 0, above=True),
        ),
        (NO_POSITION_FRAME,),
    ),
}
_STORED_AND_SKIPPED = {
    181: "DO_SET_RELAY", 183: "DO_SET_SERVO", 187: "DO_SET_ACTUATOR", 195: "DO_SET_ROI_LOCATION",
    197: "DO_SET_ROI_NONE",
    201: "DO_SET_ROI", 203: "DO_DIGICAM_CONTROL", 204: "DO_MOUNT_CONFIGURE", 205: "DO_MOUNT_CONTROL",
    206: "DO_SET_CAM_TRIGG_DIST", 211: "DO_GRIPPER", 214: "DO_SET_CAM_TRIGG_INTERVAL", 530: "SET_CAMERA_MODE",
    531: "SET_CAMERA_ZOOM", 532: "SET_CAMERA_FOCUS", 1000: "DO_GIMBAL_MANAGER_PITCHYAW",
    1001: "DO_GIMBAL_MANAGER_CONFIGURE", 2000: "IMAGE_START_CAPTURE", 2001: "IMAGE_STOP_CAPTURE",
    2500: "VIDEO_START_CAPTURE", 2501: "VIDEO_STOP_CAPTURE",
}  # fmt: skip
for _number, _name in _STORED_AND_SKIPPED.items():
    TABLE[_number] = ItemKind(_name, Role.SKIP, not_flown="nothing on board does this: skipped")


def command_name(command: int) -> str:
    """Its MAVLink name where we know it, else the number."""
    return TABLE[command].name if command in TABLE else f"command {command}"


def is_here(item: MissionItem) -> bool:
    """The item gives no latitude and longitude (or the 0, 0 that stands for that)."""
    absent = (NOT_GIVEN, -NOT_GIVEN - 1)
    return item.x in absent or item.y in absent or (item.x == 0 and item.y == 0)


def first_flown(items: tuple[MissionItem, ...], seq0_home: int = 2) -> int:
    """1 where item 0 is a home placeholder, else 0. `seq0_home` is MIS_SEQ0_HOME: 0 never, 1 always, 2 when it is one.

    It is one exactly when it is WAYPOINT in frame 0 and item 1 is TAKEOFF: nothing else can be meant by that.
    """
    if seq0_home == 2:
        home = len(items) > 1 and items[0].command == Command.WAYPOINT and items[0].frame == 0
        return int(home and items[1].command == Command.TAKEOFF)
    return seq0_home
