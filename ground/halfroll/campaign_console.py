"""What a person sees of a campaign. Why: a flight is told in a screen of figures, ten thousand in another."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar
from rich.table import Table
from rich.text import Text

from halfroll.campaign.statistics import in_words
from halfroll.console import console
from halfroll.wire.transport import wall_s

if TYPE_CHECKING:
    from halfroll.campaign.comparison import Difference
    from halfroll.campaign.flying import Progress
    from halfroll.campaign.gains import Trial, Tuned
    from halfroll.campaign.sensitivity import Sensitivity
    from halfroll.campaign.statistics import Summary

_TELL_EVERY_S = 10.0


@contextlib.contextmanager
def flying(runs: int) -> Iterator[Callable[[Progress], None]]:
    """Runs done, times real time, time left: a bar in a terminal, else a line now and then. On standard error."""
    began_s = told_s = wall_s()

    def words(now: Progress) -> str:
        wall = max(wall_s() - began_s, 1e-3)
        left_s = (runs - now.done) * wall / max(now.flown, 1)
        return f"{now.flown / wall:.1f} runs/s, {now.flown_s / wall:.0f}x real time, {left_s:.0f} s left"

    if not sys.stderr.isatty():

        def tell(now: Progress) -> None:
            nonlocal told_s
            if wall_s() - told_s > _TELL_EVERY_S:
                told_s = wall_s()
                print(f"{now.done} of {runs} runs, {words(now)}", file=sys.stderr, flush=True)

        yield tell
        return
    columns = (
        TextColumn("{task.completed:.0f} of {task.total:.0f} runs"),
        BarColumn(),
        TextColumn("{task.description}"),
    )
    with Bar(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=runs)
        yield lambda now: bar.update(task, completed=now.done, description=words(now))


def show_summary(
    summary: Summary, found: Sequence[Sensitivity], replay: str, places: Sequence[tuple[str, Path]]
) -> None:
    out = console()
    low, high = summary.confidence
    out.print(
        f"[bold]{summary.succeeded} of {summary.runs} runs succeeded[/bold], {summary.rate:.2%} "
        f"(95 %: {low:.2%} to {high:.2%})",
        highlight=False,
    )
    for reason, count in summary.reasons:
        out.print(Text(f"{count:6} {reason}", "red"))
    names = list(next(iter(summary.quantiles.values()), {}))
    table = Table("", *(f"{100 * float(q):g} %" for q in names), box=None)
    for name, values in summary.quantiles.items():
        table.add_row(Text(name, "dim"), *(f"{values[q]:.4g}" for q in names))
    out.print(table)
    for each in found:
        ranked = sorted(each.shares.items(), key=lambda pair: -pair[1])[:4]
        shares = ", ".join(f"{key} {share:.2f}" for key, share in ranked)
        out.print(Text(f"{each.output} depends on {shares} ({each.method})"), soft_wrap=True)
    if summary.worst:
        run, miss = summary.worst[0]
        out.print(Text(f"the worst: {in_words(miss)}, {replay.format(run=run)}"), soft_wrap=True)
    for name, path in places:
        out.print(Text(f"{name:7}{path}"), soft_wrap=True)


def show_comparison(found: Sequence[Difference]) -> None:
    out = console()
    for each in found:
        out.print(Text(str(each), "bold red" if each.worse else ""), soft_wrap=True)
    worse = [each.what for each in found if each.worse]
    verdict = f"significantly worse: {', '.join(worse)}" if worse else "nothing is significantly worse"
    out.print(Text(verdict, "bold red" if worse else "bold green"))


def show_trial(number: int, trial: Trial) -> None:
    values = ", ".join(f"{key} {value:.4g}" for key, value in trial.values.items())
    print(f"{number:3} {values}: {trial.goal:.4g}, success {trial.success:.1%}", file=sys.stderr, flush=True)


def show_tuned(tuned: Tuned) -> None:
    out = console()
    table = Table("", "untuned", "tuned", box=None)
    for key, value in tuned.best.values.items():
        table.add_row(Text(key, "dim"), "", f"{value:.4g}")
    table.add_row(Text("goal", "dim"), f"{tuned.untuned.goal:.4g}", f"{tuned.proof.goal:.4g}")
    table.add_row(Text("T", "dim"), f"{tuned.untuned.T_s:.3f} s", f"{tuned.proof.T_s:.3f} s")
    table.add_row(Text("success", "dim"), f"{tuned.untuned.success:.2%}", f"{tuned.proof.success:.2%}")
    out.print(table)
    out.print(
        f"{tuned.proof.succeeded} of {tuned.proof.runs} other runs succeed: with 95 % confidence at least "
        f"{tuned.at_least:.2%} do",
        highlight=False,
    )
