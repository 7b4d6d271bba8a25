"""What the MAVLink side costs: instructions of a firmware step under full traffic, and how long a mission uploads.

Why: a late step and a slow transfer are what people notice of a link. Figures like those of bench.py.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1]))

from system.contract.aircraft import Aircraft
from system.contract.lossy_link import upload_over
from system.contract.missions import TAKEOFF_ITEM, waypoint
from system.gcs import ACCEPTED, Gcs
from system.processes import simulator

ROOT = Path(__file__).parents[2]
PROGRAM = ROOT / "build" / "editable" / "tests" / "cpp" / "bench" / "step_instructions"
STEP = "halfroll::Autopilot::step(halfroll::Inputs const&)"
STEPS = 4000
ITEMS = [TAKEOFF_ITEM, *[waypoint(float(n % 40), float(n % 7)) for n in range(199)]]

Figure = dict[str, object]


def step_instructions(steps: int = STEPS) -> list[int]:
    """Of each of the last steps, in which three clients talk in every millisecond. Needs valgrind."""
    with tempfile.TemporaryDirectory() as folder:
        counts = Path(folder) / "callgrind.out"
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={counts}", "--combine-dumps=yes"]
        command += [
            "--collect-atstart=no",
            f"--toggle-collect={STEP}",
            f"--dump-after={STEP}",
            str(PROGRAM),
            str(steps),
        ]
        subprocess.run(command, check=True, capture_output=True)
        found = [int(line.split()[1]) for line in counts.read_text().splitlines() if line.startswith("summary:")]
    return found[-steps - 1 : -1]  # the last one is what came after the last step


def instruction_figures() -> list[Figure]:
    if shutil.which("valgrind") is None or not PROGRAM.exists():
        print("step_instructions: not counted, that needs valgrind and the C++ tests built", file=sys.stderr)
        return []
    counts = sorted(step_instructions())
    median, p999 = counts[len(counts) // 2], counts[int(0.999 * (len(counts) - 1))]
    return [
        {"name": "step_full_traffic_median_instructions", "value": median, "unit": ""},
        {"name": "step_full_traffic_p999_instructions", "value": p999, "unit": ""},
        {"name": "step_full_traffic_p999_over_median", "value": p999 / median, "unit": "x"},
    ]


def upload_figures() -> list[Figure]:
    """200 items: over loopback by the wall clock; over a radio that loses one datagram in ten, in vehicle time."""
    with simulator("--scenario", "ideal") as (_, instance), Gcs(instance) as gcs:
        gcs.until(lambda m: m.get_type() == "HEARTBEAT")
        began = time.perf_counter()
        assert gcs.upload(ITEMS) == ACCEPTED
        loopback = time.perf_counter() - began
    grounded = Aircraft.new()
    grounded.fly(1.5)
    lossy = [upload_over(grounded.copy(), ITEMS, seed, loss=0.1, delay_ms=(1, 12)) for seed in range(5)]
    return [
        {"name": "upload_200_loopback_s", "value": loopback, "unit": "s"},
        {"name": "upload_200_lossy_worst_s", "value": max(lossy), "unit": "s"},
    ]
