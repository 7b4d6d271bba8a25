"""The power fails at any moment while the board writes its flash pages: old or new, never a mixture.

The board itself goes dark after so many programmed pieces or erased pages, counted, so every moment of a write has its
turn: the erase, the image, the header, and between two images.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from halfroll.boards import command
from hil.flights import SITL
from system.generations import Killed, Store, Writer
from system.processes import Running, free_instance

pytestmark = pytest.mark.long

CUTS = 200
MOST_OPERATIONS = 120  # parameters take 20 or so, a mission 40


def test_whatever_the_moment_of_the_cut_no_record_is_lost(tmp_path: Path) -> None:
    chance = random.Random(7)
    store, instance = Store(), free_instance()
    for cut in range(CUTS + 1):
        last = cut == CUTS
        words = ("flash.bin",) if cut == 0 or last else ("flash.bin", str(chance.randint(1, MOST_OPERATIONS)))
        given = ("--instance", str(instance), "--speed", "0", "--storage", tmp_path)
        with Running(SITL, *given, "--board", command("qemu-m4", words=words)) as running:
            running.until_it_says("ready")
            with Writer(instance, running) as client:
                if cut == 0:
                    store.write(client, 0)
                    continue
                store.check(client)
                if last:
                    return
                with pytest.raises(Killed):
                    store.write_on(client)
