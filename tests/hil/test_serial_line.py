"""A mission flown on the emulated board with the offboard link on its UART: every byte of it goes by the line."""

from __future__ import annotations

import os
import select
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from halfroll.boards import command
from hil.flights import SITL
from system.gcs import ACCEPTED, Gcs, Item
from system.processes import HALFROLL, Running, free_instance

pytestmark = pytest.mark.long

HOME = (473977420, 85455940)
NAN = float("nan")


def item(command_: int, north_degE7: int, east_degE7: int, height: float) -> Item:
    return (3, command_, 1, (0.0, 0.0, 0.0, NAN), HOME[0] + north_degE7, HOME[1] + east_degE7, height)


MISSION = [item(22, 0, 0, 3.0), item(16, 500, 0, 4.0), item(16, 500, 700, 3.0), item(21, 500, 700, 0.0)]


@contextmanager
def serial_cable() -> Iterator[tuple[str, str]]:
    """Two serial ports, joined."""
    pairs = [os.openpty(), os.openpty()]
    for _, port in pairs:
        tty.setraw(port)
    ends = [pairs[0][0], pairs[1][0]]
    ended = threading.Event()

    def carry() -> None:
        while not ended.is_set():
            ready, _, _ = select.select(ends, [], [], 0.1)
            for end in ready:
                os.write(ends[1 - ends.index(end)], os.read(end, 4096))

    carrier = threading.Thread(target=carry)
    carrier.start()
    try:
        yield os.ttyname(pairs[0][1]), os.ttyname(pairs[1][1])
    finally:
        ended.set()
        carrier.join()
        for pair in pairs:
            for each in pair:
                os.close(each)


def test_a_mission_is_flown_end_to_end_over_the_serial_line(tmp_path: Path) -> None:
    instance = free_instance()
    with serial_cable() as (of_board, of_ground):
        board = command("qemu-m4", more=["-serial", of_board])
        words = ("--instance", str(instance), "--lockstep", "--storage", tmp_path, "--board", board)
        with (
            Running(SITL, *words) as sitl,
            Running(HALFROLL, "ground", "--serial", of_ground) as ground,
        ):
            sitl.until_it_says("ready")
            with Gcs(instance) as gcs:
                assert gcs.upload(MISSION) == ACCEPTED
                ground.until_it_says("plan ready")
                gcs.arm()
                assert gcs.command(300) == ACCEPTED
                gcs.until_landed()
            ground.until_it_says("the plan is flown")
