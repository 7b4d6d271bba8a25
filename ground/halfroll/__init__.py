"""halfroll: minimum-time flight of quadrotors whose rotors may push both ways.

Why: the public names, each imported only when it is used, so that `halfroll --help` and the autopilot alone stay light.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfroll import errors
    from halfroll._firmware import Autopilot, OuterLoop, World
    from halfroll.errors import HalfrollError
    from halfroll.flight import fly
    from halfroll.missions.mission_files import load_mission
    from halfroll.preflight import check, plan
    from halfroll.results.log import read_log
    from halfroll.vehicle import load_vehicle
    from halfroll.viewer.notebook import view

    __version__: str

__all__ = [
    "Autopilot",
    "HalfrollError",
    "OuterLoop",
    "World",
    "__version__",
    "check",
    "errors",
    "fly",
    "load_mission",
    "load_vehicle",
    "plan",
    "read_log",
    "view",
]

_HOME = {  # public name -> module that defines it
    "Autopilot": "_firmware",
    "HalfrollError": "errors",
    "OuterLoop": "_firmware",
    "World": "_firmware",
    "check": "preflight",
    "fly": "flight",
    "load_mission": "missions.mission_files",
    "load_vehicle": "vehicle",
    "plan": "preflight",
    "read_log": "results.log",
    "view": "viewer.notebook",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("halfroll")
        except PackageNotFoundError:  # run from a checkout that was never installed
            return "0+unknown"
    if name in _HOME:
        return getattr(import_module(f"halfroll.{_HOME[name]}"), name)
    if name == "errors":
        return import_module("halfroll.errors")
    raise AttributeError(f"module 'halfroll' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
