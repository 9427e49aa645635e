"""Train the pocket network on examples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from indoor_explorers.learners.pockets.model import PocketNet
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS

#: Settings of the training.
BATCH, RATE, DECAY = 256, 2e-3, 1e-3
#: Weight of the error of log(1 + depth) beside the mean cross-entropy of the thresholds.
DEPTH = 0.05


def loss(outputs: Tensor, sizes: Tensor, depths: Tensor) -> Tensor:
    """Return the mean cross-entropy of the thresholds plus the error of the depth where there is a pocket, a scalar.

    ``outputs`` (B, OUTPUTS) are the network's; ``sizes`` (B,) and ``depths`` (B,) are the true ones.
    """
    targets = (sizes[:, None] > torch.tensor(THRESHOLDS, device=sizes.device)).float()
    entropy = functional.binary_cross_entropy_with_logits(outputs[:, :-1], targets)
    there = (sizes > 0).float()
    error = functional.smooth_l1_loss(outputs[:, -1], torch.log1p(depths), reduction="none")
    return entropy + DEPTH * (error * there).sum() / there.sum().clamp(min=1.0)


def batches(examples: Mapping[str, NDArray[Any]], rng: np.random.Generator) -> Iterator[list[Tensor]]:
    """Yield the examples once, in random order, each batch turned and mirrored at random.

    A batch is ``fine`` and ``coarse`` (B, layers, SIDE, SIDE) uint8, ``numbers`` (B, 2), ``sizes`` and ``depths`` (B,).
    """
    order = rng.permutation(len(examples["sizes"]))
    for first in range(0, len(order) - BATCH + 1, BATCH):
        some = np.sort(order[first : first + BATCH])
        tensors = [torch.from_numpy(examples[name][some]) for name in ("fine", "coarse", "numbers", "sizes", "depths")]
        quarters, mirrored = int(rng.integers(4)), bool(rng.integers(2))
        for k in range(2):
            x = torch.rot90(tensors[k], quarters, (2, 3))
            tensors[k] = x.flip(3) if mirrored else x
        yield tensors


def train(
    examples: Mapping[str, NDArray[Any]], *, epochs: int, seed: int
) -> Iterator[tuple[PocketNet, dict[str, float]]]:
    """Train a network on examples (K, ...); yield it after each epoch with that epoch's mean loss."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = PocketNet()
    optimiser = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    steps = epochs * (len(examples["sizes"]) // BATCH)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, max(1, steps))
    for epoch in range(1, epochs + 1):
        total, count = 0.0, 0
        for fine, coarse, numbers, sizes, depths in batches(examples, rng):
            error = loss(network(fine, coarse, numbers), sizes, depths)
            optimiser.zero_grad()
            error.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            schedule.step()
            total, count = total + error.item(), count + 1
        yield network, {"epoch": epoch, "loss": total / max(1, count)}
