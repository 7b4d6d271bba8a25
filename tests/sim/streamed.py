"""Flights inside this process, by the names of shipped vehicles and scenarios and by settings as halfroll-sitl takes
them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfroll import streamed
from halfroll.scenario import load_scenario
from halfroll.station.references import Path
from halfroll.vehicle import load_vehicle


class StreamedFlight(streamed.StreamedFlight):
    def __init__(
        self,
        vehicle: str = "mit-vp",
        scenario: str = "nominal",
        settings: Sequence[str] = (),
        seed: int = 0,
        vehicle_settings: Sequence[str] = (),
    ) -> None:
        overrides = dict(setting.split("=") for setting in vehicle_settings)
        super().__init__(load_vehicle(vehicle, overrides), load_scenario(scenario), seed, settings)

    def follow(self, path: Path, seconds: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times since the start (N,) and true positions (N, 3), every tick."""
        flown = super().follow(path, seconds, streamed.TICK_MS)
        return flown.t, flown.p_WB
