"""The replay ring."""

from __future__ import annotations

from typing import Any

import numpy as np

from indoor_explorers.learners.dddqn.observation import MOVE_FEATURES, SCENE
from indoor_explorers.learners.dddqn.replay import Replay
from indoor_explorers.learners.dddqn.symmetry import symmetries


def add(replay: Replay, tick: int, **flags: Any) -> None:
    """Add a tick whose states carry its number and whose rewards are it."""
    columns = replay.data.action.shape[1]
    scene = np.full((columns, SCENE), tick, np.uint8)
    moves = np.full((columns, 4, len(MOVE_FEATURES)), tick, np.float32)
    no = np.zeros(columns, np.bool_)
    slot: dict[str, Any] = {"terminal": no, "explored": no, "over": no} | flags
    replay.add(scene, moves, np.full(columns, tick % 4), np.full(columns, float(tick)), **slot)


def test_the_ring_keeps_the_latest_ticks_only() -> None:
    replay = Replay(10, 2)
    for tick in range(27):
        add(replay, tick)
    batch = replay.sample(500, 1, 1.0, np.random.default_rng(0))
    assert replay.filled == 10
    # The oldest tick kept is 17; 26 is the newest and has no state after it yet.
    assert sorted({round(tick) for tick in batch.return_B.tolist()}) == list(range(17, 26))
    assert np.allclose(batch.scene_BS[:, 0].numpy() * 255, batch.return_B.numpy(), atol=1e-3)
    assert np.allclose(batch.next_moves_BAF[:, 0, 0].numpy(), batch.return_B.numpy() + 1)


def test_n_step_returns_never_run_over_the_writing_place() -> None:
    replay = Replay(12, 3)
    for tick in range(40):
        add(replay, tick)
        if replay.filled > 5:
            batch = replay.sample(64, 5, 1.0, np.random.default_rng(tick))
            first = np.rint(batch.scene_BS[:, 0].numpy() * 255)
            assert np.allclose(batch.return_B.numpy(), 5 * first + 10)
            assert np.allclose(batch.next_scene_BS[:, 0].numpy() * 255, first + 5, atol=1e-3)


def test_final_states_are_never_sampled_as_starts() -> None:
    replay = Replay(20, 1)
    for tick in range(20):
        add(replay, tick, over=np.array([tick % 3 == 0]))
    batch = replay.sample(300, 2, 1.0, np.random.default_rng(0))
    assert not {0, 3, 6, 9, 12, 15} & set(np.rint(batch.scene_BS[:, 0].numpy() * 255).tolist())


def test_samples_are_turned_as_one() -> None:
    rng = np.random.default_rng(2)
    replay = Replay(10, 1)
    scenes = rng.integers(0, 256, (10, 1, SCENE), dtype=np.uint8)
    moves = rng.random((10, 1, 4, len(MOVE_FEATURES))).astype(np.float16)
    no = np.zeros(1, np.bool_)
    for tick in range(10):
        replay.add(scenes[tick], moves[tick].astype(np.float32), np.array([tick % 4]), np.array([tick]), no, no, no)
    batch = replay.sample(200, 1, 1.0, rng)
    tables, seen = symmetries(), set()
    for i in range(200):
        tick = int(batch.return_B[i])
        scene = np.rint(batch.scene_BS[i].numpy() * 255)
        fits = [g for g in range(8) if np.array_equal(scene, scenes[tick, 0][tables.scene[g]])]
        assert len(fits) == 1
        turn = fits[0]
        seen.add(turn)
        assert batch.action_B[i] == tables.action[turn, tick % 4]
        assert np.array_equal(batch.moves_BAF[i].numpy(), moves[tick, 0][tables.moves[turn]].astype(np.float32))
        following = np.rint(batch.next_scene_BS[i].numpy() * 255)
        assert np.array_equal(following, scenes[tick + 1, 0][tables.scene[turn]])
    assert seen == set(range(8))
