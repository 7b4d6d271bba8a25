"""Pictures of docs/world.md: convergence of the integrator, settling of the attitude loop.

python docs/make_world_pictures.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[1]
PICTURES = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures"
sys.path.insert(0, str(ROOT / "tests" / "sim"))


def convergence() -> None:
    from test_integrator import SUBSTEP, error_after

    steps = np.array([1e-2, 5e-3, 2e-3, 1e-3, 5e-4, SUBSTEP, 1e-4])
    errors = [error_after(1.0, h)[0] for h in steps]
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    axes.loglog(1e3 * steps, errors, "o-", label="against SciPy DOP853")
    axes.loglog(1e3 * steps, errors[0] * (steps / steps[0]) ** 4, "--", color="grey", label="slope 4")
    axes.axvline(1e3 * SUBSTEP, color="tab:red", lw=1, label="the world's step")
    axes.set(xlabel="step [ms]", ylabel="attitude error after 1 s", title="A body tumbling at 18 rad/s")
    axes.legend()
    figure.savefig(PICTURES / "world_convergence.png", dpi=110)


def settling() -> None:
    from settling import settling_times

    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for vehicle in ("mit-vp", "race-5in"):
        times = settling_times(10_000, vehicle)
        label = f"{vehicle}: {np.isfinite(times).sum()} of {len(times)}, worst {np.nanmax(times):.2f} s"
        axes.hist(times[np.isfinite(times)], bins=np.arange(0, 4, 0.05), histtype="step", label=label)
    axes.set(xlabel="settled to 2° after [s]", ylabel="runs of 10 000", title="Any attitude, any rate up to 10 rad/s")
    axes.legend()
    figure.savefig(PICTURES / "attitude_settling.png", dpi=110)


if __name__ == "__main__":
    convergence()
    settling()
