"""One source, the same bits: the simulator's process, the Python module, a Cortex-M4F and a Cortex-M7.

Each board flies beside the simulator's own firmware on the same inputs; rotor commands, a checksum of the whole state
and every MAVLink frame are compared in every millisecond.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from hil.flights import Report, flip_flight, mission_flight

LONG_S = 75.0


def _is_the_same(flown: Report, least_steps: int) -> None:
    assert flown.figures["compared"]
    assert flown.figures["steps"] >= least_steps
    assert flown.figures["differing_bits"] == 0
    assert flown.figures["differing_frames"] == 0


def test_a_flip_on_the_cortex_m4_has_the_simulators_bits(short_flip: Report) -> None:
    _is_the_same(short_flip, 14000)


@pytest.mark.long
@pytest.mark.parametrize("board", ["qemu-m4", "qemu-m7", "python"])
def test_more_than_a_minute_with_flips_differs_in_no_bit(board: str) -> None:
    flown = flip_flight(board, LONG_S)
    _is_the_same(flown, 70000)
    assert flown.figures["late_steps"] == 0


@pytest.mark.long
def test_a_mission_flown_on_a_board_has_the_hash_of_the_flight_in_the_simulator(tmp_path: Path) -> None:
    here, there = mission_flight(None, tmp_path), mission_flight("qemu-m4", tmp_path)
    assert there.commands_sha256 == here.commands_sha256
    _is_the_same(there, 10000)
