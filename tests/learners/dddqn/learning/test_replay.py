"""The replay ring, its sum tree and the stack of frames."""

from typing import Any

import numpy as np
import pytest
import torch

from indoor_explorers.learners.dddqn.learning.replay import Batch, Replay, Tick
from indoor_explorers.learners.dddqn.learning.sum_tree import SumTree
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import observation_layout, symmetries

SMALL = ObservationConfig(crop=5, coarse=3, layers=("unknown",), tours=False)
PLAN = observation_layout(SMALL)


def ring(slots: int, columns: int, *, prioritised: float = 0.0, symmetries: bool = True, frames: int = 1) -> Replay:
    observation = SMALL.model_copy(update={"frames": frames})
    return Replay(slots, columns, observation, prioritised=prioritised, symmetries=symmetries)


def add(replay: Replay, tick: int, **flags: Any) -> None:
    """Add a tick whose states carry its number and whose rewards are it."""
    columns = replay.data.action.shape[1]
    scene = np.full((columns, PLAN.scene), tick, np.uint8)
    moves = np.full((columns, 4, PLAN.features), tick, np.float32)
    no = np.zeros(columns, np.bool_)
    slot: dict[str, Any] = {"terminal": no, "explored": no, "over": no, "age": np.full(columns, tick)} | flags
    replay.add(Tick(scene, moves, np.full(columns, tick % 4), np.full(columns, float(tick)), **slot))


def ticks(batch: Batch) -> np.ndarray:
    """Return the ticks (B,) of the states of a batch."""
    return np.asarray(np.rint(batch.scenes_BI[:, 0].numpy() * 255), np.int64)


@pytest.mark.parametrize("prioritised", [0.0, 0.6])
def test_the_ring_keeps_the_latest_ticks_only(prioritised: float) -> None:
    replay = ring(10, 2, prioritised=prioritised)
    for tick in range(27):
        add(replay, tick)
    batch = replay.sample(500, 1, 1.0, np.random.default_rng(0))
    assert (replay.filled, replay.ready(1)) == (10, 9)
    # The oldest tick kept is 17; 26 is the newest and has no state after it yet.
    assert sorted({round(tick) for tick in batch.return_B.tolist()}) == list(range(17, 26))
    assert np.array_equal(ticks(batch), batch.return_B.numpy())
    assert np.allclose(batch.next_moves_BAF[:, 0, 0].numpy(), batch.return_B.numpy() + 1)


@pytest.mark.parametrize("prioritised", [0.0, 0.6])
def test_n_step_returns_never_run_over_the_writing_place(prioritised: float) -> None:
    replay = ring(12, 3, prioritised=prioritised)
    for tick in range(40):
        add(replay, tick)
        if replay.ready(5):
            batch = replay.sample(64, 5, 1.0, np.random.default_rng(tick))
            assert np.allclose(batch.return_B.numpy(), 5 * ticks(batch) + 10)
            assert np.allclose(batch.next_scenes_BI[:, 0].numpy() * 255, ticks(batch) + 5, atol=1e-3)


@pytest.mark.parametrize("prioritised", [0.0, 0.6])
def test_final_states_are_never_sampled_as_starts(prioritised: float) -> None:
    replay = ring(20, 1, prioritised=prioritised)
    for tick in range(20):
        add(replay, tick, over=np.array([tick % 3 == 0]))
    batch = replay.sample(300, 2, 1.0, np.random.default_rng(0))
    assert not {0, 3, 6, 9, 12, 15} & set(ticks(batch).tolist())


@pytest.mark.parametrize("on", [True, False])
@pytest.mark.parametrize("frames", [1, 2])
def test_samples_are_turned_as_one_or_not_at_all(on: bool, frames: int) -> None:
    rng = np.random.default_rng(2)
    replay = ring(10, 1, symmetries=on, frames=frames)
    scenes = rng.integers(0, 256, (10, 1, PLAN.scene), dtype=np.uint8)
    moves = rng.random((10, 1, 4, PLAN.features)).astype(np.float16)
    no = np.zeros(1, np.bool_)
    for tick in range(10):
        slot = scenes[tick], moves[tick].astype(np.float32), np.array([tick % 4]), np.array([float(tick)])
        replay.add(Tick(*slot, no, no, no, np.array([tick])))
    batch = replay.sample(200, 1, 1.0, rng)
    tables, seen = symmetries(SMALL), set()
    for i in range(200):
        tick = int(batch.return_B[i])
        shown = np.rint(batch.scenes_BI[i].numpy() * 255).reshape(frames, -1)
        fits = [g for g in range(8) if np.array_equal(shown[0], scenes[tick, 0][tables.scene[g]])]
        assert len(fits) == 1
        turn = fits[0]
        seen.add(turn)
        assert np.array_equal(shown[-1], scenes[max(tick - frames + 1, 0), 0][tables.scene[turn]])
        assert batch.action_B[i] == tables.action[turn, tick % 4]
        assert np.array_equal(batch.moves_BAF[i].numpy(), moves[tick, 0][tables.moves[turn]].astype(np.float32))
        following = np.rint(batch.next_scenes_BI[i].numpy() * 255).reshape(frames, -1)
        assert np.array_equal(following[0], scenes[tick + 1, 0][tables.scene[turn]])
    assert seen == (set(range(8)) if on else {0})


@pytest.mark.parametrize("prioritised", [0.0, 0.6])
def test_frames_are_stacked_latest_first_and_never_across_the_beginning_of_an_episode(prioritised: float) -> None:
    replay, checked = ring(9, 2, frames=3, prioritised=prioritised), set()
    begun = np.array([0, 0])
    for tick in range(60):
        begun = np.where([tick % 7 == 0, tick % 11 == 0], tick, begun)
        add(replay, tick, age=tick - begun)
        if not replay.ready(2):
            continue
        batch = replay.sample(50, 2, 1.0, np.random.default_rng(tick))
        for place, scenes, following in zip(batch.place, batch.scenes_BI, batch.next_scenes_BI, strict=True):
            slot, column = divmod(int(place), 2)
            first = slot - slot % (7, 11)[column]
            expected = [max(slot - frame, first) for frame in range(3)]
            assert np.rint(scenes.numpy().reshape(3, -1)[:, 0] * 255).tolist() == expected
            checked.add(slot - first)
            if slot - first <= 4:
                expected = [max(slot + 2 - frame, first) for frame in range(3)]
                assert np.rint(following.numpy().reshape(3, -1)[:, 0] * 255).tolist() == expected
    assert checked == set(range(11))


def test_a_very_long_episode_never_looks_young() -> None:
    replay = ring(9, 2, frames=2)
    for tick in range(9):
        add(replay, tick, age=np.array([2**16 - 4, 0]) + tick)
    batch = replay.sample(100, 1, 1.0, np.random.default_rng(0))
    shown = np.rint(batch.scenes_BI.numpy().reshape(100, 2, -1)[:, :, 0] * 255).astype(np.int64)
    assert ((shown[:, 0] - shown[:, 1] == 1) == (shown[:, 0] > 0)).all()


@pytest.mark.parametrize("size", [1, 5, 64, 300])
def test_the_sum_tree_finds_what_cumulative_sums_find(size: int) -> None:
    rng, tree, values = np.random.default_rng(size), SumTree(size), np.zeros(size)
    for _ in range(20):
        places = rng.integers(size, size=7)
        new = rng.random(7) * (rng.random(7) < 0.7)
        tree.write(places, new)
        for place, value in zip(places, new, strict=True):
            values[place] = value
    values[0] += 1.0
    tree.write(np.array([0]), values[:1])
    assert np.array_equal(tree.values, values)
    assert tree.total == pytest.approx(values.sum())
    lots = (np.arange(500) + np.random.default_rng(9).random(500)) * (values.sum() / 500)
    expected = np.searchsorted(np.cumsum(values), lots, side="right")
    assert (tree.draw(500, np.random.default_rng(9)) == expected).mean() > 0.99  # rounding at the edges
    assert values[tree.draw(500, rng)].min() > 0.0


def test_transitions_are_drawn_in_proportion_to_their_errors() -> None:
    replay = ring(12, 2, prioritised=0.5)
    for tick in range(12):
        add(replay, tick)
    rng = np.random.default_rng(3)
    first = replay.sample(22, 1, 1.0, rng)
    assert sorted(first.place.tolist()) == list(range(22)), "all are new: each once in as many equal parts"
    replay.reprioritise(np.arange(22), np.arange(1, 23) ** 2 - 1e-3)
    drawn = np.bincount(replay.sample(20_000, 1, 1.0, rng).place, minlength=22)
    expected = np.arange(1, 23) * 20_000 / np.arange(1, 23).sum()
    assert np.abs(drawn - expected).max() <= 2


def test_new_transitions_get_the_highest_priority_so_far() -> None:
    replay = ring(50, 1, prioritised=1.0)
    for tick in range(11):
        add(replay, tick)
    rng = np.random.default_rng(3)
    replay.sample(4, 1, 1.0, rng)
    replay.reprioritise(np.arange(10), np.full(10, -7.0))
    replay.reprioritise(np.arange(10), np.full(10, 1.0))
    add(replay, 11)
    counts = np.bincount(replay.sample(17_000, 1, 1.0, rng).place, minlength=11)
    assert counts[10] == pytest.approx(7000, abs=10)


def test_importance_weights_undo_the_priorities_and_are_at_most_one() -> None:
    replay = ring(12, 2, prioritised=1.0)
    for tick in range(12):
        add(replay, tick)
    rng = np.random.default_rng(3)
    replay.sample(4, 1, 1.0, rng)
    errors = np.arange(1, 23) - 1e-3
    replay.reprioritise(np.arange(22), errors)
    batch = replay.sample(5000, 1, 1.0, rng, importance=1.0)
    assert batch.weight_B.max() == 1.0
    totals = np.bincount(batch.place, weights=batch.weight_B.numpy())
    assert np.allclose(totals, totals.mean(), rtol=0.05)
    half = replay.sample(5000, 1, 1.0, rng, importance=0.5)
    assert np.allclose(half.weight_B.numpy(), (half.place + 1.0) ** -0.5, rtol=1e-5)
    assert torch.equal(replay.sample(50, 1, 1.0, rng).weight_B, torch.ones(50))


def test_errors_of_overwritten_transitions_change_nothing() -> None:
    replay = ring(6, 1, prioritised=1.0)
    for tick in range(8):
        add(replay, tick)
    batch = replay.sample(50, 1, 1.0, np.random.default_rng(0))
    for tick in range(8, 11):
        add(replay, tick)
    replay.sample(1, 1, 1.0, np.random.default_rng(0))
    before = replay.tensors()["replay/priority"].copy()
    replay.reprioritise(batch.place[batch.place < 5], np.zeros((batch.place < 5).sum()))
    assert np.array_equal(replay.tensors()["replay/priority"], before)


def test_a_longer_return_takes_transitions_back_that_are_no_longer_whole() -> None:
    replay = ring(20, 1, prioritised=0.6)
    for tick in range(20):
        add(replay, tick)
    rng = np.random.default_rng(0)
    assert ticks(replay.sample(400, 1, 1.0, rng)).max() == 18
    assert ticks(replay.sample(400, 8, 1.0, rng)).max() == 11


@pytest.mark.parametrize("prioritised", [0.0, 0.6])
@pytest.mark.parametrize("written", [7, 31])
def test_a_restored_ring_goes_on_bit_for_bit(prioritised: float, written: int) -> None:
    def go_on(replay: Replay) -> list[np.ndarray]:
        rng, found = np.random.default_rng(8), []
        for tick in range(written, written + 30):
            add(replay, tick, over=np.array([False, tick % 5 == 0]))
            batch = replay.sample(16, 2, 0.9, rng, importance=0.5)
            replay.reprioritise(batch.place, rng.normal(size=16))
            found += [array if isinstance(array, np.ndarray) else array.numpy() for array in batch]
        return found

    first = ring(16, 2, prioritised=prioritised, frames=2)
    rng = np.random.default_rng(1)
    for tick in range(written):
        add(first, tick)
        if first.ready(2):
            batch = first.sample(8, 2, 0.9, rng)
            first.reprioritise(batch.place, rng.normal(size=8))
    second = ring(16, 2, prioritised=prioritised, frames=2)
    second.restore({name: array.copy() for name, array in first.tensors().items()})
    for one, other in zip(go_on(first), go_on(second), strict=True):
        assert np.array_equal(one, other)
