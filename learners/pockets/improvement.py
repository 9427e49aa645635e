"""What the trainings by policy iteration share: advantages from recorded choices, and the minimisation of a loss."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

#: Choices in a batch.
BATCH = 1024


def discounted_surprises(
    rewards: NDArray[np.float32],
    durations: NDArray[np.float32],
    lengths: NDArray[np.int64],
    values: NDArray[np.float32],
    later: float,
    discounts: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return the sum (C,) of each choice's surprise, its temporal-difference error, and the later ones of its UAV.

    ``rewards``, ``durations`` and ``values`` (C,) are those of the choices of U UAVs, ``lengths`` (U,) the choices of
    each. Both factors are per unit of duration: ``discounts`` (C,) on what comes later, ``later`` besides on later
    surprises.
    """
    out, first = np.zeros(len(values), np.float32), 0
    for length in lengths.tolist():
        following = beyond = 0.0
        for k in range(first + length - 1, first - 1, -1):
            factor = discounts[k] ** durations[k]
            surprise = rewards[k] + factor * following - values[k]
            beyond = surprise + factor * later ** durations[k] * beyond
            out[k], following = beyond, values[k]
        first += length
    return out


def minimise(
    network: nn.Module,
    some: NDArray[np.int64],
    passes: int,
    rate: float,
    loss: Callable[[NDArray[np.int64]], Tensor],
    decay: float = 0.0,
) -> float:
    """Minimise a loss over some choices by AdamW, with a falling learning rate; return its mean over the last pass.

    ``some`` (S,) are rows of choices; ``loss`` returns the mean loss of the rows of a batch.
    """
    optimiser = torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=decay)
    order = list(_batches(some, passes))
    schedule = torch.optim.lr_scheduler.LinearLR(optimiser, 1.0, 0.05, max(1, len(order)))
    errors = []
    for each in order:
        error = loss(each)
        optimiser.zero_grad()
        error.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimiser.step()
        schedule.step()
        errors.append(error.item())
    last = errors[-max(1, len(errors) // passes) :]
    return float(np.mean(last)) if last else float("nan")


def _batches(some: NDArray[np.int64], passes: int) -> Iterator[NDArray[np.int64]]:
    """Yield batches of rows in random order, each sorted; a rest of less than half a batch is left out."""
    for _ in range(passes):
        mixed = some[torch.randperm(len(some)).numpy()]
        yield from (np.sort(mixed[k : k + BATCH]) for k in range(0, len(mixed), BATCH) if len(mixed) - k >= BATCH // 2)
