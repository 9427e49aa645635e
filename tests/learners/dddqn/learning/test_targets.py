"""Targets: terminal, truncated, n-step, and the value of what follows."""

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from indoor_explorers.learners.dddqn.learning.targets import look_forward, masked, q_target, shortfall


def looked_forward(
    rewards: list[float],
    *,
    terminal: list[int] | None = None,
    over: list[int] | None = None,
    explored: list[int] | None = None,
    start: int = 0,
    steps: int = 3,
    gamma: float = 0.5,
) -> tuple[float, float, int]:
    def flags(places: list[int] | None) -> NDArray[np.bool_]:
        return np.isin(np.arange(len(rewards)), places or [])[:, None]

    returns, discount, after = np.empty(1, np.float32), np.empty(1, np.float32), np.empty(1, np.int64)
    reward = np.array(rewards, np.float32)[:, None]
    where = np.array([start]), np.array([0])
    look_forward(reward, flags(terminal), flags(over), flags(explored), *where, steps, gamma, returns, discount, after)
    return float(returns[0]), float(discount[0]), int(after[0])


@pytest.mark.parametrize("bonus", [400.0, -400.0])
def test_the_target_of_a_terminal_step_is_its_reward_alone(bonus: float) -> None:
    returns, discount, _ = looked_forward([bonus, 7, 7, 7], terminal=[0])
    assert (returns, discount) == (bonus, 0.0)
    anything = torch.full((1, 4), 1e6)
    assert q_target(torch.tensor([returns]), torch.tensor([discount]), anything, anything).item() == bonus


def test_a_terminal_reward_within_reach_is_counted_and_nothing_after_it() -> None:
    assert looked_forward([1, 400, 9, 9], terminal=[1]) == (1 + 0.5 * 400, 0.0, 2)


def test_an_episode_cut_by_its_budget_bootstraps_from_its_final_state() -> None:
    assert looked_forward([1, 2, 0, 9, 9], over=[2]) == (1 + 0.5 * 2, 0.25, 2)


def test_returns_stop_before_an_exploratory_move_but_keep_the_first() -> None:
    assert looked_forward([1, 2, 4, 8], explored=[0, 2]) == (1 + 0.5 * 2, 0.25, 2)


def test_returns_equal_a_plain_loop_also_around_the_end_of_the_ring() -> None:
    rng = np.random.default_rng(1)
    rewards = rng.normal(size=9).astype(np.float32).tolist()
    for start in range(9):
        expected = sum(0.9**k * rewards[(start + k) % 9] for k in range(5))
        returns, discount, after = looked_forward(rewards, start=start, steps=5, gamma=0.9)
        assert returns == pytest.approx(expected, abs=1e-5)
        assert discount == pytest.approx(0.9**5)
        assert after == (start + 5) % 9


def test_the_move_that_ranks_highest_is_valued_by_the_target_network() -> None:
    rank_BA, target_BA = torch.tensor([[1.0, 5.0, 2.0, 4.0]]), torch.tensor([[10.0, 20.0, 30.0, 40.0]])
    assert q_target(torch.tensor([1.0]), torch.tensor([0.5]), rank_BA, target_BA).item() == 1.0 + 0.5 * 20.0


def test_blocked_moves_rank_below_all_others() -> None:
    q_BA, blocked_BA = torch.tensor([[-1e6, 5.0, 2.0, 9.0]]), torch.tensor([[False, True, True, True]])
    assert masked(q_BA, blocked_BA).argmax(dim=1).tolist() == [0]
    assert masked(q_BA, None) is q_BA


def test_the_shortfall_is_to_the_best_move() -> None:
    q_BA = torch.tensor([[1.0, 5.0, 2.0, 9.0]]).expand(3, 4)
    assert shortfall(q_BA, torch.tensor([1, 1, 1]), torch.tensor([2, 1, 3])).tolist() == [3.0, 0.0, -4.0]
