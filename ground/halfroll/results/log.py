"""A flight's log: ULog file to arrays.

Why: the only place that knows the file format; reports and replays see topics of named arrays in vehicle time.
"""

from __future__ import annotations

import contextlib
import io
import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from halfroll.errors import InputError
from halfroll.reading import open_regular

Array = NDArray[Any]
_MOST_COLUMNS, _DEEPEST = 2000, 16  # of a topic; PX4's largest has some hundreds, in two levels
_REREAD, _REREAD_BYTES = 4, 2**26  # times the file's size, and besides: what a reader that recovers may read again
_FILE_HEADER = 16  # bytes
_INDEXED = re.compile(r"(.+)\[(\d+)\]$")


@dataclass(frozen=True)
class Topic:
    """One topic of a log: sample times and fields, all of the same length.

    t: (N,) vehicle time [s], rising. fields: name to (N,) or, for an array field, (N, k); SI, W and B as everywhere.
    """

    name: str
    t: NDArray[np.float64]
    fields: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, field_name: str) -> Array:
        """The field's samples. Raises InputError if the topic has no such field."""
        try:
            return self.fields[field_name]
        except KeyError:
            raise InputError(
                f"topic {self.name} has no field {field_name}, only {', '.join(self.fields)}; "
                "was this log written by halfroll-sitl?"
            ) from None


@dataclass(frozen=True)
class LoggedText:
    """A line that was said; severity as in syslog, 0 emergency to 7 debug."""

    t_s: float
    severity: int
    text: str


@dataclass(frozen=True)
class Log:
    """What one flight left: topics, what the writer said about it (`info`), the autopilot's parameters at the start.

    embedded: whole texts by name, as docs/logs.md lists them: mission_file, vehicle_numbers, plan, outcome, …; texts:
    what autopilot, simulator and ground station said, in order; changed: parameters set in flight, with the time [s].
    """

    path: Path
    topics: Mapping[str, Topic]
    info: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    damaged: bool = False  # parts of the file could not be read
    embedded: Mapping[str, str] = field(default_factory=dict)
    texts: tuple[LoggedText, ...] = ()
    changed: tuple[tuple[float, str, float], ...] = ()

    def __getitem__(self, topic: str) -> Topic:
        """The topic of that name. Raises InputError if it was not logged."""
        try:
            return self.topics[topic]
        except KeyError:
            raise InputError(
                f"{self.path}: nothing was logged as {topic}; there is {', '.join(sorted(self.topics)) or 'nothing'}"
            ) from None

    def __contains__(self, topic: object) -> bool:
        return topic in self.topics

    def __iter__(self) -> Iterator[str]:
        return iter(self.topics)


def read_log(path: str | Path) -> Log:
    """The log at `path`; one cut short by a crash is read as far as it goes.

    Raises InputError when there is no such file, it is no ULog, or it ends before the first sample.
    """
    from pyulog import ULog, ULogException

    path = Path(path)
    try:
        with open_regular(path) as file, contextlib.redirect_stdout(io.StringIO()):  # pyulog prints what it skips
            _require_finite(file, ULog.MessageFormat)
            ulog = ULog(_Patience(file))
        topics = {
            columns.name: _topic(columns.name, columns.data) for columns in ulog.data_list if columns.multi_id == 0
        }
    except OSError as error:
        raise InputError(f"{path}: the log cannot be read: {error.strerror or error}; check the name") from None
    except (ULogException, struct.error, ArithmeticError, LookupError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: not a ULog file, or damaged beyond reading ({error})") from error
    if not any(len(topic) for topic in topics.values()):
        raise InputError(f"{path}: the log ends before its first sample; the simulator was stopped before it flew")
    return Log(
        path,
        MappingProxyType(topics),
        MappingProxyType(dict(ulog.msg_info_dict)),
        MappingProxyType(dict(ulog.initial_parameters)),
        bool(ulog.file_corruption),
        MappingProxyType({key: _whole(sets[-1]) for key, sets in ulog.msg_info_multiple_dict.items()}),
        tuple(
            LoggedText(said.timestamp * 1e-6, said.log_level - ord("0"), said.message) for said in ulog.logged_messages
        ),
        tuple((t_us * 1e-6, name, float(number)) for t_us, name, number in ulog.changed_parameters),
    )


class _Patience:
    """A file that ends a reader which goes back again and again, as pyulog does where messages are damaged."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._left = _REREAD * file.seek(0, 2) + _REREAD_BYTES
        file.seek(0)
        self.seek, self.tell, self.close = file.seek, file.tell, file.close

    def read(self, size: int) -> bytes:
        piece = self._file.read(size)
        self._left -= len(piece) + 1
        if self._left < 0:
            raise OverflowError("most of it is damaged")
        return piece


def _require_finite(file: BinaryIO, format_of: Callable[[bytes, None], Any]) -> None:
    """Raises ValueError for definitions of topics that a reader would never be done with: types within themselves,
    arrays of arrays of arrays."""
    formats: dict[str, list[tuple[str, int, str]]] = {}
    file.seek(_FILE_HEADER)
    while len(head := file.read(3)) == 3:
        size, kind = struct.unpack("<HB", head)
        if chr(kind) in "ALC":
            break
        body = file.read(size)
        if kind == 0 or size == 0 or len(body) < size:
            raise ValueError("its definitions are damaged")
        if chr(kind) == "F":
            with contextlib.suppress(LookupError, ValueError):  # it defines nothing
                found = format_of(body, None)
                formats[found.name] = found.fields

    def columns(name: str, depth: int) -> int:
        if depth > _DEEPEST:
            raise ValueError("a type in it holds others without end")
        count = 0
        for kind, length, _ in formats.get(name, ()):
            count += max(length, 1) * (columns(kind, depth + 1) if kind in formats else 1)
            if count > _MOST_COLUMNS:
                raise ValueError(f"a topic in it has more than {_MOST_COLUMNS} columns")
        return count

    for name in formats:
        columns(name, 0)


def _whole(pieces: Sequence[str | bytes]) -> str:
    return "".join(piece if isinstance(piece, str) else piece.decode(errors="replace") for piece in pieces)


def _topic(name: str, columns: Mapping[str, Array]) -> Topic:
    """Columns `p[0]`, `p[1]`, … become one field `p` of shape (N, k)."""
    fields: dict[str, Array] = {}
    parts: dict[str, list[Array]] = {}
    for column, samples in columns.items():
        if column == "timestamp":
            continue
        indexed = _INDEXED.match(column)
        if indexed:
            parts.setdefault(indexed[1], []).append(samples)
        else:
            fields[column] = _frozen(np.array(samples))
    fields.update((base, _frozen(np.stack(columns_of, axis=1))) for base, columns_of in parts.items())
    return Topic(name, _frozen(np.asarray(columns["timestamp"], dtype=np.float64) * 1e-6), MappingProxyType(fields))


def _frozen(samples: Array) -> Array:
    samples.setflags(write=False)
    return samples
