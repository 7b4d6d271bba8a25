"""halfroll's commands as a person starts them, and what is left of them afterwards.

Why: a system test sees exit codes, the two output streams and the process table, nothing inside. Everything started
here carries a mark in its environment, which its children inherit, so whoever is left behind is found.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HALFROLL = Path(sys.executable).with_name("halfroll")
EXAMPLES = Path(__file__).parents[2] / "examples"
MISSIONS = Path(__file__).parent / "missions"

DEADLINE_S = 240.0  # a hanging process fails its test; nothing is judged by how long it took
_MARK = "HALFROLL_TEST_MARK"
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")


@dataclass(frozen=True)
class Ended:
    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one object on standard output."""
        (line,) = self.out.splitlines()
        found: dict[str, Any] = json.loads(line)
        return found

    @property
    def sentences(self) -> list[str]:
        """Lines of standard error that are errors."""
        return [line.removeprefix("error: ") for line in self.err.splitlines() if line.startswith("error: ")]


class Running:
    """A command in a session of its own, as in a terminal of its own."""

    def __init__(self, *words: str | Path, cwd: Path | None = None, **environment: str) -> None:
        self._mark = uuid.uuid4().hex
        self.process = subprocess.Popen(
            [str(word) for word in words],
            cwd=cwd,
            env={**os.environ, _MARK: self._mark, "PYTHONUNBUFFERED": "1", **environment},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._lines: dict[str, list[str]] = {"out": [], "err": []}
        self._more = threading.Condition()
        self._readers = [
            threading.Thread(target=self._read, args=(name, stream), daemon=True)
            for name, stream in (("out", self.process.stdout), ("err", self.process.stderr))
        ]
        for reader in self._readers:
            reader.start()

    def _read(self, name: str, stream: Any) -> None:
        with stream:
            for line in stream:
                with self._more:
                    self._lines[name].append(_COLOURS.sub("", line))
                    self._more.notify_all()

    def _text(self, name: str) -> str:
        return "".join(self._lines[name])

    @property
    def said(self) -> str:
        """So far, on both streams."""
        return self._text("out") + self._text("err")

    def until_it_says(self, words: str) -> None:
        """On either stream."""

        def said() -> bool:
            return words in self.said

        until = time.monotonic() + DEADLINE_S
        with self._more:
            while not said() and time.monotonic() < until and any(reader.is_alive() for reader in self._readers):
                self._more.wait(timeout=0.1)
            assert said(), f"never said {words!r}: {self._lines}"

    def wait(self) -> Ended:
        code = self.process.wait(DEADLINE_S)
        for reader in self._readers:  # ends when the last process that holds the streams does
            reader.join(DEADLINE_S)
        return Ended(code, self._text("out"), self._text("err"))

    def members(self) -> dict[int, str]:
        """Every living process of this command: id to command line."""
        found = {}
        for folder in Path("/proc").iterdir():
            with contextlib.suppress(OSError, ValueError):
                if f"{_MARK}={self._mark}".encode() in (folder / "environ").read_bytes():
                    found[int(folder.name)] = command_line(int(folder.name))
        return found

    def member(self, words: str) -> int:
        """The one process whose command line holds these words."""
        (found,) = (number for number, line in self.members().items() if words in line)
        return found

    def left_behind(self) -> dict[int, str]:
        """Who lives on after the command has ended, a moment for the kernel to bury the others granted."""
        for _ in range(50):
            if not self.members():
                return {}
            time.sleep(0.1)
        return self.members()

    def interrupt(self, group: bool) -> None:
        """Ctrl-C in a terminal reaches the whole group; a supervisor's signal one process."""
        (os.killpg if group else os.kill)(self.process.pid, signal.SIGINT)

    def __enter__(self) -> Running:
        return self

    def __exit__(self, *_: object) -> None:
        for number in (self.process.pid, *self.members()):
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
        self.wait()


def command_line(number: int) -> str:
    """Of a living process; empty when it is gone."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{number}/cmdline").read_bytes().replace(b"\0", b" ").decode()
    return ""


def descendants(number: int) -> list[int]:
    """Children of a process, and theirs."""
    children: list[int] = []
    for folder in Path(f"/proc/{number}/task").glob("*/children"):
        children += [int(word) for word in folder.read_text().split()]
    return children + [grandchild for child in children for grandchild in descendants(child)]


def halfroll(*words: str | Path, cwd: Path | None = None, **environment: str) -> Ended:
    """One command, to its end."""
    with Running(HALFROLL, *words, cwd=cwd, **environment) as running:
        return running.wait()


def is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True


def free_instance() -> int:
    """Of the simulator, with its ports and those of its peers free. From the top: `fly` takes the lowest."""
    return next(n for n in range(9, -1, -1) if all(is_free(p + n) for p in (14540, 14550, 14580, 18570, 14280)))


@contextlib.contextmanager
def simulator(*words: str | Path, instance: int | None = None) -> Iterator[tuple[Running, int]]:
    """`halfroll sitl` ready on an instance of its own."""
    number = free_instance() if instance is None else instance
    with Running(HALFROLL, "sitl", "--instance", str(number), *words) as running:
        running.until_it_says("ready")
        yield running, number
