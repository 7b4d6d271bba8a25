"""Scenario files: what is accepted, what is refused and how, and the numbers that go to the simulator."""

import re

import pytest

from halfroll import _firmware, simulator
from halfroll.errors import ScenarioError
from halfroll.scenario import load_scenario, shipped_scenarios

WINDY = """
vehicle = "mit-fp"
seed = 11
[effects]
drag = true
[wind]
mean_m_s = [0, -2.5, 0]
[[wind.gust]]
at_s = 3
velocity_m_s = [0, 0, 1]
[[fault]]
kind = "dead-rotor"
at_s = 4.0
rotor = 3
"""


@pytest.fixture
def windy(tmp_path):
    file = tmp_path / "windy.toml"
    file.write_text(WINDY)
    return file


@pytest.mark.parametrize("name", shipped_scenarios())
def test_every_shipped_scenario_loads_and_tells_what_it_is(name):
    assert load_scenario(name).description
    _firmware.scenario_setup(name)


@pytest.mark.parametrize("name", shipped_scenarios())
def test_a_shipped_scenario_by_name_and_by_its_numbers_is_one_world(name):
    plant = _firmware.vehicle_setup("mit-vp").plant
    words = [f"{key}={number:.17g}" for key, number in load_scenario(name).numbers().items()]
    by_name = _firmware.World(plant, name, 5)
    by_number = _firmware.World(plant, _firmware.scenario_setup("ideal", words), 5)
    for world in (by_name, by_number):
        for _ in range(200):
            world.step([1.5, 1.4, 1.5, 1.41])
    assert by_name.same_state(by_number)


def test_a_scenario_file_brings_vehicle_and_seed(windy):
    scenario = load_scenario(windy)
    assert (scenario.vehicle, scenario.seed) == ("mit-fp", 11)
    assert scenario.numbers()["fault.0.kind"] == 3.0
    assert scenario.numbers()["wind.gust.0.velocity_m_s.2"] == 1.0
    words = simulator.arguments(["--scenario", str(windy), "--lockstep"])
    assert words[words.index("--vehicle") + 1] == "mit-fp"
    assert words[words.index("--seed") + 1] == "11"
    assert "wind.mean_m_s.1=-2.5" in words
    assert words[-1] == "--lockstep"
    assert simulator.arguments(["--scenario", str(windy), "--vehicle", "race-5in"])[-1] == "race-5in"
    assert simulator.arguments(["--scenario", "windy"]) == ["--scenario", "windy"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"wind.mean_m_s.0": 80}, "wind.mean_m_s.0 is 80.0: input should be less than or equal to 50"),
        ({"wind.speed": 3}, "wind.speed is not a known key; check its spelling"),
        ({"mocap.dropout": "often"}, "mocap.dropout is 'often'"),
        ({"wind.mean_m_s.7": 3}, "scenario has no number called wind.mean_m_s.7"),
        ({"fault.0.kind": "tired-rotor"}, "fault.0.kind is 'tired-rotor'"),
        ({"mocap.rate_hz": 500, "mocap.delay_s": 0.05}, "more than 16 periods"),
    ],
)
def test_a_wrong_number_is_refused_with_key_and_limit(windy, change, says):
    with pytest.raises(ScenarioError, match=re.escape(says)):
        load_scenario(windy, change)


def test_a_fault_that_ends_before_it_begins_is_refused(tmp_path):
    file = tmp_path / "odd.toml"
    file.write_text('[[fault]]\nkind = "mocap-lost"\nat_s = 5\nuntil_s = 4\n')
    with pytest.raises(ScenarioError, match="fault mocap-lost ends at 4 s, not after it begins at 5 s"):
        load_scenario(file)


def test_an_unknown_scenario_is_refused_with_those_there_are():
    with pytest.raises(ScenarioError, match="no scenario is called storm; shipped are faults, full, ideal"):
        load_scenario("storm")
