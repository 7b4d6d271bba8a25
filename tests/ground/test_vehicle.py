"""Vehicle files: what is accepted, what is refused and how, and the numbers that go to the simulator."""

import re
from pathlib import Path

import pytest

from halfroll._firmware import vehicle_setup
from halfroll.errors import VehicleError
from halfroll.vehicle import GRAVITY, built_vehicle, load_vehicle, shipped_vehicles


@pytest.mark.parametrize("name", ["mit-fp", "mit-vp", "paper-faithful", "paper-plan", "race-5in"])
def test_shipped_vehicles_load_and_can_hover(name):
    vehicle = load_vehicle(name)
    assert vehicle.name == name
    assert name in shipped_vehicles()
    assert 4.0 * vehicle.rotor.thrust_max_N > 1.5 * vehicle.mass_kg * GRAVITY


def test_the_paper_vehicle_pushes_both_ways():
    vehicle = load_vehicle("mit-vp")
    assert vehicle.variable_pitch
    assert vehicle.rotor.thrust_min_N == -vehicle.rotor.thrust_max_N == -3.0


def test_the_race_vehicle_has_four_times_its_weight_in_thrust():
    vehicle = load_vehicle("race-5in")
    assert 4.0 < 4.0 * vehicle.rotor.thrust_max_N / vehicle.weight < 4.5


def test_numbers_are_flat_with_dotted_keys():
    numbers = load_vehicle("mit-fp").numbers()
    assert numbers["inertia_kg_m2.2"] == 0.0068
    assert numbers["rotor.kind"] == 1.0
    assert numbers["rotor.thrust_max_N"] == 3.0
    assert numbers["params.LAG_COMP"] == 3.0
    assert load_vehicle("mit-vp").numbers()["rotor.kind"] == 0.0


def test_any_number_can_be_overridden_by_its_dotted_key():
    changes = {"rotor.thrust_max_N": "2.5", "inertia_kg_m2.1": 0.004, "params.ATT_WN": "12", "name": "mine"}
    vehicle = load_vehicle("mit-vp", changes)
    assert vehicle.rotor.thrust_max_N == 2.5
    assert vehicle.inertia_kg_m2 == (0.00365, 0.004, 0.0068)
    assert vehicle.params["ATT_WN"] == 12.0
    assert vehicle.name == "mine"
    assert load_vehicle("mit-vp").rotor.thrust_max_N == 3.0


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"rotor.thrust_max_N": "1.2"}, "4 rotors give at most 4.8 N, the weight is 5.6 N"),
        ({"rotor.thrust_min_N": "1.5"}, "4 rotors give at least 6.0 N"),
        ({"rotor.kind": "fixed-pitch"}, "cannot push down"),
        ({"rotor.kind": "rocket"}, "rotor.kind is 'rocket'"),
        ({"rotor.thrust_min_N": "4"}, "is not below thrust_max_N 3"),
        ({"mass_kg": "nan"}, "mass_kg is nan: input should be a finite number"),
        ({"mass_kg": "-1"}, "mass_kg is -1.0: input should be greater than 0"),
        ({"mass_kg": "heavy"}, "mass_kg is 'heavy'"),
        ({"inertia_kg_m2.2": "0.1"}, "no body has one moment larger"),
        ({"inertia_kg_m2.3": "0.1"}, "no number called inertia_kg_m2.3"),
        ({"rotor.thrust": "1"}, "rotor.thrust is not a known key"),
        ({"wing.area": "1"}, "no number called wing.area"),
        ({"params.att_wn": "1"}, "params.att_wn"),
    ],
)
def test_a_bad_number_is_refused_by_key_value_and_limit(changes, says):
    with pytest.raises(VehicleError, match=re.escape(says)):
        load_vehicle("mit-vp", changes)


def test_a_file_elsewhere_is_loaded_by_its_path(tmp_path):
    import halfroll.vehicle

    shipped = Path(halfroll.vehicle.__file__).with_name("vehicles") / "mit-vp.toml"
    mine = tmp_path / "mine.toml"
    mine.write_text(shipped.read_text().replace("mass_kg = 0.571", "mass_kg = 0.6"))
    assert load_vehicle(mine).mass_kg == 0.6
    mine.write_text(shipped.read_text().replace("arm_m", "# arm_m"))
    with pytest.raises(VehicleError, match="arm_m is missing"):
        load_vehicle(mine)
    mine.write_text("mass_kg = = 1")
    with pytest.raises(VehicleError, match="is not TOML"):
        load_vehicle(str(mine))


def test_a_file_that_is_like_a_shipped_vehicle_says_only_what_differs(tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text('like = "mit-fp"\nname = "mine"\nmass_kg = 0.6\n[rotor]\nlag_s = 0.1\n[params]\nATT_WN = 9\n')
    vehicle, shipped = load_vehicle(mine), load_vehicle("mit-fp")
    assert (vehicle.name, vehicle.mass_kg, vehicle.rotor.lag_s, vehicle.params["ATT_WN"]) == ("mine", 0.6, 0.1, 9.0)
    assert (vehicle.rotor.lag_down_s, vehicle.params["LAG_COMP"], vehicle.arm_m) == (0.12, 3.0, shipped.arm_m)
    mine.write_text('like = "mine"\nname = "mine"\n')
    with pytest.raises(VehicleError, match="is like 'mine', which is not shipped; like is one of mit-fp, mit-vp"):
        load_vehicle(mine)


@pytest.mark.parametrize("name", shipped_vehicles())
def test_a_shipped_vehicle_has_the_same_numbers_in_the_simulator(name):
    ours, theirs = load_vehicle(name), vehicle_setup(name)
    assert theirs.plant.mass == ours.mass_kg
    for parameter, number in ours.params.items():
        assert theirs.params[parameter] == pytest.approx(number), parameter


def test_the_paper_s_presets_differ_from_its_vehicle_only_where_they_say():
    shipped = load_vehicle("mit-vp")
    named = {"name": "mit-vp", "description": shipped.description}
    assert load_vehicle("paper-plan").model_copy(update={**named, "mass_kg": 0.571}) == shipped
    off = {"ACT_LEAD": 0.0, "FADE_FORCE": 0.0, "REF_EXTRAP": 0.0, "SIGN_RULE": 1.0, "VEH_DRAG": 0.0}
    faithful = load_vehicle("paper-faithful")
    assert faithful.params == off
    assert faithful.model_copy(update={**named, "params": shipped.params}) == shipped


def test_an_unknown_name_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(VehicleError, match="shipped are mit-fp, mit-vp, paper-faithful, paper-plan, race-5in"):
        load_vehicle("mit-xp")
    with pytest.raises(VehicleError, match="No such file"):
        load_vehicle(tmp_path / "none.toml")


def test_a_vehicle_that_is_built_takes_no_overrides():
    built = load_vehicle("mit-vp")
    assert built_vehicle(built) is built
    with pytest.raises(VehicleError, match="stays as it is"):
        built_vehicle(built, {"mass_kg": 0.6})
