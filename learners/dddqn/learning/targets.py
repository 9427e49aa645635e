"""The targets of Q-learning: n-step returns and the value of the state that follows."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from indoor_explorers.env.grid.compiled import kernel


@kernel()
def look_forward(
    reward: np.ndarray,
    terminal: np.ndarray,
    over: np.ndarray,
    explored: np.ndarray,
    start: np.ndarray,
    column: np.ndarray,
    steps: int,
    gamma: float,
    returns: np.ndarray,
    discount: np.ndarray,
    after: np.ndarray,
) -> None:
    """Sum discounted rewards over up to ``steps`` steps from each of B places of a ring buffer (T, C).

    The sum ends before an exploratory action, whose outcome says nothing about the greedy policy (Watkins
    1989). Fills ``returns`` (B,), ``discount`` (B,): the factor of the value that follows, 0 after a
    terminal reward; and ``after`` (B,): the slot of the state that follows. An episode truncated by its
    budget is not terminal: the slot after its last step holds its final state, is marked ``over``, and its
    value counts.
    """
    slots = reward.shape[0]
    for i in range(start.shape[0]):
        c, at, factor, total = column[i], start[i], 1.0, 0.0
        for k in range(steps):
            if k > 0 and (over[at, c] or explored[at, c]):
                break
            total += factor * reward[at, c]
            factor = 0.0 if terminal[at, c] else factor * gamma
            at = (at + 1) % slots
            if factor == 0.0:
                break
        returns[i], discount[i], after[i] = total, factor, at


def masked(q_BA: Tensor, blocked_BA: Tensor | None) -> Tensor:
    """Return q_BA (B, 4) with blocked moves set to the dtype's minimum; unchanged if ``blocked_BA`` is None."""
    return q_BA if blocked_BA is None else q_BA.masked_fill(blocked_BA, torch.finfo(q_BA.dtype).min)


def q_target(return_B: Tensor, discount_B: Tensor, rank_BA: Tensor, target_BA: Tensor) -> Tensor:
    """Return target_B (B,) = R + discount * Q_target(s', a'), where a' is the move of highest ``rank_BA`` in s'.

    The ranks are the values of the online network (double Q-learning: van Hasselt, Guez and Silver 2016, eq. 4) or of
    the target network (Mnih et al. 2015). ``discount_B`` is 0 after a terminal reward; the target then is R.
    """
    best_B1 = rank_BA.argmax(dim=1, keepdim=True)
    return return_B + discount_B * target_BA.gather(1, best_B1).squeeze(1)


def shortfall(q_BA: Tensor, best_B: Tensor, action_B: Tensor) -> Tensor:
    """Return the differences (B,) between the values of the best moves and of the moves made.

    Subtracting a share of it from the target widens the action gap without changing which move is best (advantage
    learning: Bellemare et al. 2016, arXiv:1512.04860, eq. 7).
    """
    best_B, own_B = (q_BA.gather(1, move_B[:, None]).squeeze(1) for move_B in (best_B, action_B))
    return best_B - own_B
