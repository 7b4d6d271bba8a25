"""A scenario space says what varies; run i is a function of (space, seed, i); what is wrong is said before flying."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from spaces import EXAMPLES, hop_space

from halfroll.campaign.axes import Axis
from halfroll.campaign.sampling import blocks, grid_size, runs_of
from halfroll.campaign.space import SpaceError, load_space

MASS, SHARE = "vehicle.mass_kg", "scenario.mocap.dropout"
WIDE = {MASS: {"uniform": [0.9, 1.1], "times": True}, SHARE: {"loguniform": [0.001, 0.1]}}


@pytest.mark.parametrize("sampling", ["sobol", "lhs", "random", "saltelli"])
def test_a_run_is_the_same_alone_and_among_others(tmp_path, sampling):
    space = hop_space(tmp_path, sampling=sampling, runs=64, vary=WIDE)
    together = runs_of(space, 0, 64)
    assert [runs_of(space, i, 1)[0] for i in (0, 1, 17, 63)] == [together[i] for i in (0, 1, 17, 63)]
    assert [run for block in blocks(space, [2, 3, 9, 30], size=8) for run in block] == [
        together[i] for i in (2, 3, 9, 30)
    ]
    assert len({run.seed for run in together}) == (64 if sampling != "saltelli" else 16)


def test_another_seed_draws_other_runs(tmp_path):
    first, second = (runs_of(hop_space(tmp_path, seed=seed, vary=WIDE), 0, 8) for seed in (1, 2))
    assert not {run.seed for run in first} & {run.seed for run in second}
    assert all(a.values != b.values for a, b in zip(first, second, strict=True))


@pytest.mark.parametrize("sampling", ["sobol", "lhs"])
def test_designed_samples_fill_every_stratum_once(tmp_path, sampling):
    space = hop_space(tmp_path, sampling=sampling, runs=64, vary={MASS: {"uniform": [0.9, 1.1], "times": True}})
    shares = [(run.values[MASS] - 0.9) / 0.2 for run in runs_of(space, 0, 64)]
    assert sorted(int(share * 64) for share in shares) == list(range(64))


def test_a_grid_flies_every_combination_and_then_all_again_with_other_seeds(tmp_path):
    vary = {MASS: {"grid": [0.5, 0.6, 3]}, "scenario.fault.0.kind": {"choice": ["weak-rotor", "stuck-rotor"]}}
    folder_scenario = tmp_path / "weak.toml"
    folder_scenario.write_text('like = "nominal"\n[[fault]]\nkind = "weak-rotor"\nat_s = 9.0\n')
    space = hop_space(tmp_path, sampling="grid", vary=vary, scenario="weak.toml")
    assert grid_size(space) == 6
    runs = runs_of(space, 0, 12)
    assert len({tuple(run.values.values()) for run in runs[:6]}) == 6
    assert [run.values for run in runs[6:]] == [run.values for run in runs[:6]]
    assert len({run.seed for run in runs}) == 12


@settings(deadline=None)  # SciPy comes with the first
@given(st.floats(0.001, 0.999))
def test_an_axis_turns_shares_into_quantiles(share):
    cases = {
        stats.uniform(2.0, 3.0): Axis(uniform=(2.0, 5.0)),
        stats.loguniform(0.1, 10.0): Axis(loguniform=(0.1, 10.0)),
        stats.truncnorm(-1.5, 2.0, 1.0, 2.0): Axis(normal=(1.0, 2.0), low=-2.0, high=5.0),
    }
    for oracle, axis in cases.items():
        (value,) = axis.values(np.array([share]))
        assert value == pytest.approx(oracle.ppf(share), rel=1e-9, abs=1e-9)


def test_the_plan_and_the_autopilot_do_not_know_what_varies_of_the_vehicle_unless_each_run_is_planned(tmp_path):
    heavy = {MASS: 1.1}
    once = hop_space(tmp_path).setup(heavy)
    assert once.vehicle.mass_kg == pytest.approx(1.1 * once.known.mass_kg)
    each = hop_space(tmp_path, plan={"mode": "paper", "once": False}).setup(heavy)
    assert each.vehicle.mass_kg == each.known.mass_kg == once.vehicle.mass_kg


def test_a_factor_scales_all_moments_of_inertia_together(tmp_path):
    vary = {"vehicle.inertia_kg_m2": {"uniform": [0.9, 1.1], "times": True}}
    setup = hop_space(tmp_path, vary=vary).setup({"vehicle.inertia_kg_m2": 1.1})
    assert np.array(setup.vehicle.inertia_kg_m2) == pytest.approx(1.1 * np.array(setup.known.inertia_kg_m2))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"vary": {"scenario.mocap.delay": {"uniform": [0.0, 0.1]}}}, "mocap.delay is not a known key"),
        ({"vary": {"vehicle.rotor.wings": {"uniform": [0.0, 0.1]}}}, "rotor.wings"),
        ({"vary": {"weather.rain": {"uniform": [0.0, 0.1]}}}, "keys begin with vehicle"),
        ({"vary": {"params.NO_SUCH": {"uniform": [0.0, 0.1]}}}, "no parameter NO_SUCH"),
        ({"vary": {"params.ATT_WN": {"uniform": [16.0, 600.0]}}}, "ATT_WN lies between 1 and 60"),
        ({"vary": {SHARE: {"uniform": [0.5, 1.5]}}}, "vary scenario.mocap.dropout = 1.5: mocap.dropout"),
        ({"vary": {MASS: {"uniform": [0.5, 3.0]}}}, "it cannot hover"),
        ({"vary": {MASS: {"uniform": [1.1, 0.9]}}}, "the first is the smaller one"),
        ({"vary": {MASS: {"normal": [1.0, 0.1]}}}, "normal is cut off"),
        ({"vary": {MASS: {}}}, "says nothing; give one of"),
        ({"vary": {"plan.margin": {"uniform": [0.1, 0.2]}}}, "the mission is planned once"),
        ({"vary": {"link.loss": {"uniform": [0.0, 0.2]}}, "fidelity": "sitl"}, "fly it closed-loop"),
        ({"sampling": "grid"}, "sampling grid wants axes with grid or choice"),
        ({"vary": {}, "sampling": "sobol"}, "but nothing varies"),
        ({"mission": "nowhere.toml"}, "is not there"),
        ({"runs": 0}, "runs"),
        ({"set": {MASS: 0.6}}, "both set and varied"),
        ({"colour": "red"}, "colour is not a known key"),
    ],
)
def test_what_is_wrong_with_a_space_is_one_sentence_that_names_it(tmp_path, changes, sentence):
    with pytest.raises(SpaceError) as error:
        hop_space(tmp_path, **changes)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("campaign_*.toml")), ids=lambda p: p.stem)
def test_the_spaces_that_are_shipped_are_sound(file):
    if "mission" in file.read_text():
        assert len(runs_of(load_space(file), 0, 3)) == 3
