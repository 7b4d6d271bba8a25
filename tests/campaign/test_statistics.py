"""Intervals, quantiles, sensitivities and the gate, each against something independent."""

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from spaces import hop_space

from halfroll.campaign.comparison import LEVEL, compared
from halfroll.campaign.page import write_page
from halfroll.campaign.sampling import runs_of
from halfroll.campaign.sensitivity import sensitivities
from halfroll.campaign.statistics import interval, kind_of, summary_of

FIGURES = ("tracking_rms_m", "tracking_max_m", "waypoint_miss_max_m", "rotor_saturated", "flight_s")


def table(rng, runs, scale=1.0, rate=0.98, **columns):
    figures = {name: scale * rng.lognormal(-3.0, 0.5, runs) for name in FIGURES}
    good = rng.random(runs) < rate
    return pa.table(
        {
            "run": np.arange(runs),
            "seed": np.arange(runs) + 7,
            "succeeded": good,
            "why": ["" if fine else "waypoint miss 0.612 m, allowed 0.5" for fine in good],
            **figures,
            **columns,
        }
    )


@settings(deadline=None)  # SciPy comes with the first
@given(st.integers(1, 3000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_the_interval_is_clopper_and_pearsons(case):
    succeeded, runs = case
    oracle = stats.binomtest(succeeded, runs).proportion_ci(0.95, method="exact")
    assert interval(succeeded, runs) == pytest.approx((oracle.low, oracle.high), abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.02, 0.98), st.integers(0, 1000))
def test_the_interval_holds_the_truth_at_least_as_often_as_it_says(rate, seed):
    found = np.random.default_rng(seed).binomial(60, rate, 400)
    inside = [low <= rate <= high for low, high in (interval(int(k), 60) for k in found)]
    assert np.mean(inside) > 0.95 - 3.0 * np.sqrt(0.05 * 0.95 / 400)


def test_a_summary_counts_and_ranks():
    runs = table(np.random.default_rng(1), 300, rate=0.9)
    found = summary_of(runs)
    failed = np.flatnonzero(~np.array(runs["succeeded"]))
    assert (found.runs, found.succeeded) == (300, 300 - len(failed))
    assert [failure.run for failure in found.failed] == failed.tolist()
    assert found.failed[0].seed == failed[0] + 7
    assert found.reasons == (("waypoint miss", len(failed)),)
    assert found.quantiles["tracking_max_m"]["0.95"] == pytest.approx(np.quantile(runs["tracking_max_m"], 0.95))
    assert found.worst[0][0] == max(failed, key=lambda i: runs["waypoint_miss_max_m"][int(i)].as_py())
    assert found.as_json("halfroll campaign s.toml --run {run}")["worst"][0]["replay"].endswith(
        f"--run {found.worst[0][0]}"
    )


@pytest.mark.parametrize(
    ("why", "kind"),
    [
        ("waypoint miss 0.612 m, allowed 0.5", "waypoint miss"),
        ("not flown: it cannot hover: 4 rotors give", "not flown"),
        ("left the plan", "left the plan"),
        ("ended 0.62 m from the last waypoint, thrust axis +0.99 up", "ended from the last waypoint"),
    ],
)
def test_reasons_are_counted_without_their_numbers(why, kind):
    assert kind_of(why) == kind


def test_the_gate_opens_for_the_same_code_with_other_seeds_and_shuts_on_what_is_worse():
    rng = np.random.default_rng(2)
    before = table(rng, 400)
    assert not any(each.worse for each in compared(before, table(rng, 400)))
    slower = compared(before, table(rng, 400, scale=1.5))
    assert {each.what for each in slower if each.worse} >= {"tracking_rms_m 50 %", "waypoint_miss_max_m 95 %"}
    failing = compared(before, table(rng, 400, rate=0.9))
    assert [each.what for each in failing if each.worse] == ["success"]
    assert not any(each.worse for each in compared(table(rng, 400, scale=1.3, rate=0.9), before))  # better is no alarm


def test_the_gate_cries_wolf_no_oftener_than_it_says():
    rng = np.random.default_rng(3)
    alarms = sum(any(each.worse for each in compared(table(rng, 100), table(rng, 100))) for _ in range(150))
    assert alarms <= stats.binom.ppf(0.999, 150, 2 * LEVEL)


def test_shuffling_finds_the_number_that_matters(tmp_path):
    keys = {"vehicle.mass_kg": 1.0, "vehicle.rotor.thrust_max_N": 0.5, "vehicle.arm_m": 0.0}
    vary = {key: {"uniform": [0.95, 1.05], "times": True} for key in keys}
    space = hop_space(tmp_path, sampling="random", vary=vary)
    rng = np.random.default_rng(0)
    x = {key: rng.random(2000) for key in keys}
    y = sum(weight * x[key] for key, weight in keys.items()) + 0.02 * rng.normal(size=2000)
    runs = table(rng, 2000, **x).set_column(4, "tracking_rms_m", pa.array(y))
    found = next(each for each in sensitivities(space, runs) if each.output == "tracking_rms_m")
    assert found.method == "permutation"
    assert found.shares["vehicle.mass_kg"] == pytest.approx(0.8, abs=0.05)  # of a variance of 1 + 1/4
    assert found.shares["vehicle.rotor.thrust_max_N"] == pytest.approx(0.2, abs=0.03)
    assert found.shares["vehicle.arm_m"] < 0.01
    assert found.explained > 0.95


def test_sobol_indices_of_saltellis_sample_are_those_of_ishigamis_function(tmp_path):
    keys = ("vehicle.mass_kg", "vehicle.rotor.thrust_max_N", "vehicle.arm_m")
    vary = {key: {"uniform": [0.95, 1.05], "times": True} for key in keys}
    count = 4096 * 5
    space = hop_space(tmp_path, sampling="saltelli", vary=vary, runs=count)
    shares = np.array([list(run.values.values()) for run in runs_of(space, 0, count)])
    a, b, c = np.pi * (20.0 * shares.T - 20.0)  # from -pi to pi
    y = np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)
    columns = dict(zip(keys, shares.T, strict=True))
    runs = table(np.random.default_rng(0), count, **columns).set_column(4, "tracking_rms_m", pa.array(y))
    found = next(each for each in sensitivities(space, runs) if each.output == "tracking_rms_m")
    assert found.method == "sobol"
    assert list(found.first.values()) == pytest.approx([0.314, 0.442, 0.0], abs=0.03)
    assert list(found.shares.values()) == pytest.approx([0.558, 0.442, 0.244], abs=0.03)


def test_the_report_is_one_page_that_asks_for_nothing_else(tmp_path):
    space = hop_space(tmp_path)
    rng = np.random.default_rng(4)
    runs = table(rng, 200, rate=0.9, **{"vehicle.mass_kg": rng.uniform(0.9, 1.1, 200)})
    write_page(tmp_path / "page.html", space, runs, "halfroll campaign s.toml --run {run}")
    page = (tmp_path / "page.html").read_text()
    assert page.count("<svg") == 2
    assert "halfroll campaign s.toml --run" in page
    assert 'src="' not in page
    assert 'href="http' not in page
