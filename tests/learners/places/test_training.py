import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
import torch

from indoor_explorers.env import World, scenario
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.learners.places.flights import (
    DISCOUNT,
    TrainingFlight,
    choices_of,
    fly,
    read_choices,
    write_choices,
)
from indoor_explorers.learners.places.learning import (
    advantages,
    explained,
    learn_choices,
    learn_values,
    outputs,
)
from indoor_explorers.learners.places.model import AdvantageNet, batch_of, weights_of
from indoor_explorers.learners.places.network import Loaded, load_weights
from indoor_explorers.learners.places.policy import DddqnPlaces
from indoor_explorers.learners.places.scene import COMMON, GUESS, MOST, PLACE, Observer
from indoor_explorers.learners.places.train import PlacesTraining, TrainingConfig, train
from indoor_explorers.learners.places.truth import TrueMap, truth_of
from indoor_explorers.learners.pockets.improvement import minimise
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.sessions.session import Progress
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors
from indoor_explorers.planners.toolbox.pockets.estimates import DEFAULT_FILES, EstimateFiles
from indoor_explorers.planners.toolbox.pockets.estimates import SHIPPED as POCKETS
from tests.learners.places.small import random_choices, world_on_a_floor
from tests.learners.places.test_scene import pilot_of


def test_the_truth_is_what_is_left_to_explore() -> None:
    world = world_on_a_floor()
    view, truth = world.view(0, 0), np.array(world.state.truth[0])
    pilot = pilot_of(world)
    scene = Observer(pilot).observe(view)
    assert scene is not None
    reachable = distance_field(truth, view.cell) < UNREACHABLE
    true = TrueMap(truth, reachable, Levels.of(truth.shape, 1))
    told = truth_of(scene, pilot.clusters(view), view.belief, true, distance_field(view.belief, view.cell), 10.0)
    unknown = int(((view.belief != FREE) & reachable).sum())
    assert told.common[2] == pytest.approx(np.log1p(unknown) / 6.0)
    assert told.common[0] == pytest.approx((np.ceil(0.99 * reachable.sum()) - (reachable.sum() - unknown)) / 100.0)
    assert 0.0 < np.expm1(5.0 * told.places[:, 0].astype(np.float64)).sum() <= unknown + 1.0
    assert told.common[1] <= told.common[0]
    assert told.common[4] <= told.common[3]


def test_the_truth_of_a_building_counts_its_voxels() -> None:
    """Voxels are counted over all levels, and blocks of two voxels a side too."""
    world = World(scenario("small-storeys").with_settings({"team": 1}))
    world.reset([3])
    view, truth, levels = world.view(0, 0), np.array(world.state.truth[0]), world.briefing(0, 0).levels
    pilot = pilot_of(world)
    scene = Observer(pilot).observe(view)
    assert scene is not None
    field = distance_field(truth, view.cell, levels.rise)
    reachable = field < UNREACHABLE
    true, steps = TrueMap(truth, reachable, levels), pilot.steps_from(view, view.cell)
    told = truth_of(scene, pilot.clusters(view), view.belief, true, steps, 4.0)
    unknown = int(((view.belief != FREE) & reachable).sum())
    assert told.common[2] == pytest.approx(np.log1p(unknown) / 6.0)
    assert told.common[0] == pytest.approx((np.ceil(0.99 * reachable.sum()) - (reachable.sum() - unknown)) / 64.0)
    blocks = levels.volume(reachable & (view.belief != FREE))
    assert blocks.any(axis=(1, 2)).sum() > 3
    assert told.common[3] == pytest.approx(
        sum(
            blocks[k : k + 2, i : i + 2, j : j + 2].any()
            for k in range(0, 7, 2)
            for i in range(0, 24, 2)
            for j in range(0, 24, 2)
        )
        / 80.0
    )


def test_flights_in_buildings_are_recorded_as_others() -> None:
    torch.manual_seed(0)
    loaded = Loaded(weights_of(AdvantageNet()), 0.45, guess=True, others=True)
    first, again = (fly(TrainingMaps(levels=1.0), 4, loaded) for _ in range(2))
    assert len(first.choices) == 4
    for arrays, same in zip(first.choices, again.choices, strict=True):
        assert all(np.array_equal(arrays[name], same[name]) for name in arrays)
        assert (arrays["places"][..., GUESS][..., 1:6] == 0.0).all()
        assert arrays["true_places"][..., 0].max() > 0.0


def test_advantages_are_returns_less_values_or_single_surprises() -> None:
    choices = random_choices(8)
    rewards, durations = choices.arrays["rewards"], choices.arrays["durations"]
    values = np.random.default_rng(0).normal(size=8).astype(np.float32)
    whole, next_only = advantages(choices, values, 1.0), advantages(choices, values, 0.0)
    for first in (0, 4):
        following = 0.0
        for k in reversed(range(first, first + 4)):
            following = rewards[k] + DISCOUNT ** durations[k] * following
            assert whole[k] == pytest.approx(following - values[k], rel=1e-4)
            after = values[k + 1] if k < first + 3 else 0.0
            assert next_only[k] == pytest.approx(rewards[k] + DISCOUNT ** durations[k] * after - values[k], rel=1e-4)
    assert explained(choices, advantages(choices, np.zeros(8, np.float32), 1.0)) == pytest.approx(1.0)


def test_a_better_place_becomes_likelier() -> None:
    torch.manual_seed(0)
    choices, network = random_choices(20_000), AdvantageNet()
    chosen = np.arange(20_000), choices.arrays["chosen"]
    seen = choices.arrays["places"][..., 0].astype(np.float32)
    noise = np.random.default_rng(0).normal(size=20_000)
    learn_choices(network, choices, (seen[chosen] + 0.5 * noise).astype(np.float32))
    learned = outputs(network, choices)[:, :3]
    assert np.corrcoef(learned.ravel(), seen[:, :3].ravel())[0, 1] > 0.7
    assert (learned.argmax(1) == seen[:, :3].argmax(1)).mean() > 0.6


def test_nothing_is_learned_from_rewards_common_to_all_places() -> None:
    torch.manual_seed(0)
    choices, network = random_choices(8192), AdvantageNet()
    before = outputs(network, choices)[:, :3]
    learn_choices(network, choices, (5.0 * choices.arrays["common"][:, 0]).astype(np.float32))
    after = outputs(network, choices)[:, :3]
    change = (after - before) - (after - before).mean(axis=1, keepdims=True)
    assert np.abs(change).mean() < 0.5


def test_values_are_judged_by_the_other_half(monkeypatch: pytest.MonkeyPatch) -> None:
    taught = []

    def noted(network: torch.nn.Module, some: np.ndarray, *_: object) -> float:
        taught.append(set((some // 4 % 2).tolist()))
        with torch.no_grad():
            for parameter in network.parameters():
                parameter.zero_()
            network.out.bias.fill_(float(len(taught)))  # type: ignore[union-attr, operator]
        return 0.0

    monkeypatch.setattr("indoor_explorers.learners.places.learning.minimise", noted)
    judged = learn_values(random_choices(16))
    assert taught == [{0}, {1}]
    assert judged.tolist() == ([20.0] * 4 + [10.0] * 4) * 2


def test_a_loss_is_minimised() -> None:
    torch.manual_seed(0)
    choices, network = random_choices(4096), AdvantageNet()

    def loss(some: np.ndarray) -> torch.Tensor:
        first: torch.Tensor = network(batch_of(choices, some))[:, 0]
        return (first - 1.0).square().mean()

    assert minimise(network, np.arange(4096), 10, 1e-2, loss) < 0.1


#: Of a flight of a single UAV.
SEED = 3


def flown(seed: int) -> TrainingFlight:
    torch.manual_seed(0)
    return fly(TrainingMaps(), seed, Loaded(weights_of(AdvantageNet()), 0.45, guess=True, others=True))


def test_flights_are_the_same_again_and_kept_in_files(tmp_path: Path) -> None:
    first = flown(SEED)
    (arrays,) = first.choices
    again = flown(SEED).choices[0]
    assert all(np.array_equal(arrays[name], again[name]) for name in arrays)
    count = len(arrays["chosen"])
    assert arrays["places"].shape == (count, MOST, PLACE)
    assert arrays["common"].shape == (count, COMMON)
    np.testing.assert_allclose(arrays["probabilities"].sum(axis=1), 1.0, rtol=1e-5)
    assert (arrays["probabilities"][~arrays["there"]] == 0.0).all()
    assert arrays["there"][np.arange(count), arrays["chosen"]].all()
    assert (arrays["durations"] > 0.0).all()
    np.testing.assert_array_less(-1.5 * arrays["durations"] - 1e-4, arrays["rewards"])
    both = choices_of([first, first])
    for name in ("a", "b"):
        write_choices(tmp_path / name, both)
    read = read_choices([tmp_path / "a", tmp_path / "b"])
    assert read.flight.tolist() == [0, 1, 2, 3]
    assert read.half.tolist() == [0] * count + [1] * count + [0] * count + [1] * count
    np.testing.assert_allclose(read.times, [first.times] * 4)


def test_flights_see_the_estimates_of_the_weights_that_are_named(tmp_path: Path) -> None:
    """With weights of zeros other estimates are seen, and the places of the first scene are the same."""
    for name in ("pockets.safetensors", "pockets.json"):
        (tmp_path / name).write_bytes((POCKETS.parent / name).read_bytes())
    files = TrainingConfig(pocket_weights=str(tmp_path)).estimate_files
    assert files == EstimateFiles(tmp_path / POCKETS.name)
    arrays, about = read_tensors(files.plain)
    write_tensors(files.plain, {name: np.zeros_like(array) for name, array in arrays.items()}, about)
    network = Loaded(weights_of(AdvantageNet()), 0.45, guess=True, others=True)
    both = (fly(TrainingMaps(), SEED, network, each) for each in (DEFAULT_FILES, files))
    shipped, zeros = (flight.choices[0]["places"][0] for flight in both)
    assert not np.array_equal(shipped, zeros)
    assert sorted(shipped[:, 0]) == sorted(zeros[:, 0])
    assert TrainingConfig().estimate_files == DEFAULT_FILES == EstimateFiles(POCKETS)
    with pytest.raises(ValueError, match="expected a safetensors file, found none"):
        TrainingConfig(pocket_weights=str(tmp_path / "none"))


def test_the_weights_of_the_later_rounds_are_averaged(tmp_path: Path) -> None:
    training = PlacesTraining(TrainingConfig(prior=0.5, others=False, lookouts=8), 1, tmp_path)
    training.networks = [weights_of(AdvantageNet()) for _ in range(4)]
    training.save(tmp_path)
    mean, rounds = load_weights(tmp_path / "places.safetensors"), training.networks
    assert (mean.prior, mean.guess, mean.others, mean.lookouts) == (0.5, True, False, 8)
    np.testing.assert_allclose(mean.weights.first, (rounds[2].first + rounds[3].first) / 2, rtol=1e-6)


@pytest.mark.slow
def test_an_interrupted_training_equals_a_whole_one_bit_for_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = TrainingConfig(flights=4, rounds=2, workers=1)
    train(config, None, tmp_path / "whole", seed=2)
    monkeypatch.setattr("indoor_explorers.learners.pockets.rounds.TOGETHER", 2)
    interrupted: list[int] = []

    def interrupt(progress: Progress) -> None:
        if progress.steps in (2, 6) and progress.steps not in interrupted:  # within the first round and the second
            interrupted.append(progress.steps)
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("indoor_explorers.learners.sessions.session.REPORT_EVERY", 0.0)
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            train(config, None, tmp_path / "cut", seed=2, resume=True, report=interrupt)
    weights = train(config, None, tmp_path / "cut", seed=2, resume=True, report=interrupt)
    for name in ("places.safetensors", "checkpoint.safetensors"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "cut" / name).read_bytes()
    whole, cut = (json.loads((tmp_path / folder / "training.json").read_text()) for folder in ("whole", "cut"))
    assert whole["evaluations"] == cut["evaluations"]
    assert [each["rounds"] for each in cut["evaluations"]] == [1, 2]
    assert cut["done"]
    assert not list((tmp_path / "cut").glob("flights/*"))
    assert DddqnPlaces(weights=str(weights.parent)).path == weights
