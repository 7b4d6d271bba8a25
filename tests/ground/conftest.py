"""A made-up flight, written as ULog by hand, whose figures are known by construction.

Why: an independent statement of the log's format and of the report's figures, for the tests of log, report and command
line; it shares no line with the code under test.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

OFFBOARD, MISSION = 5, 1
TOPICS = {
    "vehicle_truth": "uint64_t timestamp;double[3] p;double[3] v;double[4] q;double[3] w;double[4] f;",
    "rotor_commands": "uint64_t timestamp;float[4] thrust;",
    "attitude_reference": "uint64_t timestamp;float[4] q;float[3] w;float thrust;",
    "vehicle_state": "uint64_t timestamp;uint8_t mode;uint8_t armed;",
}
PACKED = {"vehicle_truth": "<Q17d", "rotor_commands": "<Q4f", "attitude_reference": "<Q8f", "vehicle_state": "<QBB"}


def ulog_message(kind: str, content: bytes) -> bytes:
    return struct.pack("<HB", len(content), ord(kind)) + content


def ulog_bytes(rows: dict[str, list[tuple[float, ...]]], info: dict[str, str] | None = None) -> bytes:
    """Header, flag bits, formats, info, subscriptions, samples. A row begins with its time in microseconds."""
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0), ulog_message("B", bytes(40))]
    parts += [ulog_message("F", f"{name}:{TOPICS[name]}".encode()) for name in rows]
    for key, text in (info or {}).items():
        typed = f"char[{len(text)}] {key}".encode()
        parts.append(ulog_message("I", bytes([len(typed)]) + typed + text.encode()))
    parts += [ulog_message("A", struct.pack("<BH", 0, i) + name.encode()) for i, name in enumerate(rows)]
    for i, (name, samples) in enumerate(rows.items()):
        parts += [ulog_message("D", struct.pack("<H", i) + struct.pack(PACKED[name], *row)) for row in samples]
    return b"".join(parts)


@dataclass
class Circle:
    """A stand-in for a plan: once around a circle of 2 m at about 2 m height."""

    T: float = 4.0
    times_s: tuple[float, ...] = (0.0, 1.0, 2.0, 3.0, 4.0)
    certified: bool = True
    violation_N: float = 0.0
    mode: str = "paper"
    warnings: tuple[str, ...] = ()
    vehicle: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(rotor=SimpleNamespace(thrust_min_N=-3.0, thrust_max_N=3.0))
    )
    rotor_min: tuple[float, ...] = (0.3,) * 4
    rotor_max: tuple[float, ...] = (2.5,) * 4
    saved: list[Path] = field(default_factory=list)

    @property
    def trajectory(self) -> Circle:
        return self

    @property
    def waypoints(self) -> list[SimpleNamespace]:
        return [SimpleNamespace(position=tuple(point[:3])) for point in self.at(np.array(self.times_s))]

    def at(self, t: np.ndarray) -> np.ndarray:
        """(..., 4) position and yaw."""
        turn = 2 * np.pi * np.asarray(t) / self.T
        return np.stack([2 * np.cos(turn), 2 * np.sin(turn), 2 + 0.5 * np.sin(2 * turn), 0 * turn], axis=-1)

    def save(self, path: Path) -> None:
        self.saved.append(path)


def fly_circle(
    path: Path,
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0),
    start_s: float = 3.0,
    hand_back_s: float = 7.01,
    disarm_s: float = 9.5,
    thrust_peak: float = 2.5,
) -> Path:
    """Writes the log of a flight that keeps `offset` from the circle; armed from 1 s, ended after 10 s."""
    plan, rows = Circle(), {name: [] for name in TOPICS}
    for ms in range(0, 10_000, 2):
        t = ms / 1000
        p = plan.at(np.clip(t - start_s, 0, plan.T))[:3] + offset
        p[2] *= np.clip(t - 1, 0, 2) / 2 * np.clip(9.5 - t, 0, 2) / 2 if not start_s <= t <= start_s + plan.T else 1
        phase = np.clip((t - start_s - 1.5), 0, 1)
        roll = 2 * np.pi * phase**3 * (10 - 15 * phase + 6 * phase**2)
        q = (np.cos(roll / 2), np.sin(roll / 2), 0.0, 0.0)
        w = (2 * np.pi * 30 * phase**2 * (1 - phase) ** 2, 0.0, 0.0)
        thrust = [
            1.4 + (thrust_peak - 1.4) * np.sin(2 * np.pi * (t - start_s) / plan.T + k * np.pi / 2) for k in range(4)
        ]
        if not start_s <= t <= start_s + plan.T:
            thrust = [1.4] * 4
        us = ms * 1000
        rows["vehicle_truth"].append((us, *p, 0, 0, 0, *q, *w, *thrust))
        rows["rotor_commands"].append((us, *thrust))
        if ms % 10 == 0:
            rows["attitude_reference"].append((us, *q, *w, 5.6))
        rows["vehicle_state"].append((us, OFFBOARD if start_s - 0.5 <= t < hand_back_s else MISSION, 1 <= t < disarm_s))
    info = {"vehicle": "mit-vp", "scenario": "ideal", "seed": "7", "commands_sha256": "ab" * 32}
    path.write_bytes(ulog_bytes(rows, info))
    return path


@pytest.fixture
def circle() -> Circle:
    return Circle()


@pytest.fixture(name="fly_circle")
def _fly_circle() -> Callable[..., Path]:
    return fly_circle


@pytest.fixture(name="ulog_bytes")
def _ulog_bytes() -> Callable[..., bytes]:
    return ulog_bytes
