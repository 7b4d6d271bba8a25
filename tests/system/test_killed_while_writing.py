"""The simulator's process is killed at any moment while it stores parameters and missions: old or new, never a mixture.

Why: a battery that comes loose asks nobody. Each start reads what the kill before has left.
"""

from __future__ import annotations

import random
import threading
from pathlib import Path

import pytest

from system.generations import Killed, Store, Writer
from system.processes import HALFROLL, Running, free_instance

pytestmark = pytest.mark.long

KILLS = 200


def test_whatever_the_moment_of_the_kill_the_store_is_whole(tmp_path: Path) -> None:
    chance = random.Random(5)
    store, instance = Store(), free_instance()
    for kill in range(KILLS + 1):
        words = ("--instance", str(instance), "--storage", tmp_path)
        with Running(HALFROLL.with_name("halfroll-sitl"), *words) as running:
            running.until_it_says("ready")
            with Writer(instance, running) as client:
                if kill == 0:
                    store.write(client, 0)
                else:
                    store.check(client)
                if kill == KILLS:
                    return
                bomb = threading.Timer(chance.uniform(0.0, 0.08), running.process.kill)
                bomb.start()
                with pytest.raises(Killed):
                    store.write_on(client)
                bomb.join()
