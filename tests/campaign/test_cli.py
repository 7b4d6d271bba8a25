"""`halfroll campaign` and `halfroll tune` as people and programs use them."""

import json
import subprocess
import sys

import pyarrow.parquet as pq
import pytest
from spaces import HOP

SPACE = """
mission = "hop.toml"
runs = 30
seed = 3
hold_s = 0.2

[plan]
mode = "paper"

[vary]
"vehicle.mass_kg" = { uniform = [0.9, 1.1], times = true }
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "hop.toml").write_text(HOP)
    (tmp_path / "space.toml").write_text(SPACE)
    return tmp_path


def halfroll(folder, *words):
    return subprocess.run([sys.executable, "-m", "halfroll", *words], cwd=folder, capture_output=True, text=True)


def test_a_campaign_is_flown_summed_up_gone_on_with_and_each_run_flown_again(folder):
    first = halfroll(folder, "campaign", "space.toml", "-o", "out", "--json", "--save", "runs.parquet")
    assert first.returncode == 0, first.stderr
    told = json.loads(first.stdout)
    assert (told["runs"], told["succeeded"], told["failed"], told["flown_now"]) == (30, 30, [], 30)
    assert told["success"]["low"] < 1.0 == told["success"]["high"]
    assert told["quantiles"]["tracking_max_m"]["0.5"] < told["quantiles"]["tracking_max_m"]["1"]
    assert told["x_realtime"] > 1.0
    assert (folder / "out" / "report.html").read_text().count("<svg") == 2
    row = pq.read_table(folder / "runs.parquet").to_pylist()[told["worst"][0]["run"]]
    assert told["worst"][0]["waypoint_miss_max_m"] == row["waypoint_miss_max_m"]

    replay = halfroll(folder, *told["worst"][0]["replay"].split()[1:], "--json")
    again = json.loads(replay.stdout)
    assert again["commands_sha256"] == row["commands_sha256"].hex()
    assert again["tracking_rms_m"] == row["tracking_rms_m"]

    more = json.loads(halfroll(folder, "campaign", "space.toml", "-o", "out", "--runs", "40", "--json").stdout)
    assert (more["runs"], more["flown_now"]) == (40, 10)


def test_the_gate_ends_with_one_when_something_got_worse(folder):
    assert halfroll(folder, "campaign", "space.toml", "-o", "before").returncode == 0
    same = halfroll(folder, "campaign", "space.toml", "-o", "same", "--seed", "4", "--compare", "before")
    assert same.returncode == 0, same.stdout + same.stderr
    assert "nothing is significantly worse" in same.stdout
    (folder / "space.toml").write_text(SPACE.replace("[vary]", '[set]\n"params.POS_KD_XY" = 2.0\n\n[vary]'))
    worse = halfroll(folder, "campaign", "space.toml", "-o", "worse", "--compare", "before", "--json")
    assert worse.returncode == 1
    assert any(each["worse"] for each in json.loads(worse.stdout)["compared"])


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["campaign", "nowhere.toml"], 2, "nowhere.toml: No such file"),
        (["campaign", "space.toml", "--engine", "steam"], 2, "threads or processes"),
        (["campaign", "space.toml", "--dask", "tcp://127.0.0.1:1"], 3, "no Dask scheduler answers"),
        (["campaign", "space.toml", "--dask", "nonsense"], 2, "like tcp://127.0.0.1:8786"),
        (["campaign", "space.toml", "--run", "99999999999"], 2, "beyond the last that a campaign can have"),
        (["campaign", "space.toml", "--compare", "hop.toml"], 2, "hop.toml holds no runs of a campaign"),
        (["campaign", "space.toml", "--stop-when", "soon"], 2, "ci<SHARE is wanted"),
        (["campaign", "space.toml", "--save", "runs.csv"], 2, "runs are saved as .parquet"),
        (["campaign", "space.toml", "--compare", "nothing"], 2, "holds no runs"),
        (["campaign", "space.toml", "--fidelity", "paper"], 2, "fidelity"),
        (["tune", "space.toml", "--over", "params.ATT_WN", "-o", "a.params"], 2, "KEY=LOW:HIGH is wanted"),
        (["tune", "space.toml", "--over", "params.NONE=1:2", "-o", "a.params"], 2, "no parameter NONE"),
        (["tune", "space.toml", "--over", "params.ATT_WN=8:24", "-o", "a.csv"], 2, ".params or as a vehicle .toml"),
    ],
)
def test_wrong_input_is_one_sentence_and_its_exit_code(folder, words, code, sentence):
    ended = halfroll(folder, *words, "--json")
    assert ended.returncode == code, ended.stderr
    assert sentence in json.loads(ended.stdout)["error"]["message"]
    assert ended.stderr.count("\n") <= 2
    assert "Traceback" not in ended.stderr


def test_what_so_few_runs_cannot_prove_is_not_called_proven(folder):
    words = ("tune", "space.toml", "--over", "params.ATT_WN=12:14", "--trials", "2", "--runs", "10", "--proof", "20")
    done = halfroll(folder, *words, "-o", "tuned.params")
    assert done.returncode == 1
    assert "20 of 20 succeed: with 95 % confidence at least 86.09%, and 99.90% were wanted" in done.stderr
    assert (folder / "tuned.params").exists()


@pytest.mark.long
def test_tuning_finds_gains_that_fly_nearer_the_plan_and_writes_them(folder):
    (folder / "space.toml").write_text(SPACE.replace("[vary]", '[set]\n"params.POS_KD_XY" = 3.0\n\n[vary]'))
    words = ("tune", "space.toml", "--over", "params.POS_KP_XY=2:24", "--trials", "8", "--runs", "20", "--proof", "40")
    done = halfroll(folder, *words, "--success", "0.9", "-o", "tuned.toml", "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["success"]["at_least"] == pytest.approx(0.05 ** (1 / 40))  # 40 of 40: p^40 = 5 %
    assert told["goal"] <= told["untuned"]
    assert 2.0 <= told["values"]["params.POS_KP_XY"] <= 24.0
    flown = halfroll(folder, "check", "hop.toml", "--vehicle", "tuned.toml", "--json")
    assert flown.returncode == 0, flown.stderr
    assert f"POS_KP_XY = {told['values']['params.POS_KP_XY']:.9g}" in (folder / "tuned.toml").read_text()
