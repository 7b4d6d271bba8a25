"""The command line: what it prints, where, and how it ends. The flight itself is a stand-in here."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import halfroll
from halfroll import simulator
from halfroll.cli.app import app
from halfroll.errors import FlightError, InputError, LinkError, MissionError, SimulatorDied
from halfroll.planner.plan import Plan
from halfroll.planner.segments import monomials
from halfroll.vehicle import load_vehicle

GROUND = Path(halfroll.__file__).parents[1]
HOVER_AND_GO = """QGC WPL 110
0 0 0 16 0 0 0 0 47.397742 8.545594 488 1
1 0 3 22 0 0 0 0 47.397742 8.545594 2 1
2 0 3 16 0 0 0 0 47.397760 8.545594 2 1
3 0 3 21 0 0 0 0 47.397760 8.545594 0 1
"""
TIMED = (
    "[[waypoint]]\nposition_m = [0, 0, 1]\n",
    "[[waypoint]]\nposition_m = [5, 0, 1]\ntime_s = 8\n",
)


@pytest.fixture
def mission(tmp_path):
    path = tmp_path / "field.waypoints"
    path.write_text(HOVER_AND_GO, encoding="utf-8")
    return path


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def run_process(*words, **options):
    environment = {**os.environ, "PYTHONPATH": str(GROUND)}
    command = [sys.executable, "-m", "halfroll", *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False, **options)


def raise_(error):
    raise error


def the_object(ended):
    """Exactly one JSON object on standard output."""
    assert ended.stdout.count("\n") == 1
    return json.loads(ended.stdout)


# Starting


@pytest.mark.parametrize("words", [["--help"], ["fly", "--help"], ["--version"]])
def test_help_and_version_load_nothing_heavy(words):
    code = (
        "import sys\nfrom halfroll.cli.app import app\n"
        f"try:\n    app({words!r})\nexcept SystemExit as end:\n    assert not end.code\n"
        "print('loaded', *{'numpy', 'scipy', 'matplotlib', 'pymavlink', 'pyulog'} & set(sys.modules))"
    )
    environment = {**os.environ, "PYTHONPATH": str(GROUND)}
    ended = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines()[-1] == "loaded"


def test_ctrl_c_while_it_is_being_loaded_is_one_word_too():
    code = (
        "import sys\n"
        "class Interrupts:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'typer':\n            raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupts())\n"
        "from halfroll.cli import main\nmain()\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(GROUND)}
    ended = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (130, "stopped\n")


def test_help_names_every_command():
    shown = run("--help").stdout
    for command in ("check", "plan", "fly", "sitl", "ground"):
        assert f" {command} " in shown


def test_version_is_one_line():
    assert run("--version").stdout == f"halfroll {halfroll.__version__}\n"


def test_public_names_are_there_and_plan_is_both_module_and_function(mission):
    assert halfroll.load_vehicle("mit-vp").name == "mit-vp"
    assert halfroll.plan(halfroll.load_mission(mission)).T > 0
    from halfroll.planner.plan import Plan

    assert isinstance(halfroll.plan(mission), Plan)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = halfroll.nonsense


# check and plan


def test_check_says_what_is_flown_and_how_long_it_takes(mission):
    ended = run("check", mission)
    assert ended.exit_code == 0
    assert "TAKEOFF" in ended.stdout
    assert "T = " in ended.stdout


def test_check_as_json_has_the_documented_keys(mission):
    outcome = the_object(run("check", mission, "--json"))
    assert outcome["supported"] is True
    assert outcome["unsupported"] == []
    assert len(outcome["items"]) == 4
    assert outcome["T_s"] > 0


def test_check_names_every_item_that_is_not_supported_not_only_the_first(mission):
    bad = HOVER_AND_GO.replace("2 0 3 16", "2 0 3 4711") + "4 0 3 4712 0 0 0 0 47.4 8.5 2 1\n"
    mission.write_text(bad, encoding="utf-8")
    ended = run("check", mission, "--json")
    outcome = the_object(ended)
    assert ended.exit_code == 2
    assert outcome["supported"] is False
    assert [(entry["index"], entry["command"]) for entry in outcome["unsupported"]] == [(2, 4711), (4, 4712)]
    assert outcome["error"]["kind"] == "mission"
    assert outcome["error"]["item"] == 2


def test_plan_prints_a_table_and_writes_by_ending(mission, tmp_path):
    ended = run("plan", mission, "-o", tmp_path / "plan.csv")
    assert ended.exit_code == 0
    assert "inside the limits" in ended.stdout
    assert (tmp_path / "plan.csv").read_text(encoding="utf-8").startswith("t_s,x_m,y_m,z_m,vx_m_s")


def test_plan_as_json_has_the_documented_keys(mission):
    outcome = the_object(run("plan", mission, "--json", "--mode", "paper"))
    assert set(outcome) >= {
        "mission", "vehicle", "mode", "waypoints", "T_s", "times_s", "rotor_min_N", "rotor_max_N", "certified",
        "violation_N", "solve_s",
    }  # fmt: skip
    assert outcome["certified"] is True
    assert outcome["times_s"][-1] == pytest.approx(outcome["T_s"])
    assert len(outcome["rotor_max_N"]) == 4


def test_a_number_of_the_vehicle_can_be_set(mission):
    weak = the_object(run("plan", mission, "--json", "--set", "rotor.thrust_max_N=1.8"))
    strong = the_object(run("plan", mission, "--json"))
    assert max(weak["rotor_max_N"]) <= 0.9 * 1.8 + 1e-6
    assert weak["T_s"] > strong["T_s"]


PAPER_TIMES = [  # heights of the nodes [m], vehicle, mass [kg], least time [s]
    ((1.0, 2.0), "mit-vp", 0.571, 0.9145),
    ((1.0, 2.0), "mit-fp", 0.571, 1.0344),
    ((1.0, 1.25, 1.9, 2.0), "mit-vp", 0.571, 0.6666),
    ((1.0, 1.25, 1.9, 2.0), "mit-fp", 0.571, 0.8952),
    ((1.0, 1.25, 1.9, 2.0), "mit-vp", 0.665, 0.777),
    ((1.0, 1.25, 1.9, 2.0), "mit-fp", 0.665, 0.968),
]


@pytest.mark.parametrize(("heights", "vehicle", "mass", "T"), PAPER_TIMES)
def test_paper_mode_takes_the_paper_s_times_and_is_continuous_to_the_8th_derivative(
    tmp_path, heights, vehicle, mass, T
):
    nodes = "".join(f"[[waypoint]]\nposition_m = [0, 0, {z}]\n" for z in heights)
    (tmp_path / "up.toml").write_text(f'name = "up"\nframe = "local"\n{nodes}', encoding="utf-8")
    words = ("--mode", "paper", "--limits", "rotors", "--vehicle", vehicle, "--set", f"mass_kg={mass}", "--json")
    outcome = the_object(run("plan", "up.toml", *words, "-o", "up.npz"))
    assert outcome["T_s"] == pytest.approx(T, rel=5e-3)
    assert (outcome["certified"], outcome["violation_N"]) == (True, 0.0)
    path = Plan.load(tmp_path / "up.npz").trajectory
    for d in range(9):
        scale = path.durations[:, None] ** d
        before = (monomials(1.0, d) @ path.coefficients)[:, 0] / scale
        after = (monomials(0.0, d) @ path.coefficients)[:, 0] / scale
        assert before[:-1] == pytest.approx(after[1:], abs=1e-6 * np.abs(after).max()), d


WRONG_OF_FLY = [
    (["--board", "nosuch"], "board 'nosuch' is not known; give qemu-m4, qemu-m7, python"),
    (["--limit", "foo=3"], "limit 'foo' is not known"),
    (["--limits", "foo"], "limits 'foo' are not known"),
    (["--margin", "2"], "margin 2 is no share"),
    (["--mode", "magic"], "mode 'magic' is not known"),
    (["--yaw", "up"], "yaw 'up' is not known"),
]


@pytest.mark.parametrize(("wrong", "complaint"), WRONG_OF_FLY)
def test_wrong_words_leave_the_last_flight_where_it_is(mission, tmp_path, wrong, complaint):
    (tmp_path / "last").mkdir()
    (tmp_path / "last" / "result.json").write_text("{}", encoding="utf-8")
    ended = run("fly", mission, "--out", tmp_path / "last", *wrong)
    assert (ended.exit_code, complaint in ended.stderr) == (2, True)
    assert (tmp_path / "last" / "result.json").read_text(encoding="utf-8") == "{}"


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"limits": "missoin"}, "limits 'missoin' are not known; give mission or rotors"),
        ({"margin": -0.2}, "margin -0.2 is no share"),
        ({"margin": float("nan")}, "margin nan is no share"),
    ],
)
def test_python_refuses_what_the_command_line_refuses(mission, options, complaint):
    with pytest.raises(InputError, match=complaint):
        halfroll.plan(mission, **options)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["plan", "none.plan"], "none.plan"),
        (["plan", "MISSION", "--vehicle", "mit-xy"], "no vehicle is called mit-xy"),
        (["plan", "MISSION", "--mode", "magic"], "mode 'magic' is not known; give one of paper, fast, best"),
        (["plan", "MISSION", "--limits", "none"], "limits 'none' are not known; give mission or rotors"),
        (["plan", "MISSION", "--margin", "1.5"], "margin 1.5 is no share"),
        (["plan", "MISSION", "--limit", "tilt_deg=steep"], "--limit tilt_deg=steep: NAME=NUMBER or NAME=off is wanted"),
        (["plan", "MISSION", "--limit", "tilt=30"], "limit 'tilt' is not known; there are speed_m_s, tilt_deg"),
        (["plan", "MISSION", "--mode", "fast", "--yaw", "up"], "yaw 'up' is not known; give free, given, path"),
        (["plan", "MISSION", "--yaw", "path"], "mode paper flies yaw as given, not path; take mode fast or best"),
        (["plan", "MISSION", "-o", "plan.xls"], "end the name in one of them"),
        (["plan", "MISSION", "-o", "no/such/folder/plan.csv"], "no/such/folder/plan.csv"),
        (["plan", "MISSION", "--set", "rotor.thrust_max_N"], "KEY=NUMBER is wanted"),
        (["plan", "MISSION", "--set", "mass_kg=30"], "it cannot hover"),
        (["fly", "MISSION", "--scenario", "storm"], "no scenario is called storm"),
        (["fly", "MISSION", "--out", "field.waypoints"], "choose another with --out DIR"),
        (["fly", "MISSION", "--log", "field.waypoints/f.ulg"], "choose another with --log F.ulg"),
        (["fly", "MISSION", "--vehicle", "none.toml"], "none.toml"),
        (["fly", "MISSION", "--report", "r.txt"], "r.txt: a report is written as .html or .pdf"),
        (["plan", "TIMED"], "mode paper keeps no times, and item 1 is due at 8 s; take mode fast or best"),
        *((["fly", "MISSION", *wrong], complaint) for wrong, complaint in WRONG_OF_FLY),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(mission, words, complaint):
    timed = mission.with_name("timed.toml")
    timed.write_text('frame = "local"\n' + "".join(TIMED), encoding="utf-8")
    words = [{"MISSION": mission, "TIMED": timed}.get(word, word) for word in words]
    plain, as_json = run(*words), run(*words, "--json")
    assert plain.exit_code == as_json.exit_code == 2
    assert plain.stdout == ""
    assert plain.stderr.splitlines()[-1].startswith("error: ")
    assert complaint in plain.stderr.splitlines()[-1]
    assert complaint in the_object(as_json)["error"]["message"]
    assert "Traceback" not in plain.stderr + as_json.stderr


@pytest.mark.parametrize("words", [["fly"], ["plan", "m.plan", "--no-such-option"], ["fly", "m.plan", "--seed", "x"]])
def test_wrong_usage_is_exit_code_2_and_an_object_with_json(words):
    ended = run_process(*words, "--json")
    assert ended.returncode == 2
    assert the_object(ended)["error"]["kind"] == "usage"
    assert "Traceback" not in ended.stderr


def test_ground_has_no_tenth_instance():
    ended = run_process("ground", "--instance", "10")
    assert ended.returncode == 2
    assert "--instance" in ended.stderr
    assert "9" in ended.stderr


def test_a_package_that_was_not_built_says_so(mission, monkeypatch):
    error = ModuleNotFoundError("No module named 'halfroll._firmware'", name="halfroll._firmware")
    monkeypatch.setattr("halfroll.missions.mission_files.load_mission", lambda path: raise_(error))
    ended = run("fly", mission)
    assert ended.exit_code == 3
    assert ended.stderr.splitlines()[-1].startswith("error: halfroll._firmware is missing")


# fly


@pytest.fixture
def flight(monkeypatch, fly_circle, circle):
    """Replaces the flight: `flight.how` are the made-up flight's peculiarities, `flight.error` is raised instead."""
    asked = SimpleNamespace(how={}, error=None, options=None, unplanned=False)

    def fly(mission, vehicle, **options):
        asked.options = options
        options["progress"]("simulator", None)
        options["progress"]("flight", 0.5)
        if asked.error is not None:
            raise asked.error
        return SimpleNamespace(
            mission=mission,
            vehicle=vehicle,
            plan=None if asked.unplanned else circle,
            plan_start_s=3.0,
            log_path=fly_circle(Path(options["log_path"]), **asked.how),
            references_sent=400,
            reference_rate_Hz=100.0,
            interval_p99_s=0.0112,
            commands_sha256="ab" * 32,
            notes=("item 4: LAND where the mission ends",),
            board=None,
        )

    monkeypatch.setitem(sys.modules, "halfroll.flight", SimpleNamespace(fly=fly))
    return asked


def test_a_flight_within_limits_is_exit_code_0_with_log_plan_report_and_picture(flight, mission, circle):
    ended = run("fly", mission)
    folder = Path("flights/field-mit-vp")
    assert ended.exit_code == 0
    assert "flown within limits" in ended.stdout
    assert {file.name for file in folder.iterdir()} == {"flight.ulg", "report.html", "flight.png", "result.json"}
    assert circle.saved == [folder / "plan.csv", folder / "plan.json"]
    assert str(folder / "report.html") in ended.stdout


def test_a_flight_as_json_has_the_documented_keys(flight, mission, tmp_path):
    flight.how = {"offset": (0.0, 0.03, 0.0)}
    outcome = the_object(run("fly", mission, "--json", "--log", "my.ulg", "--report", "sub/my.html", "--out", "folder"))
    assert outcome["result"] == "flown"
    assert outcome["tracking_rms_m"] == pytest.approx(0.03)
    assert outcome["commands_sha256"] == "ab" * 32
    assert (outcome["log"], outcome["report"]) == ("my.ulg", "sub/my.html")
    assert Path("sub/my.html").is_file()
    assert set(outcome) >= {
        "T_planned_s", "T_flown_s", "flight_s", "tracking_max_m", "waypoint_miss_max_m", "rotor_min_N", "rotor_max_N",
        "references_sent", "reference_rate_Hz",
    }  # fmt: skip


def test_a_flight_out_of_limits_is_exit_code_1_and_says_which(flight, mission):
    flight.how = {"offset": (0.0, 0.7, 0.0)}
    ended = run("fly", mission)
    assert ended.exit_code == 1
    assert "out of limits: distance from the plan 0.700 m, allowed 0.5 m" in ended.stdout
    assert the_object(run("fly", mission, "--json"))["result"] == "out of limits"


def test_what_was_added_to_the_mission_is_said(flight, mission):
    assert "note: item 4: LAND where the mission ends" in run("fly", mission).stdout


def test_a_plan_that_was_not_flown_is_exit_code_1(flight, mission):
    flight.unplanned = True
    ended = run("fly", mission)
    assert ended.exit_code == 1
    assert "by the autopilot alone, its plan was not" in ended.stderr


def test_a_mission_with_nothing_to_plan_is_flown_all_the_same(flight, mission):
    flight.unplanned = True
    mission.write_text("".join(HOVER_AND_GO.splitlines(keepends=True)[:3]), encoding="utf-8")
    ended = run("fly", mission, "--json")
    assert ended.exit_code == 0
    assert the_object(ended)["result"] == "flown without a plan"
    assert json.loads(Path("flights/field-mit-vp/result.json").read_text(encoding="utf-8")) == the_object(ended)


def test_progress_goes_to_standard_error(flight, mission):
    ended = run("fly", mission, "--json")
    assert ended.stderr.splitlines() == ["simulator", "flight", "report"]


def test_options_reach_the_flight(flight, mission):
    run("fly", mission, "--scenario", "ideal", "--seed", "7", "--margin", "0.2")
    assert flight.options["lockstep"] is True
    assert (flight.options["scenario"], flight.options["seed"], flight.options["margin"]) == ("ideal", 7, 0.2)
    run("fly", mission, "--real-time", "--speed", "2")
    assert (flight.options["lockstep"], flight.options["speed"]) == (False, 2.0)


def test_real_time_shows_the_measured_intervals(flight, mission):
    assert "11.2 ms" in run("fly", mission, "--real-time").stdout


@pytest.mark.parametrize(
    ("error", "code", "kind"),
    [
        (SimulatorDied("the simulator ended after 3.2 s of the flight, by signal 9"), 3, "simulator"),
        (MissionError("item 1 (TAKEOFF): 100 m above sea level is 388 m below home", 1), 2, "mission"),
        (LinkError("the autopilot does not answer"), 3, "link"),
    ],
)
def test_a_flight_that_fails_ends_with_its_exit_code_and_kind(flight, mission, error, code, kind):
    flight.error = error
    ended = run("fly", mission, "--json")
    assert ended.exit_code == code
    assert the_object(ended)["error"]["kind"] == kind
    assert the_object(ended)["error"].get("item") == error.item
    assert ended.stderr.splitlines()[-1] == f"error: {error}"


def test_a_failed_flight_leaves_no_report_of_an_earlier_one(flight, mission):
    run("fly", mission)
    flight.error = LinkError("the autopilot does not answer")
    run("fly", mission)
    assert not Path("flights/field-mit-vp/report.html").exists()


def test_ctrl_c_ends_with_130_and_one_word(flight, mission):
    flight.error = KeyboardInterrupt()
    ended = run("fly", mission)
    assert ended.exit_code == 128 + signal.SIGINT
    assert ended.stderr.splitlines()[-1] == "stopped"
    assert "log" not in ended.stderr  # there is none


def test_ctrl_c_in_flight_says_where_the_log_ends(flight, mission, monkeypatch, fly_circle):
    def fly(wanted, vehicle, **options):
        fly_circle(Path(options["log_path"]))
        raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "halfroll.flight", SimpleNamespace(fly=fly))
    told = run("fly", mission).stderr.splitlines()
    assert told[-2:] == ["the log ends here: flights/field-mit-vp/flight.ulg", "stopped"]


def test_a_failed_flight_leaves_its_error_among_its_results(flight, mission, monkeypatch, fly_circle):
    def fly(wanted, vehicle, **options):
        fly_circle(Path(options["log_path"]))
        raise FlightError("the autopilot disarmed", 3)

    monkeypatch.setitem(sys.modules, "halfroll.flight", SimpleNamespace(fly=fly))
    run("fly", mission)
    kept = json.loads(Path("flights/field-mit-vp/result.json").read_text(encoding="utf-8"))
    assert kept["result"] == "failed"
    assert kept["error"] == {"kind": "flight", "message": "the autopilot disarmed", "item": 3}
    assert Path(kept["log"]).is_file()
    assert Path(kept["report"]).is_file()


# sitl


def test_sitl_passes_options_through_untouched():
    given = ["--instance", "2", "--vehicle", "mit-fp", "--set", "params.ATT_WN=12", "--lockstep"]
    assert simulator.arguments(given) == given


@pytest.mark.parametrize("form", [["--vehicle", "mine.toml"], ["--vehicle=mine.toml"]])
def test_a_vehicle_file_becomes_a_shipped_vehicle_with_all_its_numbers_set_before_what_the_user_sets(form):
    text = (GROUND / "halfroll/vehicles/mit-fp.toml").read_text(encoding="utf-8")
    Path("mine.toml").write_text(text.replace('"mit-fp"', '"mine"').replace("mass_kg = 0.571", "mass_kg = 0.6"))
    words = simulator.arguments(["--seed", "3", *form, "--set", "mass_kg=0.65"])
    assert words[:2] == ["--vehicle", "mit-fp"]
    assert words[-4:] == ["--seed", "3", "--set", "mass_kg=0.65"]
    numbers = load_vehicle("mine.toml").numbers()
    pairs = dict(word.split("=") for flag, word in zip(words[2:-4:2], words[3:-4:2], strict=True) if flag == "--set")
    assert {key: float(number) for key, number in pairs.items()} == numbers
    assert float(pairs["mass_kg"]) == 0.6


def test_sitl_becomes_the_simulator_itself(tmp_path):
    program = tmp_path / "bin" / "halfroll-sitl"
    program.parent.mkdir()
    program.write_text('#!/bin/sh\necho "$@"\nexit 7\n')
    program.chmod(0o755)
    code = f"import sys; sys.executable = {str(program.with_name('python'))!r}; from halfroll.cli.app import app; app()"
    ended = subprocess.run(
        [sys.executable, "-c", code, "sitl", "--help", "--speed", "0"],
        env={**os.environ, "PYTHONPATH": str(GROUND)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (ended.stdout, ended.returncode) == ("--help --speed 0\n", 7)


def test_a_simulator_that_is_not_installed_is_exit_code_3(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setenv("PATH", str(tmp_path))
    ended = run("sitl")
    assert ended.exit_code == 3
    assert "pip install" in ended.stderr
