"""The policy: batched, deterministic, picklable, and with clear errors."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from safetensors.numpy import save_file

from indoor_explorers.env import PRESETS, InputError, World, check_policy
from indoor_explorers.learners.dddqn.policy import Dddqn
from indoor_explorers.learners.dddqn.weights import load_weights
from tests.learners.rooms import fly, small_room, write_network


def path_flown(policy: Dddqn, seeds: list[int], *, together: bool) -> NDArray[np.int64]:
    world = World(PRESETS["thesis-team-2"].for_evaluation().with_settings({"budget": 60}), len(seeds))
    world.reset(seeds)
    keys = [(b, n) for b in range(len(seeds)) for n in range(2)]
    pilots = [policy.pilot(world.briefing(*key)) for key in keys]
    cells = []
    for _ in range(60):
        views = [world.view(*key) for key in keys]
        if together:
            actions = policy.act(pilots, views)
        else:
            actions = [pilot.act(view) for pilot, view in zip(pilots, views, strict=True)]
        world.step(np.array(actions).reshape(len(seeds), 2))
        cells.append(world.state.cell.copy())
    return np.array(cells)


@pytest.mark.parametrize("guard", [True, False])
def test_acting_together_equals_acting_alone(untrained: str, guard: bool) -> None:
    policy = Dddqn(weights=untrained, guard=guard)
    together = path_flown(policy, [1, 2, 3, 4], together=True)
    assert np.array_equal(together, path_flown(policy, [1, 2, 3, 4], together=False))
    assert np.array_equal(together[:, 1:2], path_flown(policy, [2], together=True))


def test_a_copy_from_another_process_acts_the_same(untrained: str) -> None:
    policy = Dddqn(weights=untrained)
    copy = pickle.loads(pickle.dumps(policy))
    assert copy == policy
    assert len(pickle.dumps(policy)) < 1000
    assert np.array_equal(path_flown(policy, [5], together=True), path_flown(copy, [5], together=True))


def test_the_policy_passes_the_conformance_suite(untrained: str) -> None:
    check_policy(Dddqn(weights=untrained))


def test_the_guarded_share_is_tallied(untrained: str) -> None:
    world = World(small_room())
    world.reset([1])
    for guard in (True, False):
        pilot = Dddqn(weights=untrained, guard=guard).pilot(world.briefing(0, 0))
        pilot.act(world.view(0, 0))
        assert pilot.tally() == ({"guarded_share": 0.0} if guard else {})


def test_it_never_flies_into_a_wall(untrained: str) -> None:
    scenario = PRESETS["thesis-obstacles"].for_evaluation().with_settings({"budget": 20_000})
    world = fly(Dddqn(weights=untrained), scenario, 3)
    assert world.state.collisions.sum() == 0
    assert world.team_coverage[0] == 1.0


def test_missing_weights_are_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.safetensors: expected a safetensors file, found none") as error:
        Dddqn(weights=str(tmp_path / "none.safetensors"))
    assert "\n" not in str(error.value)


def test_weights_written_anew_are_read_anew(tmp_path: Path) -> None:
    path = tmp_path / "weights.safetensors"
    policy = Dddqn(weights=write_network(path, 1))
    first = path_flown(policy, [1], together=True)
    write_network(path, 2)
    assert not np.array_equal(first, path_flown(policy, [1], together=True))


def test_other_files_are_refused_in_one_line(tmp_path: Path) -> None:
    bad = tmp_path / "bad.safetensors"
    bad.write_bytes(b"\x80\x04pickled")
    with pytest.raises(InputError, match="expected a safetensors file, got something else") as error:
        Dddqn(weights=str(bad))
    assert "\n" not in str(error.value)


def test_weights_of_another_shape_are_refused_in_one_line(tmp_path: Path) -> None:
    arrays = load_weights(Path(write_network(tmp_path / "good.safetensors", 1)))
    wrong = arrays | {"value.bias": np.zeros(2, np.float32)}
    save_file(wrong, tmp_path / "wrong.safetensors")
    with pytest.raises(InputError, match=r"'value.bias' to be numbers of shape \(1,\), got float32 of shape \(2,\)"):
        Dddqn(weights=str(tmp_path / "wrong.safetensors"))
    save_file({name: arrays[name] for name in arrays if name != "look.bias"}, tmp_path / "less.safetensors")
    with pytest.raises(InputError, match=r"'look\.bias' is missing"):
        Dddqn(weights=str(tmp_path / "less.safetensors"))


def test_the_shipped_weights_explore_unseen_rooms_well() -> None:
    scenario = PRESETS["thesis-obstacles"].for_evaluation().with_settings({"goal": 0.99})
    worlds = [fly(Dddqn(), scenario, seed) for seed in range(12)]
    assert all(world.team_coverage[0] >= 0.99 for world in worlds)
    assert np.mean([world.state.step[0] for world in worlds]) < 85


def test_results_can_tell_which_weights_were_flown(untrained: str) -> None:
    own, shipped = Dddqn(weights=untrained).provenance(), Dddqn().provenance()
    assert len(own["weights_sha256"]) == 64
    assert own != shipped


def test_weights_of_any_size_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.safetensors"
    with path.open("wb") as file:
        file.truncate(40_000_000)
    with pytest.raises(InputError, match="expected weights of at most 32 MB, got 40 MB"):
        Dddqn(weights=str(path))
