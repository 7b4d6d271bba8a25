"""`make hil`: fly on every board, print and write what it takes.

The mission of the README, and a flight with flips of more than a minute, each beside the simulator's own firmware.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from halfroll.boards import EMULATED
from hil.flights import flip_flight, mission_flight, sizes
from hil.stack_depth import deepest_chain

FLIP_S = 75.0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    output: Path = parser.parse_args().output
    boards, good = [], True
    with tempfile.TemporaryDirectory() as folder:
        here = mission_flight(None, Path(folder))
        print(f"mission  sitl     commands_sha256 {here.commands_sha256}")
        for board in ("qemu-m4", "qemu-m7"):
            mission, flips = mission_flight(board, Path(folder)), flip_flight(board, FLIP_S)
            print(f"mission  {board:8} commands_sha256 {mission.commands_sha256}")
            both = (mission.figures, flips.figures)
            figures = {
                "name": board,
                "steps": sum(each["steps"] for each in both),
                "differing_bits": sum(each["differing_bits"] for each in both),
                "differing_frames": sum(each["differing_frames"] for each in both),
                "median_instructions": max(each["median_instructions"] for each in both),
                "p999_instructions": max(each["p999_instructions"] for each in both),
                "worst_instructions": max(each["worst_instructions"] for each in both),
                "late_steps": sum(each["late_steps"] for each in both),
                "stack_bytes": max(each["stack_bytes"] for each in both),
                "stack_chain_bytes": deepest_chain(EMULATED[board].image.parent)[0],
                **sizes(board),
                "commands_sha256": mission.commands_sha256,
            }
            boards.append(figures)
            good = good and mission.commands_sha256 == here.commands_sha256 and figures["differing_bits"] == 0
    for name in boards[0]:
        print(f"{name:22}" + "".join(f"{each[name]!s:>14.14}" for each in boards))
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps({"boards": boards}, indent=2) + "\n")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
