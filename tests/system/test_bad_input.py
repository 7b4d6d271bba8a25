"""What people get wrong: one sentence that names it, exit code 2, never a traceback."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from system.processes import MISSIONS, Ended, halfroll

BOX = MISSIONS / "box.plan"
Change = Callable[[dict[str, Any]], object]


def sentence_of(ended: Ended) -> str:
    """The one sentence on standard error."""
    assert "Traceback" not in ended.err + ended.out
    (sentence,) = ended.sentences
    return sentence


def told(*words: str | Path) -> dict[str, Any]:
    """The error of a command with --json, which says the same on both streams."""
    ended = halfroll(*words, "--json")
    assert ended.code == 2
    error: dict[str, Any] = ended.json["error"]
    assert error["message"] == sentence_of(ended)
    return error


def changed(folder: Path, change: Change) -> Path:
    """The box with something about its item 2 changed."""
    document = json.loads(BOX.read_text())
    change(document["mission"]["items"][2])
    file = folder / "changed.plan"
    file.write_text(json.dumps(document))
    return file


@pytest.mark.parametrize("command", ["check", "plan", "fly"])
def test_a_file_that_is_not_there_is_named(command: str) -> None:
    error = told(command, "not_there.plan")
    assert error["kind"] == "input"
    assert "not_there.plan" in error["message"]


@pytest.mark.parametrize("command", ["check", "plan", "fly"])
def test_broken_json_is_said_with_its_line(command: str, tmp_path: Path) -> None:
    (tmp_path / "broken.plan").write_text(BOX.read_text()[:700])
    error = told(command, tmp_path / "broken.plan")
    assert error["kind"] == "mission"
    assert "is not JSON" in error["message"]
    assert "line" in error["message"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"fileType": "Plan"}', '{"fileType": "Parameters", "version": 1}'])
def test_json_that_is_no_plan_is_said(tmp_path: Path, text: str) -> None:
    (tmp_path / "odd.plan").write_text(text)
    assert "odd.plan" in told("fly", tmp_path / "odd.plan")["message"]


@pytest.mark.parametrize("command", ["check", "fly"])
def test_an_unsupported_item_is_named_with_its_command(command: str, tmp_path: Path) -> None:
    error = told(command, changed(tmp_path, lambda item: item.update(command=84)))
    assert (error["kind"], error["item"]) == ("mission", 2)
    assert "item 2" in error["message"]
    assert "84" in error["message"]


def test_every_unsupported_item_is_listed_by_check(tmp_path: Path) -> None:
    document = json.loads(BOX.read_text())
    for seq in (1, 3):
        document["mission"]["items"][seq]["command"] = 84
    (tmp_path / "two.plan").write_text(json.dumps(document))
    ended = halfroll("check", tmp_path / "two.plan", "--json")
    assert ended.code == 2
    assert not ended.json["supported"]
    assert [(each["index"], each["command"]) for each in ended.json["unsupported"]] == [(1, 84), (3, 84)]


@pytest.mark.parametrize("command", ["check", "plan", "fly"])
def test_a_height_that_is_not_given_is_named_by_its_item(command: str, tmp_path: Path) -> None:
    error = told(command, changed(tmp_path, lambda item: item["params"].__setitem__(6, None)))
    assert (error["kind"], error["item"]) == ("mission", 2)
    assert "item 2" in error["message"]


@pytest.mark.parametrize("command", ["check", "plan", "fly"])
def test_nan_in_a_mission_is_refused_with_what_to_write_instead(command: str, tmp_path: Path) -> None:
    error = told(command, changed(tmp_path, lambda item: item["params"].__setitem__(6, float("nan"))))
    assert error["kind"] == "mission"
    assert "NaN" in error["message"]
    assert "null" in error["message"]


@pytest.mark.parametrize("command", ["check", "plan", "fly"])
def test_a_vehicle_that_cannot_hover_is_told_its_weight_and_its_thrust(command: str) -> None:
    error = told(command, BOX, "--set", "mass_kg=5")
    assert error["kind"] == "vehicle"
    assert "cannot hover" in error["message"]
    assert "12.0 N" in error["message"]
    assert "49." in error["message"]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--vehicle", "zeppelin"], "zeppelin"),
        (["--vehicle", "zeppelin.toml"], "zeppelin.toml"),
        (["--set", "rotor.colour=2"], "rotor.colour"),
        (["--set", "mass_kg=heavy"], "mass_kg"),
        (["--set", "mass_kg"], "mass_kg"),
        (["--scenario", "storm"], "storm"),
        (["--limits", "none"], "none"),
        (["--margin", "2"], "margin"),
        (["--seed", "-1"], "--seed"),
        (["--no-such-option"], "--no-such-option"),
    ],
)
def test_an_option_that_is_wrong_is_named(words: list[str], named: str) -> None:
    assert named in told("fly", BOX, *words)["message"]


def test_a_command_that_does_not_exist_is_named() -> None:
    ended = halfroll("hover")
    assert ended.code == 2
    assert "hover" in sentence_of(ended)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--no-such-option"], "--no-such-option"),
        (["--vehicle", "zeppelin"], "zeppelin"),
        (["--set", "mass_kg=5"], "cannot hover"),
        (["--instance", "12"], "12"),
        (["--origin", "here"], "here"),
    ],
)
def test_the_simulator_names_what_is_wrong_with_its_options(words: list[str], named: str) -> None:
    ended = halfroll("sitl", *words)
    assert ended.code == 2
    (sentence,) = ended.err.splitlines()
    assert named in sentence


def test_the_ground_station_names_an_instance_it_has_no_ports_for() -> None:
    ended = halfroll("ground", "--instance", "12")
    assert ended.code == 2
    assert "12" in sentence_of(ended)


def test_results_that_cannot_be_written_are_refused_before_the_flight() -> None:
    error = told("fly", BOX, "--out", "/proc/nowhere")
    assert "/proc/nowhere" in error["message"]
