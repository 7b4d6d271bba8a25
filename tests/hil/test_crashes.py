"""A board that falls starts again by itself and tells why by MAVLink.

What makes it fall is done to it from outside, by the debugger's protocol: its program counter is bent.
"""

from __future__ import annotations

import re
import socket
import subprocess
from pathlib import Path

import pytest

from halfroll.boards import EMULATED, command
from hil.flights import SITL
from system.gcs import Gcs
from system.processes import Running, free_instance

NOWHERE = 0x30000000  # no memory there


def endless_loop() -> int:
    """Address of an instruction that jumps to itself."""
    code = subprocess.run(
        ["arm-none-eabi-objdump", "-d", EMULATED["qemu-m4"].image], capture_output=True, text=True, check=True
    ).stdout
    found = re.search(r"^\s*([0-9a-f]+):\s+e7fe\s", code, re.MULTILINE)
    assert found is not None
    return int(found[1], 16)


class Debugger:
    """The debugger's side of the remote serial protocol, as far as it is needed; the processor stands meanwhile."""

    def __init__(self, stub: Path) -> None:
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(30.0)
        self._socket.connect(str(stub))
        self.ask("?")

    def __enter__(self) -> Debugger:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def ask(self, packet: str) -> str:
        self._socket.sendall(f"+${packet}#{sum(packet.encode()) % 256:02x}".encode())
        said = b""
        while (found := re.search(rb"\+\$([^#]*)#..", said)) is None:
            said += self._socket.recv(65536)
        return found[1].decode()


def bend_program_counter(stub: Path, address: int) -> None:
    """Stop the processor, set it there, let it go on."""
    with Debugger(stub) as debugger:
        registers, at = debugger.ask("g"), 8 * 15
        bent = registers[:at] + address.to_bytes(4, "little").hex() + registers[at + 8 :]
        assert debugger.ask("G" + bent) == "OK"
        assert debugger.ask("D") == "OK"


@pytest.mark.parametrize(
    ("address", "told"),
    [(lambda: NOWHERE, "Board: fault at 0x30000000, restarted"), (endless_loop, "Board: hung at 0x{:08x}, restarted")],
    ids=["a jump to nowhere", "an endless loop"],
)
def test_a_board_that_falls_starts_again_and_says_where(address, told: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    instance, stub, where = free_instance(), tmp_path / "stub", address()
    board = command("qemu-m4", more=["-gdb", f"unix:{stub},server=on,wait=off"])
    with Running(SITL, "--instance", str(instance), "--board", board) as running:
        running.until_it_says("ready")
        with Gcs(instance) as gcs:
            gcs.until(lambda m: m.get_type() == "HEARTBEAT")
            bend_program_counter(stub, where)
            expected = told.format(where)
            gcs.until(lambda _: expected in gcs.texts, gcs.heartbeat())
