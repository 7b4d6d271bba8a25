"""Tuning: gains and margins that make a mission fast, or near its plan, and still succeed.

Why: what is best in one flight fails in the next. Each candidate flies the same sample of runs, so differences are the
candidate's; what wins has to prove its success rate on runs that nobody has tuned on. Optuna chooses the candidates:
its tree-structured Parzen estimator takes noisy, constrained goals, and few evaluations, where SciPy's optimisers want
smooth ones or thousands.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from halfroll import param_files
from halfroll.campaign.engines import Engine, Row
from halfroll.campaign.prepared import Prepared, firmware_setup, prepare
from halfroll.campaign.space import Space, SpaceError
from halfroll.campaign.statistics import CONFIDENCE, interval
from halfroll.errors import FlightError, InputError, PlanError

Goal = Literal["T", "tracking"]
LEAST_SUCCESS = 0.999
_UNSEEN = 1_000_000  # where the runs begin that prove the result


@dataclass(frozen=True)
class Knob:
    """What is tuned: params.NAME or plan.KEY, and from where to where."""

    key: str
    low: float
    high: float

    @classmethod
    def parsed(cls, words: str) -> Knob:
        """From `params.ATT_WN=8:24`. Raises InputError."""
        found = re.fullmatch(r"((?:params|plan)\.\w+)=([^:]+):([^:]+)", words.strip())
        with_numbers = found and all(_is_number(found[i]) for i in (2, 3))
        if not found or not with_numbers or not float(found[2]) < float(found[3]):
            raise InputError(f"--over {words}: KEY=LOW:HIGH is wanted, like params.ATT_WN=8:24 or plan.margin=0.05:0.3")
        return cls(found[1], float(found[2]), float(found[3]))


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


@dataclass(frozen=True)
class Trial:
    values: Mapping[str, float]
    goal: float  # inf where there is no plan
    succeeded: int
    runs: int
    T_s: float

    @property
    def success(self) -> float:
        return self.succeeded / self.runs if self.runs else 0.0


@dataclass(frozen=True)
class Tuned:
    best: Trial  # on the runs it was tuned on
    proof: Trial  # on others
    untuned: Trial  # the space as it was, on as many runs of the proof as a candidate flies
    least_success: float
    trials: tuple[Trial, ...]

    @property
    def at_least(self) -> float:
        """With 95 % confidence the success rate is at least this: the lower end of a 90 % interval."""
        return interval(self.proof.succeeded, self.proof.runs, 2.0 * CONFIDENCE - 1.0)[0]

    @property
    def is_proven(self) -> bool:
        return self.at_least >= self.least_success


def tune(
    space: Space,
    knobs: Sequence[Knob],
    engine: Engine,
    *,
    goal: Goal = "tracking",
    trials: int = 30,
    runs: int = 200,
    proof_runs: int = 3000,
    least_success: float = LEAST_SUCCESS,
    progress: Callable[[int, Trial], None] = lambda _, __: None,
) -> Tuned:
    """The trial with the lowest goal of those that succeed often enough, and its proof. Raises FlightError where none
    does, SpaceError for a knob that is none or is varied, too."""
    optuna = _optuna()
    if space.told.sampling == "lhs":
        raise SpaceError("a latin hypercube has no runs beside its own to prove the result on; take sobol or random")
    for knob in knobs:
        if knob.key in space.axes:
            raise SpaceError(f"{knob.key} is varied by the space, so it cannot be tuned; leave one of them")
        for value in (knob.low, knob.high):
            _with(space, {knob.key: value}).nominal  # noqa: B018  raises what is wrong with it
    found: list[Trial] = []
    plans = _Plans(space)

    def fly(candidate: Any) -> float:
        values = {knob.key: candidate.suggest_float(knob.key, knob.low, knob.high) for knob in knobs}
        trial = _tried(plans, values, engine, range(runs), goal)
        found.append(trial)
        candidate.set_constraint("success", least_success - trial.success)  # kept where not above 0
        progress(len(found), trial)
        return trial.goal if math.isfinite(trial.goal) else 1e6

    sampler = optuna.samplers.TPESampler(seed=space.told.seed, n_startup_trials=max(5, trials // 4))
    study = optuna.create_study(sampler=sampler)
    study.enqueue_trial(_as_it_is(space, knobs))
    study.optimize(fly, n_trials=trials)
    good = [trial for trial in found if trial.success >= least_success]
    if not good:
        nearest = max(found, key=lambda trial: trial.success)
        raise FlightError(
            f"none of {trials} trials succeeds in {least_success:.1%} of {runs} runs, the nearest in "
            f"{nearest.success:.1%}; tune plan.margin, too, or ask for less with --success"
        )
    best = min(good, key=lambda trial: trial.goal)
    unseen = range(_UNSEEN, _UNSEEN + proof_runs)
    proof = _tried(plans, best.values, engine, unseen, goal)
    untuned = _tried(plans, {}, engine, unseen[:runs], goal)
    return Tuned(best, proof, untuned, least_success, tuple(found))


def _optuna() -> Any:
    try:
        import optuna
    except ModuleNotFoundError:
        raise InputError("tuning needs optuna, which is not installed: pip install 'halfroll[campaign]'") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


class _Plans:
    """What was prepared for a space with other numbers: trials differ in gains far more often than in plans."""

    def __init__(self, space: Space) -> None:
        self._space = space
        self._known: dict[tuple[tuple[str, float], ...], Prepared] = {}

    def of(self, values: Mapping[str, float]) -> Prepared:
        """Raises PlanError."""
        planning = tuple(sorted((key, value) for key, value in values.items() if key.startswith("plan.")))
        if planning not in self._known:
            self._known[planning] = prepare(_with(self._space, dict(planning)))
        return replace(self._known[planning], space=_with(self._space, values))


def _tried(plans: _Plans, values: Mapping[str, float], engine: Engine, runs: Iterable[int], goal: Goal) -> Trial:
    runs = list(runs)
    try:
        prepared = plans.of(values)
    except PlanError:
        return Trial(values, math.inf, 0, len(runs), math.inf)
    rows = sorted(engine.fly_runs(prepared, runs), key=lambda row: int(row["run"]))
    planned_s = prepared.planned.plan.T
    reached = planned_s if goal == "T" else _typical(rows)
    return Trial(values, reached, sum(row["succeeded"] for row in rows), len(rows), planned_s)


def _typical(rows: Sequence[Row]) -> float:
    """95 % of the tracking errors, RMS of a flight, are below this; of flights that never began, none is."""
    errors = np.array([row["tracking_rms_m"] for row in rows])
    return float(np.quantile(np.where(np.isfinite(errors), errors, 1e3), 0.95))


def _with(space: Space, values: Mapping[str, float]) -> Space:
    return replace(space, told=space.told.model_copy(update={"set": {**space.told.set, **values}}))


def _as_it_is(space: Space, knobs: Sequence[Knob]) -> dict[str, float]:
    """Where the search begins."""
    params = firmware_setup(space.nominal.known).params
    now = {}
    for knob in knobs:
        where, _, name = knob.key.partition(".")
        value = params[name] if where == "params" else getattr(space.nominal.plan, name) or 0.1
        now[knob.key] = min(max(float(value), knob.low), knob.high)
    return now


def tuned_params(tuned: Tuned) -> dict[str, float]:
    """Of what was tuned, the autopilot's parameters by name."""
    return {k.removeprefix("params."): value for k, value in tuned.best.values.items() if k.startswith("params.")}


def write_tuned(path: Path, space: Space, tuned: Tuned) -> None:
    """A .params file for `halfroll params import`, or a vehicle .toml for --vehicle. Raises InputError."""
    params = tuned_params(tuned)
    if not params:
        raise InputError(f"{path}: no parameter was tuned; a plan's margin is given to --margin")
    if path.suffix == ".params":
        param_files.write_params(path, params)
        return
    known, like = space.nominal.known, space.told.vehicle
    if path.suffix != ".toml" or like.endswith(".toml"):
        raise InputError(f"{path}: write a .params file, or, of a shipped vehicle, a .toml")
    lines = [
        f"# Tuned: {tuned.proof.succeeded} of {tuned.proof.runs} runs succeed; with 95 % confidence at least "
        f"{tuned.at_least:.2%} do.",
        f'like = "{like}"',
        f'name = "{known.name}-tuned"',
        "",
        "[params]",
        *(f"{name} = {value:.9g}" for name, value in sorted({**known.params, **params}.items())),
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
