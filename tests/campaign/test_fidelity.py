"""Closed loop in the process, and halfroll-sitl over MAVLink: over an ideal link the same flight, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest
from spaces import hop_space

from halfroll.campaign.flights import closed_loop, fly_run, sitl
from halfroll.campaign.prepared import prepare
from halfroll.campaign.sampling import runs_of
from halfroll.flight import fly
from halfroll.results.log import read_log


@pytest.mark.parametrize("scenario", ["nominal", "full"])
def test_both_fidelities_fly_the_same_bits(tmp_path, scenario):
    vary = {
        "vehicle.mass_kg": {"uniform": [0.9, 1.1], "times": True},
        "params.ATT_WN": {"uniform": [14.0, 18.0]},
        "scenario.wind.mean_m_s.0": {"uniform": [-1.0, 1.0]},
    }
    prepared = prepare(hop_space(tmp_path, scenario=scenario, vary=vary))
    (run,) = runs_of(prepared.space, 1, 1)
    setup = prepared.space.setup(run.values)
    here = closed_loop(prepared, prepared.planned, setup, run.seed).figures
    there = sitl(prepared, prepared.planned, setup, run.seed).figures
    assert here.commands_sha256 == there.commands_sha256
    assert replace(here, flight_s=0.0) == replace(there, flight_s=0.0)  # one ends hovering, one on the ground


def test_a_near_optimal_plan_flown_by_halfroll_fly_is_flown_the_same_in_the_closed_loop(tmp_path):
    prepared = prepare(hop_space(tmp_path, vary={}, plan={"mode": "fast"}))
    flown = fly(prepared.mission, seed=5, mode="fast", log_path=tmp_path / "hop.ulg")
    planned = replace(prepared.planned, plan=flown.plan, path=_path(flown.plan))
    here = closed_loop(prepared, planned, prepared.space.nominal, 5).figures
    commands = read_log(flown.log_path)["rotor_commands"]["thrust"]
    start = round(1e3 * flown.plan_start_s)
    assert here.plan_start_s == pytest.approx(flown.plan_start_s)
    assert len(commands) > start + 1e3 * flown.plan.T
    end = round(1e3 * flown.plan_end_s)
    assert here.commands_sha256 == _sha256(commands[: end + 1])


def test_a_link_that_delays_and_loses_flies_worse_and_the_same_again(tmp_path):
    quick = prepare(hop_space(tmp_path, vary={}))
    slow = prepare(hop_space(tmp_path, vary={}, link={"delay_s": 0.03, "jitter_s": 0.01, "loss": 0.1}))
    (run,) = runs_of(quick.space, 0, 1)
    ideal, delayed, again = fly_run(quick, run), fly_run(slow, run), fly_run(slow, run)
    assert delayed == again
    assert delayed["tracking_rms_m"] > 1.2 * ideal["tracking_rms_m"]
    assert ideal["succeeded"]


def test_a_run_that_ends_badly_says_how(tmp_path):
    (tmp_path / "dead.toml").write_text('like = "nominal"\n[[fault]]\nkind = "dead-rotor"\nat_s = 3.5\n')
    prepared = prepare(hop_space(tmp_path, vary={}, scenario="dead.toml"))
    (run,) = runs_of(prepared.space, 0, 1)
    row = fly_run(prepared, run)
    assert not row["succeeded"]
    assert row["why"] in ("left the plan", "crashed", "the autopilot left OFFBOARD")
    assert np.isfinite(row["tracking_max_m"])
    weak = prepare(hop_space(tmp_path, vary={"vehicle.rotor.thrust_max_N": {"uniform": [1.44, 1.46]}}))
    (run,) = runs_of(weak.space, 0, 1)
    assert "cannot hover" in fly_run(weak, run)["why"]


def _path(plan):
    from halfroll.station.references import path_of

    return path_of(plan)


def _sha256(commands):
    import hashlib

    return hashlib.sha256(np.ascontiguousarray(commands, dtype="<f4").tobytes()).digest()
