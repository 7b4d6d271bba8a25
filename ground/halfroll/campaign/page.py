"""The report of a campaign: one self-contained HTML page, and its pictures.

Why: what a folder of Parquet says at a glance, for those who were not there. It draws from columns, never from flights.
"""

from __future__ import annotations

import html
import io
import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import halfroll
from halfroll.campaign.sensitivity import Sensitivity, sensitivities
from halfroll.campaign.statistics import Summary, column, in_words, interval, summary_of
from halfroll.drawing import ON_PAPER, style

if TYPE_CHECKING:
    import pyarrow as pa
    from matplotlib.axes import Axes

    from halfroll.campaign.space import Space

FloatArray = NDArray[np.float64]
_BINS = 8
_PAGE = Template("""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>$title</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2433; max-width: 68em; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
table { border-collapse: collapse } td, th { padding: .2em 1em .2em 0; text-align: right } th { color: #8a94a6 }
td:first-child, th:first-child, td.words { text-align: left }
code { font-size: .9em } svg { max-width: 100%; height: auto }
</style></head><body>
<h1>$title</h1><p>$lead</p>
$sections
<p style="color:#8a94a6">halfroll $version</p>
</body></html>
""")


def write_page(path: Path, space: Space, runs: pa.Table, replay: str) -> None:
    """replay: the command of one run, {run} in it."""
    summary = summary_of(runs)
    low, high = summary.confidence
    lead = (
        f"{summary.succeeded} of {summary.runs} runs succeeded: {summary.rate:.2%}, with 95 % confidence {low:.2%} to "
        f"{high:.2%}. {summary.flight_s:.0f} s of flight. {html.escape(space.told.description)}"
    )
    found = sensitivities(space, runs)
    sections = [
        _section("Figures", _quantiles(summary), _drawn(lambda axes: _histograms(axes, runs), 1, 3)),
        _section("Why runs failed", _table(("reason", "runs"), summary.reasons)) if summary.failed else "",
        _section("Success against what varies", _drawn(*_success(space, runs))) if _numeric(space) else "",
        _section("What matters", *[_sensitivity(each) for each in found]) if found else "",
        _section(
            "The worst runs",
            _table(
                ("run", "waypoint miss", "again"),
                [
                    (str(run), in_words(miss), f"<code>{html.escape(replay.format(run=run))}</code>")
                    for run, miss in summary.worst
                ],
                escaped=True,
            ),
        ),
    ]
    page = _PAGE.substitute(
        title=html.escape(space.told.name), lead=lead, sections="\n".join(sections), version=halfroll.__version__
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding="utf-8")


def _section(title: str, *parts: str) -> str:
    return f"<h2>{title}</h2>\n" + "\n".join(parts)


def _table(head: Sequence[str], rows: Sequence[Sequence[Any]], escaped: bool = False) -> str:
    def cell(value: Any) -> str:
        return str(value) if escaped else html.escape(str(value))

    lines = ["<tr>" + "".join(f"<th>{name}</th>" for name in head) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{cell(value)}</td>" for value in row) + "</tr>" for row in rows]
    return "<table>" + "\n".join(lines) + "</table>"


def _quantiles(summary: Summary) -> str:
    names = list(next(iter(summary.quantiles.values()), {}))
    head = ("", *(f"{100 * float(q):g} %" for q in names))
    return _table(head, [(name, *(f"{values[q]:.4g}" for q in names)) for name, values in summary.quantiles.items()])


def _sensitivity(found: Sensitivity) -> str:
    first = found.first or {}
    how = (
        "Sobol indices, total and first order"
        if found.method == "sobol"
        else f"permutation importance, share of the variance; the model explains {found.explained or 0.0:.0%} of it"
    )
    rows = [
        (key, f"{share:.3f}", *([f"{first[key]:.3f}"] if first else []))
        for key, share in sorted(found.shares.items(), key=lambda pair: -pair[1])
    ]
    head = (found.output, "total", "first") if first else (found.output, "share")
    return f"<p>{how}:</p>" + _table(head, rows)


def _drawn(draw: Callable[[Any], None], rows: int, columns: int) -> str:
    """An SVG in the page."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with mpl.rc_context(style(ON_PAPER)):
        figure = Figure(figsize=(3.6 * columns, 2.6 * rows), layout="constrained")
        FigureCanvasSVG(figure)
        draw(figure.subplots(rows, columns, squeeze=False).ravel())
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
    svg = text.getvalue()
    return svg[svg.index("<svg") :]


def _histograms(axes: Sequence[Axes], runs: pa.Table) -> None:
    for ax, (name, label) in zip(
        axes,
        (
            ("tracking_max_m", "farthest from the plan [m]"),
            ("waypoint_miss_max_m", "largest waypoint miss [m]"),
            ("rotor_saturated", "share of time at a rotor limit"),
        ),
        strict=True,
    ):
        values = column(runs, name)
        values = values[np.isfinite(values)]
        if len(values):
            ax.hist(np.minimum(values, np.quantile(values, 0.995)), bins=40, color=ON_PAPER.flown)
        ax.set_xlabel(label)
        ax.set_yticks([])


def _numeric(space: Space) -> list[str]:
    return [key for key, axis in space.axes.items() if axis.is_numeric]


def _success(space: Space, runs: pa.Table) -> tuple[Callable[[Sequence[Axes]], None], int, int]:
    keys = _numeric(space)
    columns = min(len(keys), 3)
    rows = -(-len(keys) // columns)

    def draw(axes: Sequence[Axes]) -> None:
        good = column(runs, "succeeded").astype(bool)
        for ax, key in zip(axes, keys, strict=False):
            draw_success(ax, column(runs, key), good, ON_PAPER.flown)
            ax.set_xlabel(key)
        for ax in axes[len(keys) :]:
            ax.set_visible(False)

    return draw, rows, columns


def draw_success(ax: Axes, x: FloatArray, good: NDArray[np.bool_], colour: str, label: str | None = None) -> None:
    """Success rate with its 95 % interval, in bins of x, or at each level where it has few."""
    for_levels = np.unique(x)
    if len(for_levels) <= 2 * _BINS:
        places, groups = for_levels, [x == level for level in for_levels]
    else:
        edges = np.linspace(x.min(), x.max(), _BINS + 1)
        places = (edges[1:] + edges[:-1]) / 2.0
        groups = [(x >= a) & ((x < b) | (b == edges[-1])) for a, b in itertools.pairwise(edges)]
    told = [(place, int(good[group].sum()), int(group.sum())) for place, group in zip(places, groups, strict=True)]
    told = [(place, k, n) for place, k, n in told if n]
    rate = np.array([k / n for _, k, n in told])
    bounds = np.array([interval(k, n) for _, k, n in told])
    error = np.abs(bounds - rate[:, None]).T
    ax.errorbar(
        [place for place, *_ in told], rate, error, color=colour, marker="o", ms=3.5, lw=1.2, capsize=2, label=label
    )
    ax.set_ylim(-0.03, 1.03)
    ax.set_ylabel("success")
