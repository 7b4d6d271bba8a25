"""One part of the paper, made again: its claims and its picture.

Why: what the modules of the figures hand over, and all that the command knows of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from halfroll.drawing import Palette
from halfroll.paper.claims import Claim


@dataclass(frozen=True)
class Part:
    title: str
    claims: tuple[Claim, ...]
    caption: str = ""
    draw: Callable[[Any, Palette], None] | None = None  # onto a matplotlib figure; some parts are numbers alone
    size: tuple[float, float] = (11.0, 6.0)  # [inch]
