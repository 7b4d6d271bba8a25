"""Boards that can fly in place of the firmware in the simulator's process. Why: a name is all that a person types, and
what has to be started for it stands here.

A board is a program that answers the simulator's frames (firmware/boards/hil/frames.hpp) by its standard input and
output.
"""

from __future__ import annotations

import shlex
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from halfroll.errors import InputError, LinkError

INSTRUCTION_NS = 8  # of emulated time, QEMU's -icount shift=3: 125 million a second


@dataclass(frozen=True)
class Emulated:
    """A board that QEMU emulates, and the CMake preset of its image."""

    machine: str
    preset: str

    @property
    def image(self) -> Path:
        return Path(__file__).parents[2] / "build" / self.preset / "halfroll-board.elf"


EMULATED = {"qemu-m4": Emulated("mps2-an386", "cortex-m4"), "qemu-m7": Emulated("mps2-an500", "cortex-m7")}
NAMES = (*EMULATED, "python")


def command(board: str, more: Sequence[str] = (), words: Sequence[str] = ("flash.bin",)) -> str:
    """What halfroll-sitl starts for a board: a name of NAMES, else `board` is that command itself.

    more: further options of QEMU; words: of the image's command line after its pipes. Raises InputError, LinkError."""
    if board == "python":
        serve = "from halfroll._firmware import serve_board; serve_board(0, 1, '.')"
        return shlex.join([sys.executable, "-c", serve])
    if board not in EMULATED:
        if " " not in board:
            raise InputError(f"board {board!r} is not known; give {', '.join(NAMES)} or a command that speaks for one")
        return board
    emulated = EMULATED[board]
    qemu = shutil.which("qemu-system-arm")
    if qemu is None:
        raise LinkError("qemu-system-arm is not installed: sudo apt-get install qemu-system-arm")
    if not emulated.image.is_file():
        raise LinkError(f"the image {emulated.image} is not built; run `make boards`")
    arguments = ["halfroll", "/dev/fd/0", "/dev/fd/1", *words]
    semihosting = ",".join(["enable=on", "target=native", *(f"arg={word}" for word in arguments)])
    return shlex.join(
        [
            *(qemu, "-M", emulated.machine, "-display", "none", "-monitor", "none"),
            *(more if "-serial" in more else ["-serial", "none", *more]),
            *("-icount", "shift=3,sleep=off", "-semihosting-config", semihosting, "-kernel", str(emulated.image)),
        ]
    )


def arguments(board: str | None, beside: bool = False) -> list[str]:
    """Of halfroll-sitl; none for no board. beside: the firmware flies in the simulator, too, and is compared."""
    if board is None:
        return []
    return ["--board", command(board), *(["--board-beside"] if beside else [])]
