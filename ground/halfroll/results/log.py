"""A flight's log: ULog file to arrays.

Why: the only place that knows the file format; reports and replays see topics of named arrays in vehicle time.
"""

from __future__ import annotations

import contextlib
import io
import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll.errors import InputError
from halfroll.reading import open_regular

Array = NDArray[Any]
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
class Log:
    """What one flight left: topics, what the writer said about it (`info`), the autopilot's parameters at the start."""

    path: Path
    topics: Mapping[str, Topic]
    info: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    damaged: bool = False  # parts of the file could not be read

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
            ulog = ULog(file)
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
    )


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
