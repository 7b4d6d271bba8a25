"""Files of the user's, read whole. Why: what is named may be a pipe, a device or a disk image, so nothing is read that
is no regular file, and nothing that is larger than any mission, vehicle or plan."""

from __future__ import annotations

import errno
import json
import os
import stat
import sys
import zipfile
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MOST_BYTES = 64 * 2**20  # ten times the largest plan


def open_regular(path: str | Path) -> BinaryIO:
    """Opened for reading. Raises OSError, also for what is no regular file: its end may never come."""
    file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)  # a pipe is not waited for
    kind = os.fstat(file).st_mode
    if stat.S_ISREG(kind):
        return os.fdopen(file, "rb")
    os.close(file)
    if stat.S_ISDIR(kind):
        raise IsADirectoryError(errno.EISDIR, "it is a folder")
    raise OSError(errno.EINVAL, "it is a device or a pipe, not a regular file")


def read_bytes(path: str | Path) -> bytes:
    """Raises OSError, also for what is no regular file or too large to be what it is taken for."""
    with open_regular(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > MOST_BYTES:
            raise OSError(errno.EFBIG, f"it has {size / 2**20:.0f} MB, at most {MOST_BYTES / 2**20:.0f} are read")
        return stream.read(MOST_BYTES)


def read_text(path: str | Path, encoding: str = "utf-8") -> str:
    """The same as text. Raises OSError, and UnicodeDecodeError for what is none."""
    return read_bytes(path).decode(encoding).replace("\r\n", "\n")


def parse_json(text: str | bytes) -> Any:
    """What a JSON text says. Raises ValueError for what is none, and for what is nested deeper than Python follows."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def parse_toml(text: str) -> dict[str, Any]:
    """The same of TOML; an integer of thousands of digits is none, either."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def read_arrays(path: str | Path, names: Sequence[str]) -> list[NDArray[np.float64]]:
    """Arrays of an .npz file by name, text ones as they are. Raises OSError, and ValueError for everything that is no
    such archive, pickled objects and archives that grow beyond MOST_BYTES among it."""
    archive = BytesIO(read_bytes(path))
    try:
        with zipfile.ZipFile(archive) as members:
            size = sum(member.file_size for member in members.infolist())
        if size > MOST_BYTES:
            raise ValueError(f"unpacked it has {size / 2**20:.0f} MB, at most {MOST_BYTES / 2**20:.0f} are read")
        archive.seek(0)
        with np.load(archive, allow_pickle=False) as stored:
            return [stored[name] for name in names]
    except (zipfile.BadZipFile, NotImplementedError, EOFError, MemoryError, RuntimeError, KeyError) as error:
        raise ValueError(f"no archive of {', '.join(names)}: {error}") from None
