"""Small scenario spaces for the tests of campaigns."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from halfroll.campaign.space import make_space

EXAMPLES = Path(__file__).parents[2] / "examples"
HOP = """name = "hop"
frame = "local"
[[waypoint]]
position_m = [0, 0, 1]
[[waypoint]]
position_m = [1.5, 0.5, 1.5]
"""


def hop_space(folder, **changes):
    """Two metres from rest to rest, planned in a moment."""
    (folder / "hop.toml").write_text(HOP)
    table = {
        "mission": "hop.toml",
        "scenario": "nominal",
        "sampling": "random",
        "seed": 3,
        "runs": 20,
        "hold_s": 0.2,
        "plan": {"mode": "paper"},
        "vary": {"vehicle.mass_kg": {"uniform": [0.9, 1.1], "times": True}},
    }
    return make_space({**table, **changes}, folder)


def dies(block):
    """In the place of flying a block: ends its process."""
    os.kill(os.getpid(), signal.SIGKILL)
