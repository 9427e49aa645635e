"""From a request that names a suite to an experiment: all of its tasks, or some, and no others."""

from pathlib import Path

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from tests.suites import tiny, tiny_clones

__all__ = ["tiny", "tiny_clones"]


def planned(**options):
    return plan(ComparisonRequest.of(policies=["frontier-nearest"], **options))


def test_a_suite_is_flown_whole_on_its_test_part(tiny: Path):
    whole = planned(suite="tiny", data=tiny)
    assert [scenario.name for scenario in whole.scenarios] == ["tiny-1", "tiny-2-none", "tiny-2-disc"]
    assert {scenario.map.count for scenario in whole.scenarios} == {3}
    assert (whole.seed, whole.episodes) == (32_000_000, 2)
    assert len(whole.tasks()) == 18
    assert {scenario.lidar.range for scenario in whole.scenarios} == {4.0}


def test_another_part_has_other_maps_and_seeds(tiny: Path):
    train = planned(suite="tiny", part="train", data=[tiny])
    assert [scenario.map.paths for scenario in train.scenarios] == [(str(tiny / "plans/deep/d.npy"),)] * 3
    assert train.seed == 30_000_000


def test_some_of_a_suite(tiny: Path):
    some = planned(suite="tiny", data=tiny, radio=["disc"], maps=["A"], episodes=1)
    assert [scenario.name for scenario in some.scenarios] == ["tiny-1", "tiny-2-disc"]
    assert len(some.tasks()) == 4
    assert [scenario.name for scenario in planned(suite="tiny", data=tiny, team=2, radio="none").scenarios] == [
        "tiny-2-none"
    ]
    named = planned(suite="tiny", data=tiny, scenario=["tiny-2-disc", "tiny-1"]).scenarios
    assert [scenario.name for scenario in named] == ["tiny-1", "tiny-2-disc"]


def test_policies_of_an_experiment_file_fly_a_suite(tiny: Path, tmp_path: Path):
    (tmp_path / "mine.toml").write_text(
        'policies = [{use = "pso", name = "mine", parameters = {candidates = 8}}]\n'
        'scenarios = ["office"]\nseed = 7\nset = {goal = 0.5}\n'
    )
    flown = plan(ComparisonRequest.of(experiment=tmp_path / "mine.toml", suite="tiny", data=tiny, team=1))
    assert [choice.parameters for choice in flown.policies] == [{"candidates": 8}]
    assert ([scenario.name for scenario in flown.scenarios], flown.seed) == (["tiny-1"], 32_000_000)
    assert flown.scenarios[0].goal == 1.0


def test_a_generated_suite_needs_no_data():
    rooms = planned(suite="rooms", part="validation", team=4, radio="unlimited")
    assert [scenario.name for scenario in rooms.scenarios] == ["rooms-4-unlimited"]
    assert (rooms.seed, rooms.episodes) == (31_000_000, 100)


def test_listed_scenarios_have_maps_of_their_own():
    some = planned(suite="atlas", part="validation", team=8, episodes=3)
    assert [(scenario.name, scenario.map.source) for scenario in some.scenarios] == [("atlas-floor-8", "floors")]
    assert (some.seed, some.episodes) == (31_000_000, 3)
    two = planned(suite="atlas", part="validation", scenario=["atlas-home", "atlas-drift"]).scenarios
    assert [(scenario.map.source, scenario.drift.rate) for scenario in two] == [("homes", 0.0), ("floors", 0.002)]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"maps": ["a"]}, "suite 'atlas' generates its maps; leave --maps out"),
        ({"part": "train"}, "suite 'atlas' has no train part; ask for its validation or test part"),
        ({"radio": "disc"}, "suite 'atlas' has no radio 'disc'"),
        ({"team": 3}, "suite 'atlas' has teams of 1, 2, 4, 8 UAVs, got --team 3"),
    ],
)
def test_what_listed_scenarios_do_not_have_is_told_in_a_line(options, message):
    with pytest.raises(InputError, match=message):
        planned(suite="atlas", **options)


def test_a_listed_scenario_of_another_generator_is_refused(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("indoor_explorers.env.scenarios.suites.clones.digest_of", lambda maps, seeds: "0" * 16)
    with pytest.raises(InputError, match="atlas 1: the test part of atlas-home is not what it was"):
        planned(suite="atlas", scenario="atlas-home")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scenario": "office"}, "suite 'tiny' has no scenario 'office'; known: tiny-1, tiny-2-disc, tiny-2-none"),
        ({"settings": {"goal": 0.9}}, "suite 'tiny' has fixed tasks; leave --set out"),
        ({"seed": 3}, "leave --seed out"),
        ({"resolution": 0.5}, "leave --resolution out"),
        ({"episodes": 3}, "suite 'tiny' has 2 episodes a map in its test part, got --episodes 3"),
        ({"team": 4}, "suite 'tiny' has teams of 1, 2 UAVs, got --team 4"),
        ({"radio": "discs"}, "suite 'tiny' has no radio 'discs'; did you mean 'disc'"),
        ({"maps": ["z"]}, "no map 'z' in the test part"),
        ({"suite": "tny"}, "unknown suite 'tny'; did you mean 'tiny'"),
        ({"part": "tst"}, "comparison: part: "),
    ],
)
def test_what_a_suite_does_not_have_is_told_in_a_line(tiny: Path, options, message):
    with pytest.raises(InputError) as told:
        planned(**{"suite": "tiny", "data": tiny} | options)
    assert message in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("options", "flag"), [({"data": "."}, "--data"), ({"part": "train"}, "--part"), ({"radio": "disc"}, "--radio")]
)
def test_options_of_suites_need_one(options, flag):
    with pytest.raises(InputError, match=f"expected --suite with {flag}, got none"):
        planned(**options)
