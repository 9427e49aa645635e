"""One network for places, reports, relays and loop closures: it flies by rules untrained, and else by its values."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from indoor_explorers.env import InputError, World, make_policy, scenario
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.learners.places.flights import POINT, ChoiceArrays, fly
from indoor_explorers.learners.places.learning import OPTION_PASSES, learn_choices, learn_values, outputs
from indoor_explorers.learners.places.model import AdvantageNet, weights_of
from indoor_explorers.learners.places.network import Loaded, OptionWeights, grown, load_weights, values, write_weights
from indoor_explorers.learners.places.options import OPTION_COMMON, Option, Options
from indoor_explorers.learners.places.policy import SHIPPED, SHIPPED_OPTIONS
from indoor_explorers.learners.places.scene import COMMON, MOST
from indoor_explorers.learners.places.train import PlacesTraining, TrainingConfig
from indoor_explorers.learners.places.truth import TRUE_COMMON
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.reports.flights import TRUE
from indoor_explorers.learners.reports.network import load_weights as load_reports
from indoor_explorers.learners.reports.network import value
from indoor_explorers.learners.reports.policy import SHIPPED as REPORTS_SHIPPED
from indoor_explorers.learners.reports.situation import NUMBERS, Situation
from tests.learners.places.small import random_choices, random_scene

BASE = {"base.at": "start", "base.must_return": True, "budget": 300}
DRIFT = {"drift.rate": 0.002, "budget": 400}
REPORT = MOST + Option.REPORT


def untrained(prefers: Sequence[float] = (0.0, 0.0, 0.0)) -> Loaded:
    """A network that flies to places as the shipped one, and prefers options beyond the rules."""
    torch.manual_seed(0)
    shipped = load_weights(SHIPPED)
    weights = grown(shipped, weights_of(AdvantageNet(options=True)), task=False)
    assert isinstance(weights, OptionWeights)
    weights = weights._replace(option_out_bias=np.array(prefers, np.float32))
    return shipped._replace(weights=weights, options=True)


Flown = tuple[World, list[Pilot], list[Any]]


def flown(
    folder: Path, loaded: Loaded, settings: dict[str, Any], preset: str = "small-offices", seed: int = 5
) -> Flown:
    write_weights(folder / "places.safetensors", loaded)
    return path_of(f"dddqn-places:{folder}", settings, preset, seed)


def path_of(name: str, settings: dict[str, Any], preset: str, seed: int = 5, **parameters: Any) -> Flown:
    """A flight of a policy: the world at the end, the pilots, and the cells of the UAVs at each step."""
    world, policy = World(scenario(preset).with_settings(settings)), make_policy(name, **parameters)
    world.reset([seed])
    pilots = make_pilots(policy, world)
    path = [world.state.cell[0].tolist() for _ in rollout(world, ask_pilots(policy, pilots, world))]
    return world, [pilots[0, n] for n in range(world.scenario.team)], path


@pytest.mark.parametrize("settings", [{"team": 2}, {"team": 1, "lidar.field_of_view": 90.0}])
def test_without_a_base_or_drift_it_flies_to_places_alone(tmp_path: Path, settings: dict[str, Any]) -> None:
    settings = {"budget": 120, **settings}
    plain = path_of("dddqn-places", settings, "small-floors")[2]
    assert flown(tmp_path, untrained(), settings, "small-floors")[2] == plain


def test_the_values_of_options_decide_about_reports(tmp_path: Path) -> None:
    """Untrained it reports by the rule; with options that are never or always preferred, at the end or always."""
    trips, known = [], []
    for prefers in (-100.0, 0.0, 100.0):
        world, pilots, _ = flown(tmp_path, untrained((prefers, 0.0, 0.0)), {"team": 2, **BASE})
        trips.append(sum(pilot.tally()["flights_home"] for pilot in pilots))
        assert world.base_coverage[0] == world.team_coverage[0]
        known.append(float(world.base_coverage[0]))
    assert trips[0] <= 2 < trips[1] < trips[2]
    assert known[2] < known[0]


def test_the_values_of_options_are_explained(tmp_path: Path) -> None:
    write_weights(tmp_path / "places.safetensors", untrained((-100.0, -100.0, 0.0)))
    policy = make_policy(f"dddqn-places:{tmp_path}")
    world = World(scenario("small-offices").with_settings({"team": 2, **BASE}))
    world.reset([5])
    pilots, notes = make_pilots(policy, world), set()
    for pilot in pilots.values():
        pilot.explaining = True
    for _, _ in zip(range(60), rollout(world, ask_pilots(policy, pilots, world)), strict=False):
        found = pilots[0, 0].explain()
        assert found is not None
        notes.add(found.note.rpartition(" ")[0])
    assert "beyond the best place: report" in notes
    assert "beyond the best place: relay" in notes


def test_a_relay_stays_in_contact(tmp_path: Path) -> None:
    """Where staying is always preferred, no UAV ever leaves the contact with the base that it begins with."""
    settings = {"team": 2, "radio.model": "disc", "radio.range": 15.0, **BASE}
    path = flown(tmp_path, untrained((0.0, 100.0, 0.0)), settings)[2]
    assert all(cells == path[0] for cells in path)
    path = flown(tmp_path, untrained((0.0, 100.0, 0.0)), {**settings, "team": 1})[2]
    assert any(cells != path[0] for cells in path), "a single UAV is no relay"


def test_the_values_of_options_decide_about_loop_closures(tmp_path: Path) -> None:
    closing = []
    for prefers in (-100.0, 0.0, 100.0):
        world, pilots, _ = flown(tmp_path, untrained((0.0, 0.0, prefers)), {"team": 1, **DRIFT}, "small-floors", 1)
        closing.append(pilots[0].tally()["closing"])
    (rule,) = path_of("loop-closing", {"team": 1, **DRIFT}, "small-floors", 1, explorer="dddqn-places")[1]
    assert rule.tally()["closing"] > 0.0
    assert closing[0] < closing[2]
    assert closing[2] > 0.0
    assert world.team_coverage[0] > 0.9


def test_flights_with_a_base_are_recorded() -> None:
    """What a flight costs are the points that its base lacks; options stand behind the places."""
    loaded = untrained()
    flight = fly(TrainingMaps(), 8, loaded, bases=1.0)
    assert np.isnan(flight.times).all()
    taken = np.zeros(len(Option))
    for arrays in flight.choices:
        count = len(arrays["chosen"])
        assert arrays["there"].shape == arrays["probabilities"].shape == (count, MOST + len(Option))
        assert arrays["common"].shape == (count, COMMON + OPTION_COMMON)
        assert arrays["true_common"].shape == (count, TRUE_COMMON + TRUE)
        assert arrays["there"][np.arange(count), arrays["chosen"]].all()
        assert (arrays["probabilities"][~arrays["there"]] == 0.0).all()
        np.testing.assert_allclose(arrays["probabilities"].sum(axis=1), 1.0, rtol=1e-5)
        assert not arrays["there"][:, MOST + Option.CLOSE].any()
        in_contact = arrays["there"][:, MOST + Option.RELAY]
        assert not (in_contact & arrays["there"][:, MOST + Option.REPORT]).any()
        assert (arrays["common"][:, COMMON : COMMON + NUMBERS] != 0.0).any(axis=1).all()
        assert (arrays["discounts"] == 1.0).all()
        assert -100.0 * POINT < arrays["rewards"].sum() < 0.0
        taken += np.bincount(arrays["chosen"], minlength=MOST + len(Option))[MOST:]
    assert taken[Option.REPORT] > 0
    assert taken[Option.RELAY] > 0


def test_options_are_drawn_alone_where_they_alone_learn() -> None:
    """Of the places the best one is flown to, so that nothing else is tried than options."""
    flight = fly(TrainingMaps(), 8, untrained(), bases=1.0, options_alone=True)
    for arrays in flight.choices:
        of_places = arrays["probabilities"][:, :MOST]
        assert ((of_places > 0.0).sum(axis=1) == 1).all()
        assert (of_places.sum(axis=1) < 1.0)[arrays["there"][:, REPORT]].any()


def test_choices_among_options_do_not_change_which_places_are_flown_to(tmp_path: Path) -> None:
    """Where no option is preferred, the UAVs fly as with the rule that explores until the deadline, to the cell."""
    settings = {"team": 2, **BASE}
    path = flown(tmp_path, untrained((-100.0, -100.0, 0.0)), settings)[2]
    rule = path_of("return-to-base", settings, "small-offices", when="deadline", explorer="dddqn-places")[2]
    assert path == rule


def test_flights_that_drift_end_when_all_is_shown_rightly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("indoor_explorers.learners.places.flights.harder_settings", lambda *_: {"drift.rate": 0.002})
    (arrays,) = fly(TrainingMaps(), 2, untrained(), harder=1.0).choices
    offered = arrays["there"][:, MOST + Option.CLOSE]
    assert offered.any()
    assert (arrays["common"][offered, COMMON + NUMBERS] == 1.0).all()
    assert (arrays["common"][~offered, COMMON + NUMBERS] == 0.0).all()
    assert (arrays["discounts"] < 1.0).all()
    assert arrays["there"][:, MOST:].sum() == offered.sum()


def with_reports(count: int) -> ChoiceArrays:
    """Random choices, among which are reports, a quarter of those made."""
    choices = random_choices(count)
    offered = np.tile(np.arange(len(Option)) == Option.REPORT, (count, 1))
    there = np.concatenate([choices.arrays["there"], offered], axis=1)
    numbers = np.random.default_rng(3).normal(size=(count, OPTION_COMMON)).astype(np.float32)
    arrays = {
        "there": there,
        "probabilities": (there / there.sum(axis=1, keepdims=True)).astype(np.float32),
        "chosen": np.where(np.random.default_rng(2).random(count) < 0.25, REPORT, choices.arrays["chosen"]),
        "common": np.concatenate([choices.arrays["common"], numbers], axis=1),
    }
    return choices._replace(arrays={**choices.arrays, **arrays})


def test_a_better_option_becomes_likelier() -> None:
    """Reports that were worth five lidar ranges more than other choices gain on all places."""
    torch.manual_seed(0)
    choices, network = with_reports(20_000), AdvantageNet(options=True)
    before = outputs(network, choices)
    learn_choices(network, choices, np.where(choices.arrays["chosen"] == REPORT, 5.0, 0.0).astype(np.float32))
    change = outputs(network, choices) - before
    assert (change[:, REPORT] - change[:, :3].max(axis=1)).mean() > 0.5
    assert (change[:, [MOST + Option.RELAY, MOST + Option.CLOSE]] == 0.0).all()


def test_options_can_learn_alone() -> None:
    """Places keep their values, to the bit."""
    torch.manual_seed(0)
    choices, network = with_reports(4096), AdvantageNet(options=True)
    network.keep_places()
    before = outputs(network, choices)
    worth = np.where(choices.arrays["chosen"] == REPORT, 5.0, 0.0).astype(np.float32)
    learn_choices(network, choices, worth, OPTION_PASSES)
    change = outputs(network, choices) - before
    assert (change[:, :MOST] == 0.0).all()
    assert change[:, REPORT].mean() > 0.1
    with pytest.raises(ValueError, match="expected options=true"):
        TrainingConfig(options_alone=True)


def test_with_options_values_do_not_depend_on_the_units_of_their_inputs() -> None:
    choices = with_reports(2048)
    scaled = choices._replace(arrays={**choices.arrays, "common": 20.0 * choices.arrays["common"] + 5.0})
    judged = []
    for each in (choices, scaled):
        torch.manual_seed(0)
        judged.append(learn_values(each))
    np.testing.assert_allclose(judged[0], judged[1], atol=0.2)
    assert judged[0].std() > 0.2


def test_a_training_with_options_begins_with_the_weights_of_another(tmp_path: Path) -> None:
    config = TrainingConfig(initial_weights="shipped", task_inputs=True, options=True)
    begun = PlacesTraining(config, 1, tmp_path).mean()
    assert begun.options
    assert begun.task
    write_weights(tmp_path / "places.safetensors", begun)
    assert load_weights(tmp_path / "places.safetensors")[1:] == begun[1:]
    given = {"initial_weights": str(tmp_path)}
    assert TrainingConfig(**given, task_inputs=True, options=True).initial is not None
    for other in ({"task_inputs": True}, {"options": True}):
        with pytest.raises(ValueError, match="expected weights of a network with"):
            TrainingConfig(**given, **other)


def test_a_training_can_begin_with_the_values_of_reports_that_another_network_learned(tmp_path: Path) -> None:
    """Reports are valued as by ``dddqn-reports``, the other options by rules, and places as before."""
    begins = {"initial_weights": "shipped", "options": True}
    without, begun = (
        PlacesTraining(TrainingConfig(**begins, **more), 1, tmp_path).mean()
        for more in ({}, {"initial_reports": "shipped"})
    )
    scene = random_scene(5)
    for rule in (-1.5, 0.5):
        numbers = np.random.default_rng(7).normal(size=OPTION_COMMON).astype(np.float32)
        options = Options(numbers, np.array([rule, -2.0, 2.0], np.float32))
        before, found = (values(scene.with_options(options), each) for each in (without, begun))
        np.testing.assert_array_equal(np.delete(found, 5), np.delete(before, 5))
        expected = value(Situation(numbers[:NUMBERS], rule), load_reports(REPORTS_SHIPPED))
        np.testing.assert_allclose(found[5] - found[:5].max(), expected, atol=1e-4)
        assert abs(expected - rule) > 0.01
    for other, message in (({"options": False}, "options false"), ({"width": 40}, "width 40")):
        with pytest.raises(ValueError, match=message):
            TrainingConfig(**{"options": True, "initial_reports": "shipped", **other})


def test_no_rounds_write_the_network_that_a_training_begins_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The weights that ship are those; nothing is evaluated."""
    begins = ["rounds=0", "options=true", "initial_weights=shipped", "initial_reports=shipped"]
    words = ["--learner", "dddqn-places", "--set", *begins, "--seed", "1", "--out", str(tmp_path)]
    assert main(["train", *words]) == 0
    path = tmp_path / "places.safetensors"
    assert capsys.readouterr().out == f"Weights: {path}\n"
    written, shipped = (load_weights(file) for file in (path, SHIPPED_OPTIONS))
    assert written[1:] == shipped[1:]
    for one, other in zip(written.weights, shipped.weights, strict=True):
        np.testing.assert_array_equal(one, other)


def test_weights_that_are_named_are_not_replaced_by_those_with_options(tmp_path: Path) -> None:
    write_weights(tmp_path / "places.safetensors", untrained())
    with pytest.raises(InputError, match="expected weights or options, got both"):
        make_policy(f"dddqn-places:{tmp_path}", options=True)
