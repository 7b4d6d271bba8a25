"""What an autopilot and its ground say to each other: small frozen values in W and B, and the numbers of the contract.

Why: whoever reads a message needs neither pymavlink nor a wire axis; link.py turns bytes into these.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfroll.missions.geodesy import GeoPoint
from halfroll.missions.mission import MissionItem

Array = NDArray[np.float64]

AUTOPILOT, GROUND, GCS, VIEWER, WORLD = 1, 191, 190, 192, 25  # component ids; the world only where it is simulated
GCS_SYSTEM = 255

# custom_mode = main << 16 | sub << 24
HOLD, MISSION, RTL, LAND = (4 << 16 | sub << 24 for sub in (3, 4, 5, 6))
TAKEOFF, OFFBOARD = 4 << 16 | 2 << 24, 6 << 16
MODE_NAMES = {HOLD: "HOLD", MISSION: "MISSION", RTL: "RTL", LAND: "LAND", TAKEOFF: "TAKEOFF", OFFBOARD: "OFFBOARD"}

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = range(5)  # MAV_RESULT
NOT_STARTED, ACTIVE, PAUSED, COMPLETE = 2, 3, 4, 5  # mission_state
NO_SEQUENCE = 65535
INFO, NOTICE, WARNING, ERROR = 6, 5, 4, 3  # severity of a STATUSTEXT


@dataclass(frozen=True)
class Heartbeat:
    mode: int
    armed: bool
    status: int


@dataclass(frozen=True)
class Telemetry:
    """The vehicle's state at one moment of its own time."""

    t_us: int
    q_WB: Array  # (4,)
    w_WB_B: Array  # (3,) [rad/s]
    p_WB: Array  # (3,) [m] from the local origin
    v_WB: Array  # (3,) [m/s]


@dataclass(frozen=True)
class TimeRequest:
    """The other side asks for the time; in lockstep it stands still until its stamp comes back."""

    stamp: int


@dataclass(frozen=True)
class TimeReply:
    t_ns: int
    stamp: int


@dataclass(frozen=True)
class MissionCurrent:
    """seq: item being flown; state: NOT_STARTED ... COMPLETE, 1 without a mission; mission_id 0 when there is none."""

    seq: int
    total: int
    state: int
    mission_id: int


@dataclass(frozen=True)
class ItemReached:
    seq: int


@dataclass(frozen=True)
class CommandAck:
    command: int
    result: int


@dataclass(frozen=True)
class StatusText:
    severity: int
    text: str
    component: int


@dataclass(frozen=True)
class ParamValue:
    name: str
    value: float


@dataclass(frozen=True)
class ParamError:
    name: str
    code: int


@dataclass(frozen=True)
class MissionCount:
    count: int
    mission_id: int


@dataclass(frozen=True)
class ItemRequest:
    seq: int


@dataclass(frozen=True)
class ItemSent:
    seq: int
    item: MissionItem


@dataclass(frozen=True)
class MissionAck:
    result: int
    mission_id: int


@dataclass(frozen=True)
class Origin:
    place: GeoPoint


@dataclass(frozen=True)
class Home:
    place: GeoPoint
    p_WB: Array  # (3,) [m], the same point in W


@dataclass(frozen=True)
class Health:
    may_arm: bool


@dataclass(frozen=True)
class RotorThrusts:
    """(4,) commands of the rotors, signed shares of the largest thrust."""

    fractions: Array


@dataclass(frozen=True)
class AttitudeWanted:
    """What the autopilot makes the vehicle follow, whoever asked for it."""

    q_WD: Array  # (4,)


Message = (
    Heartbeat
    | Telemetry
    | TimeRequest
    | TimeReply
    | MissionCurrent
    | ItemReached
    | CommandAck
    | StatusText
    | ParamValue
    | ParamError
    | MissionCount
    | ItemRequest
    | ItemSent
    | MissionAck
    | Origin
    | Home
    | Health
    | RotorThrusts
    | AttitudeWanted
)
