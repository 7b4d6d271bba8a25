"""Claims: what the paper says, what came out here, how far apart they may be.

Why: one shape for everything that `halfroll paper` prints, stores and judges; a figure's module only measures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

Number = float | tuple[float, ...]


@dataclass(frozen=True)
class Claim:
    """id: figure and letter, as in docs/paper.md, with what is measured after a dot where there are several.

    paper: what it prints, or what its figures show to a reader with a ruler; None where it gives no number. tolerance:
    in words, with the number that `got` is held against. note: how it was measured, or why it cannot hold.
    """

    id: str
    what: str
    paper: Number | None
    got: Number
    unit: str
    tolerance: str
    holds: bool
    note: str = ""


def near(
    id: str,
    what: str,
    got: ArrayLike,
    wanted: ArrayLike,
    unit: str = "",
    *,
    off: float | None = None,
    share: float | None = None,
    paper: ArrayLike | None = None,
    note: str = "",
) -> Claim:
    """`got` no farther than `off`, or `share` of it, from `wanted`: numbers, or several that all have to be."""
    target = np.asarray(wanted, dtype=float)
    allowed = np.full_like(target, off) if share is None else share * np.abs(target)
    holds = bool(np.all(np.abs(np.asarray(got, dtype=float) - target) <= allowed + 1e-12))
    spread = f"± {off:g}" if share is None else f"± {100.0 * share:g} %"
    words = f"{shown(_number(target))} {spread}"
    return Claim(id, what, _maybe(paper), _number(got), unit, words, holds, note)


def between(
    id: str,
    what: str,
    got: ArrayLike,
    low: float,
    high: float,
    unit: str = "",
    *,
    paper: ArrayLike | None = None,
    note: str = "",
) -> Claim:
    """Every number of `got` from low to high."""
    found = np.asarray(got, dtype=float)
    holds = bool(np.all((found >= low) & (found <= high)))
    return Claim(id, what, _maybe(paper), _number(got), unit, f"{low:g} to {high:g}", holds, note)


def below(
    id: str, what: str, got: float, limit: float, unit: str = "", *, paper: ArrayLike | None = None, note: str = ""
) -> Claim:
    return Claim(id, what, _maybe(paper), float(got), unit, f"< {limit:g}", bool(got < limit), note)


def above(
    id: str, what: str, got: float, limit: float, unit: str = "", *, paper: ArrayLike | None = None, note: str = ""
) -> Claim:
    return Claim(id, what, _maybe(paper), float(got), unit, f"> {limit:g}", bool(got > limit), note)


def shown(number: Number | None) -> str:
    """Five significant digits; nothing for None."""
    if number is None:
        return ""
    if isinstance(number, tuple):
        return ", ".join(shown(one) for one in number)
    return f"{number:.5g}"


def _number(found: ArrayLike) -> Number:
    numbers: Sequence[float] = np.atleast_1d(np.asarray(found, dtype=float)).tolist()
    return numbers[0] if len(numbers) == 1 else tuple(numbers)


def _maybe(found: ArrayLike | None) -> Number | None:
    return None if found is None else _number(found)
