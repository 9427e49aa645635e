"""The pocket network in torch, and its supervised learning from examples: loss, random batches, updates of an epoch.

:mod:`indoor_explorers.planners.toolbox.pockets.network` computes the same outputs without torch.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from indoor_explorers.learners.sessions.networks import learner_tensors, restore_learner
from indoor_explorers.planners.toolbox.pockets.features import COARSE_LAYERS, FINE_LAYERS, PLAIN, SIDE, Kind
from indoor_explorers.planners.toolbox.pockets.network import (
    CHANNELS,
    COARSE_SCALES,
    FINE_SCALES,
    HIDDEN,
    KERNELS,
    OUTPUTS,
    STRIDES,
    THRESHOLDS,
    side_after,
)


class PocketNet(nn.Module):
    """Two stacks of convolutions, one for each picture, and a hidden layer that joins them with the numbers."""

    def __init__(self, kind: Kind = PLAIN) -> None:
        super().__init__()
        for name, layers in (("fine", kind.levels * FINE_LAYERS), ("coarse", kind.levels * COARSE_LAYERS)):
            for k, (channels, size, stride) in enumerate(zip(CHANNELS, KERNELS, STRIDES, strict=True), start=1):
                setattr(self, f"{name}{k}", nn.Conv2d(layers, channels, size, stride))
                layers = channels
        self.hidden = nn.Linear(2 * CHANNELS[-1] * side_after(SIDE) ** 2 + kind.numbers, HIDDEN)
        self.out = nn.Linear(HIDDEN, OUTPUTS)
        scales = {"fine": FINE_SCALES, "coarse": COARSE_SCALES}
        self.scales = {name: torch.from_numpy(np.tile(each, kind.levels)) for name, each in scales.items()}

    def forward(self, fine: Tensor, coarse: Tensor, numbers: Tensor) -> Tensor:
        """Return the outputs (K, OUTPUTS) for uint8 pictures (K, layers, SIDE, SIDE) and numbers (K, N)."""
        flat = []
        for name, picture in (("fine", fine), ("coarse", coarse)):
            x = picture * self.scales[name][:, None, None]
            for k in range(1, len(CHANNELS) + 1):
                x = torch.relu(getattr(self, f"{name}{k}")(x))
            flat.append(x.permute(0, 2, 3, 1).flatten(1))  # row, column, channel: the order of the compiled network
        joined = torch.relu(self.hidden(torch.cat([*flat, numbers], dim=1)))
        return cast(Tensor, self.out(joined))


#: Examples in one update, first learning rate, and weight decay.
BATCH, RATE, DECAY = 256, 2e-3, 1e-3
#: Weight of the error of log(1 + depth) beside the mean cross-entropy of the thresholds.
DEPTH = 0.05


def loss(outputs: Tensor, sizes: Tensor, depths: Tensor) -> Tensor:
    """Return the mean cross-entropy of the thresholds plus the weighted error of the depth where there is a pocket.

    ``outputs`` (K, OUTPUTS) are the network's; ``sizes`` (K,) in cells and ``depths`` (K,) in steps are the truth.
    """
    targets = (sizes[:, None] > torch.tensor(THRESHOLDS, device=sizes.device)).float()
    entropy = functional.binary_cross_entropy_with_logits(outputs[:, :-1], targets)
    there = (sizes > 0).float()
    error = functional.smooth_l1_loss(outputs[:, -1], torch.log1p(depths), reduction="none")
    return entropy + DEPTH * (error * there).sum() / there.sum().clamp(min=1.0)


def batches(examples: Mapping[str, NDArray[Any]], rng: np.random.Generator) -> Iterator[list[Tensor]]:
    """Yield the examples once, in random order, each batch turned and mirrored at random; a partial batch is left out.

    A batch is ``fine`` and ``coarse`` (BATCH, layers, SIDE, SIDE) uint8, ``numbers`` (BATCH, N), ``sizes`` and
    ``depths`` (BATCH,).
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


class PocketLearner:
    """The network and its optimiser, whose learning rate falls along a cosine to 0 at the end of the last epoch."""

    def __init__(self, examples: Mapping[str, NDArray[Any]], *, epochs: int, seed: int, kind: Kind = PLAIN) -> None:
        torch.manual_seed(seed)
        self._examples, self._rng = examples, np.random.default_rng(seed)
        self.network = PocketNet(kind)
        self._optimiser = torch.optim.AdamW(self.network.parameters(), lr=RATE, weight_decay=DECAY)
        self.count = len(examples["sizes"])
        """Number of examples."""
        self.updates_per_epoch = self.count // BATCH
        most = max(1, epochs * self.updates_per_epoch)
        self._schedule = torch.optim.lr_scheduler.CosineAnnealingLR(self._optimiser, most)
        self.epochs = self.updates = 0
        """Finished epochs, and updates in the present one."""
        self.mean_loss = math.nan
        """Mean loss in the last finished epoch."""
        self._total = 0.0
        self._begin_epoch()

    def _begin_epoch(self) -> None:
        self._rng_before = self._rng.bit_generator.state
        self._batches = batches(self._examples, self._rng)

    def update(self) -> None:
        """Learn from the next batch; where there is none, end the epoch."""
        batch = next(self._batches, None)
        if batch is None:
            self.mean_loss = self._total / max(1, self.updates)
            self.epochs, self.updates, self._total = self.epochs + 1, 0, 0.0
            self._begin_epoch()
            return
        fine, coarse, numbers, sizes, depths = batch
        error = loss(self.network(fine, coarse, numbers), sizes, depths)
        self._optimiser.zero_grad()
        error.backward()  # type: ignore[no-untyped-call]
        self._optimiser.step()
        self._schedule.step()
        self.updates, self._total = self.updates + 1, self._total + error.item()

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of a checkpoint by name."""
        return learner_tensors({"network": self.network}, self._optimiser)

    def state(self) -> dict[str, Any]:
        """Return what else a checkpoint needs: the random order is drawn again from the epoch's beginning."""
        return {
            "epochs": self.epochs,
            "updates": self.updates,
            "mean_loss": self.mean_loss,
            "total": self._total,
            "rng": self._rng_before,
            "schedule": self._schedule.state_dict(),
        }

    def restore(self, tensors: Mapping[str, NDArray[Any]], state: Mapping[str, Any]) -> None:
        """Restore what :meth:`tensors` and :meth:`state` returned."""
        restore_learner(tensors, {"network": self.network}, self._optimiser)
        self._schedule.load_state_dict(state["schedule"])
        self._optimiser.param_groups[0]["lr"] = self._schedule.get_last_lr()[0]
        self.epochs, self.mean_loss, self._total = state["epochs"], state["mean_loss"], state["total"]
        self._rng.bit_generator.state = state["rng"]
        self._begin_epoch()
        for self.updates in range(1, state["updates"] + 1):
            next(self._batches)
