"""halfroll: minimum-time flight of quadrotors whose rotors may push both ways.

Why: the public names, each imported only when it is used, so that `halfroll --help` and the autopilot alone stay light.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfroll import errors
    from halfroll._firmware import Autopilot, OuterLoop, World
    from halfroll.errors import HalfrollError
    from halfroll.flight import fly
    from halfroll.log import read_log
    from halfroll.mission_files import load_mission
    from halfroll.preflight import check
    from halfroll.vehicle import load_vehicle

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
]

_HOME = {  # public name -> module that defines it
    "Autopilot": "_firmware",
    "HalfrollError": "errors",
    "OuterLoop": "_firmware",
    "World": "_firmware",
    "check": "preflight",
    "fly": "flight",
    "load_mission": "mission_files",
    "load_vehicle": "vehicle",
    "read_log": "log",
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
    if name in ("errors", "plan"):
        return import_module(f"halfroll.{name}")
    raise AttributeError(f"module 'halfroll' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


class _PlanModule(ModuleType):
    """`halfroll.plan` is the module of plans, and halfroll.plan(mission) makes one."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return import_module("halfroll.preflight").plan(*args, **kwargs)


class _Package(ModuleType):
    def __setattr__(self, name: str, attribute: Any) -> None:
        if name == "plan" and isinstance(attribute, ModuleType):
            attribute.__class__ = _PlanModule
        super().__setattr__(name, attribute)


sys.modules[__name__].__class__ = _Package
