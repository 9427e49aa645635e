import json
import os
import signal
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.generators.halls import HallsMaps
from indoor_explorers.env.maps.generators.homes import HomesMaps
from indoor_explorers.env.maps.sources import FileMaps, OfficesMaps
from indoor_explorers.env.scenarios.suites.suite import Part
from indoor_explorers.env.search.connected_parts import largest_part
from indoor_explorers.learners.pockets.examples import chosen_examples, examples_of, read_examples
from indoor_explorers.learners.pockets.learning import PocketLearner, loss
from indoor_explorers.learners.pockets.maps import GENERATED, TrainingMaps, cut, map_files, map_record, ragged, turned
from indoor_explorers.learners.pockets.train import TrainingConfig, train
from indoor_explorers.learners.pockets.validation import auc, judged
from indoor_explorers.learners.sessions.session import Progress
from indoor_explorers.planners.toolbox.pockets.estimates import estimates_from, load_weights
from indoor_explorers.planners.toolbox.pockets.features import LEVELS
from indoor_explorers.planners.toolbox.pockets.network import OUTPUTS, THRESHOLDS
from tests.planners.flights import rooms
from tests.suites import tiny, tiny_clones

__all__ = ["tiny", "tiny_clones"]


def random_examples(count: int) -> dict[str, np.ndarray]:
    """Examples whose size can be read off the coarse picture."""
    rng = np.random.default_rng(0)
    large = rng.random(count) < 0.5
    coarse = np.zeros((count, 2, 25, 25), np.uint8)
    coarse[large] = 9
    return {
        "fine": rng.integers(0, 2, (count, 5, 25, 25)).astype(np.uint8),
        "coarse": coarse,
        "numbers": np.ones((count, 2), np.float32),
        "sizes": np.where(large, 100.0, 0.0).astype(np.float32),
        "depths": np.where(large, 20.0, 0.0).astype(np.float32),
    }


def test_the_loss_falls_on_learnable_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("indoor_explorers.learners.pockets.learning.BATCH", 32)
    learner = PocketLearner(random_examples(320), epochs=4, seed=0)
    losses: list[float] = []
    for _ in range(4):
        while learner.epochs == len(losses):
            learner.update()
        losses.append(learner.mean_loss)
    assert losses[-1] < 0.5 * losses[0]


def test_the_loss_is_least_at_the_truth() -> None:
    sizes, depths = torch.tensor([5.0, 0.0]), torch.tensor([3.0, 0.0])
    truth = torch.where(sizes[:, None] > torch.tensor(THRESHOLDS), 20.0, -20.0)
    right = torch.cat([truth, torch.log1p(depths)[:, None]], dim=1)
    assert float(loss(right, sizes, depths)) < 1e-6
    assert float(loss(-right, sizes, depths)) > 10.0


def test_training_maps_are_connected_and_repeat_with_the_seed() -> None:
    maps = TrainingMaps()
    for seed in range(4):
        first, second = (maps.draw(np.random.default_rng(seed)) for _ in range(2))
        assert (first.truth == second.truth).all()
        free = first.truth == 1
        assert (largest_part(free) == free).all()


def test_a_share_of_the_training_maps_has_levels() -> None:
    drawn = [TrainingMaps(levels=0.5).draw(np.random.default_rng(seed)) for seed in range(40)]
    tall = [plan for plan in drawn if plan.level_count > 1]
    assert 10 <= len(tall) <= 30
    assert len({plan.level_count for plan in tall}) > 4
    for plan in tall:
        assert (plan.main_part == (plan.truth == 1)).all()


def test_a_share_of_the_training_maps_are_halls_or_homes(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: Counter[type[GeneratedMaps]] = Counter()

    def counted(kind: type[GeneratedMaps]) -> Callable[[GeneratedMaps, np.random.Generator], Mask]:
        draw = kind.draw

        def drawing(maps: GeneratedMaps, rng: np.random.Generator) -> Mask:
            drawn[kind] += 1
            return draw(maps, rng)

        return drawing

    for kind in (HallsMaps, HomesMaps):
        monkeypatch.setattr(kind, "draw", counted(kind))
    for seed in range(40):
        TrainingMaps(halls=0.5).draw(np.random.default_rng(seed))
        TrainingMaps(halls=0.0).draw(np.random.default_rng(seed))
    assert 10 <= drawn.total() <= 30
    assert min(drawn[HallsMaps], drawn[HomesMaps]) >= 4


def test_a_training_of_some_maps_draws_no_others() -> None:
    drawn = [TrainingMaps(number=2).draw(np.random.default_rng(seed)).truth.tobytes() for seed in range(12)]
    assert len(set(drawn)) == 2


def test_maps_are_turned_cut_and_roughened() -> None:
    rng = np.random.default_rng(1)
    free = np.ones((20, 30), np.bool_)
    area = free.sum()
    for _ in range(8):
        part = turned(free, rng)
        assert 0.85 * area <= part.sum() <= 1.05 * area
        assert not part[0].any()
        assert 0 < cut(free, rng).sum() <= area
    free = np.pad(rooms(3, 9, 0), 1)
    rough = ragged(free, 0.15, rng)
    assert 0 < (rough != free).sum() < 0.5 * free.size


def test_examples_of_a_flight_are_complete() -> None:
    plan = Floorplan.from_free(np.pad(rooms(3, 9, 0), 1), GENERATED)
    found = examples_of(plan, 3, 4.0)
    count = len(found["sizes"])
    assert count > 30
    assert all(len(each) == count for each in found.values())
    assert found["sizes"].max() > 20
    assert ((found["depths"] > 0) == (found["sizes"] > 0)).all()
    assert not found["real"].any()


def test_estimates_are_judged_against_the_true_pockets() -> None:
    sizes = np.array([0.0, 0.0, 50.0, 50.0], np.float32)
    sure = np.where(sizes[:, None] > np.array(THRESHOLDS), 9.0, -9.0)
    outputs = np.concatenate([sure, np.zeros((4, OUTPUTS - len(THRESHOLDS)))], axis=1).astype(np.float32)
    row = judged("a", {"sizes": sizes}, estimates_from(outputs))
    assert row.aucs == (1.0, 1.0, 1.0)
    assert row.observed == (0.5, 0.5, 0.5)
    assert row.predicted == pytest.approx((0.5, 0.5, 0.5), abs=1e-3)
    assert row.entropy < 1e-3
    assert auc(np.array([True, False, True, False]), np.array([1.0, 1.0, 1.0, 1.0])) == 0.5
    assert np.isnan(auc(np.ones(3, np.bool_), np.arange(3.0)))


def test_the_examples_of_one_kind_of_map_are_chosen() -> None:
    examples = {"sizes": np.arange(4), "real": np.array([True, False, True, False])}
    assert chosen_examples(examples, "both") is examples
    assert chosen_examples(examples, "real")["sizes"].tolist() == [0, 2]
    assert chosen_examples(examples, "generated")["sizes"].tolist() == [1, 3]


@pytest.fixture
def small_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Train on small offices."""
    offices = OfficesMaps(height=32, width=40)
    monkeypatch.setattr("indoor_explorers.learners.pockets.maps.random_generator", lambda rng: offices)


@pytest.mark.usefixtures("small_maps")
def test_an_interrupted_training_equals_a_whole_one_bit_for_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("indoor_explorers.learners.pockets.learning.BATCH", 32)
    monkeypatch.setattr("indoor_explorers.learners.sessions.session.REPORT_EVERY", 0.0)
    config = TrainingConfig(flights=2, epochs=2)
    load_weights(train(config, None, tmp_path / "whole", seed=3))
    for due in (1, 3, 5):  # within the flights, the first epoch and the second

        def interrupt(progress: Progress, due: int = due) -> None:
            if progress.steps == due:
                os.kill(os.getpid(), signal.SIGINT)

        with pytest.raises(KeyboardInterrupt):
            train(config, None, tmp_path / "cut", seed=3, resume=True, report=interrupt)
    (tmp_path / "cut" / "flights" / "1.npz").unlink()  # is flown again
    train(config, None, tmp_path / "cut", seed=3, resume=True)
    for name in ("pockets.safetensors", "checkpoint.safetensors"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "cut" / name).read_bytes()
    whole, cut = (json.loads((tmp_path / folder / "training.json").read_text()) for folder in ("whole", "cut"))
    assert whole["evaluations"] == cut["evaluations"]
    assert [each["epochs"] for each in cut["evaluations"]] == [1, 2]
    assert (cut["done"], cut["seen_maps"], cut["files"], cut["examples"] > 64) == (True, {}, 0, True)
    with pytest.raises(InputError, match="with seed 3, expected 4"):
        train(config, None, tmp_path / "cut", seed=4, resume=True)


def test_a_training_over_levels_makes_estimates_for_levels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It flies in buildings of several levels alone, and is judged in those of the suite."""
    monkeypatch.setattr("indoor_explorers.learners.pockets.learning.BATCH", 32)
    monkeypatch.setattr("indoor_explorers.env.scenarios.suites.suite.Suite.seeds", lambda *_: range(5, 6))
    train(TrainingConfig(flights=1, epochs=1, levels=True), None, tmp_path, seed=3)
    assert load_weights(tmp_path / "pockets.safetensors", LEVELS).fine1.weight.shape == (5, 5, 25, 16)
    examples = read_examples([tmp_path / "flights" / "0.npz"])
    assert examples["fine"].shape[1:] == (25, 25, 25)
    assert len(examples["sizes"]) > 32
    judged = (tmp_path / "validation.md").read_text().splitlines()[2:]
    names = [f"levels-{name}-1" for name in ("one-storey", "tall-halls", "racks", "stair-wells")]
    assert [row.split(" | ")[0] for row in judged] == [f"| {name}" for name in (*names, "all")]
    with pytest.raises(ValueError, match="expected no suites, no halls and no real maps with levels=true"):
        TrainingConfig(levels=True, halls=0.2)


def test_map_files_are_learned_from_and_recorded(tiny: Path, tmp_path: Path) -> None:
    config = TrainingConfig.model_validate({"suites": "tiny", "data": str(tiny)})
    assert len(config.maps().paths) == 1
    record = map_record("pockets", config, None, 1)
    assert record.seen_maps == {"training": ("tiny/train",)}
    assert "data" not in record.config
    with pytest.raises(InputError, match="draws its own maps and tasks, got scenario 'thesis-open'"):
        map_record("pockets", config, PRESETS["thesis-open"], 1)


def test_maps_of_a_repository_are_left_out_and_other_maps_stay(tiny: Path) -> None:
    chosen = {"suites": "tiny", "data": str(tiny)}
    config = TrainingConfig.model_validate(chosen | {"left_out": "plans"})
    assert config.maps().left_out == frozenset(config.maps().paths)
    assert map_record("pockets", config, None, 1).seen_maps == {}
    with pytest.raises(
        InputError, match="expected repositories of tiny to leave out, got 'plan'; did you mean 'plans'"
    ):
        TrainingConfig.model_validate(chosen | {"left_out": "plan"}).maps()
    with pytest.raises(
        InputError, match="expected repositories of tiny to leave out, got 'floors'"
    ):  # none is trained on
        TrainingConfig.model_validate(chosen | {"left_out": "floors"}).maps()


def test_generated_maps_take_the_place_of_files_that_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("indoor_explorers.learners.pockets.maps.CUT", 0.0)  # every map is large enough at once
    paths = []
    for name in ("a", "b"):
        np.save(tmp_path / f"{name}.npy", np.kron(~np.pad(rooms(4, 9, ord(name)), 1), np.ones((4, 4))).astype(np.int8))
        paths.append(str(tmp_path / f"{name}.npy"))
    every = [TrainingMaps(tuple(paths)).draw(np.random.default_rng(seed)) for seed in range(24)]
    some = [
        TrainingMaps(tuple(paths), left_out=frozenset(paths[:1])).draw(np.random.default_rng(seed))
        for seed in range(24)
    ]
    assert {plan.name for plan in every} == {"a", "b", GENERATED}
    assert {plan.name for plan in some} == {"b", GENERATED}
    assert all(one.digest == other.digest for one, other in zip(every, some, strict=True) if one.name != "a")


def test_missing_clones_are_told_before_a_folder_is_made(tmp_path: Path) -> None:
    config = TrainingConfig(suites=("floors",), data=(str(tmp_path),))
    with pytest.raises(InputError, match="git clone"):
        train(config, None, tmp_path / "out", seed=1)
    assert not (tmp_path / "out").exists()
    for name in ("rooms", "levels"):
        with pytest.raises(InputError, match=f"expected suites of map files, got '{name}'"):
            map_files(name, Part.TRAIN, [])


@pytest.mark.usefixtures("small_maps")
def test_a_training_with_floors_tells_how_good_it_is_on_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.save(tmp_path / "floor.npy", (~np.pad(rooms(3, 9, 0), 1)).astype(np.int8))
    floors = FileMaps(paths=(str(tmp_path / "floor.npy"),), resolution=1.0)
    for module in ("maps", "train"):
        monkeypatch.setattr(f"indoor_explorers.learners.pockets.{module}.map_files", lambda *_: floors)
    train(TrainingConfig(suites=("floors",), flights=1, epochs=1), None, tmp_path / "out", seed=1)
    table = (tmp_path / "out" / "validation.md").read_text().splitlines()
    groups = ["floor", f"source {tmp_path.name}", "kind rooms and corridors", "all"]
    assert [row.split(" | ")[0] for row in table[2:]] == [f"| {each}" for each in groups]
    assert len({row.split(" | ", 1)[1] for row in table[2:]}) == 1
