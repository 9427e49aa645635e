"""The networks in training, in torch: the one that flies, as in :mod:`.network`, and one that sees the true map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from indoor_explorers.learners.places.flights import ChoiceArrays
from indoor_explorers.learners.places.network import WIDTH, Weights, layout_of
from indoor_explorers.learners.places.options import Option
from indoor_explorers.learners.places.scene import MOST, input_sizes
from indoor_explorers.learners.places.truth import TRUE_PLACE

#: Width of the value networks' layers.
VALUE_HIDDEN = 96
#: Scale of the value networks' output, in lidar ranges.
UNIT = 10.0


class Batch(NamedTuple):
    """B choices."""

    places: Tensor
    """(B, K, place)."""
    common: Tensor
    """(B, common)."""
    there: Tensor
    """(B, K) bool, whether there is such a place; (B, K + O) with options."""
    costs: Tensor
    """(B, K) the planner's costs."""
    true_places: Tensor
    """(B, K, TRUE_PLACE)."""
    true_common: Tensor
    """(B, true common)."""


def batch_of(choices: ChoiceArrays, some: NDArray[np.int64]) -> Batch:
    """Return some of the C choices as a batch; ``some`` (B,) are their rows."""
    tensors = (torch.from_numpy(choices.arrays[name][some]) for name in Batch._fields)
    return Batch(*(each if each.dtype is torch.bool else each.float() for each in tensors))


class _Set(nn.Module):
    """Two layers for each place, and the mean and the maximum over the places (Deep Sets, Zaheer et al. 2017)."""

    def __init__(self, place: int, common: int, hidden: int) -> None:
        super().__init__()
        self.first, self.second = nn.Linear(place + common, hidden), nn.Linear(hidden, hidden)

    def forward(self, places: Tensor, common: Tensor, there: Tensor) -> tuple[Tensor, Tensor]:
        """Return the places' hidden units (B, K, hidden), and their mean and maximum (B, 2 hidden).

        Takes ``places`` (B, K, place), ``common`` (B, common) and ``there`` (B, K) bool.
        """
        rows = torch.cat([places, common[:, None].expand(-1, places.shape[1], -1)], dim=-1)
        inside = torch.relu(self.second(torch.relu(self.first(rows))))
        real = there[..., None]
        mean = (inside * real).sum(1) / real.sum(1).clamp(min=1)
        return inside, torch.cat([mean, inside.masked_fill(~real, 0.0).amax(1)], dim=-1)


class AdvantageNet(nn.Module):
    """The dueling network without its state value: values of places relative to each other. This part flies.

    Every hidden layer has ``width`` units; ``task`` tells whether it sees the task's inputs, ``options`` whether it
    values options beside the places: from the mean and the maximum over the places, and what is common to all.
    ``prior`` is the weight of the planner's costs, by which the best place is found that options are compared with.
    """

    def __init__(self, width: int = WIDTH, task: bool = False, options: bool = False, prior: float = 0.0) -> None:
        super().__init__()
        place, common = input_sizes(task, options)
        self.set = _Set(place, common, width)
        self.joined, self.out = nn.Linear(3 * width, width), nn.Linear(width, 1)
        nn.init.normal_(self.out.weight, std=1e-3)
        nn.init.zeros_(self.out.bias)
        self.layers = [self.set.first, self.set.second, self.joined, self.out]
        self.has_options, self.prior = options, prior
        if options:
            self.option, self.option_second = nn.Linear(2 * width + common, width), nn.Linear(width, width)
            self.option_out = nn.Linear(width, len(Option))
            nn.init.zeros_(self.option_out.weight)
            nn.init.zeros_(self.option_out.bias)
            self.layers += [self.option, self.option_second, self.option_out]

    def keep_places(self) -> None:
        """Let only the layers of the options learn from now on."""
        for part in (self.set, self.joined, self.out):
            part.requires_grad_(False)

    def forward(self, batch: Batch) -> Tensor:
        """Return the values (B, K), or (B, K + O) with options; 0 where there is no place or option."""
        inside, pooled = self.set(batch.places, batch.common, batch.there[:, :MOST])
        joined = torch.cat([inside, pooled[:, None].expand(-1, inside.shape[1], -1)], dim=-1)
        values = self.out(torch.relu(self.joined(joined))).squeeze(-1)
        if self.has_options:
            inputs = torch.cat([pooled, batch.common], dim=-1)
            beyond = self.option_out(torch.relu(self.option_second(torch.relu(self.option(inputs)))))
            whole = (values - self.prior * batch.costs).masked_fill(~batch.there[:, :MOST], -torch.inf)
            values = torch.cat([values, whole.amax(1, keepdim=True) + beyond], dim=-1)
        return torch.where(batch.there, values, 0.0)


class ValueNet(nn.Module):
    """Predicts the return of the rest of a flight from the places and the true map.

    ``place`` and ``common`` are how many numbers the choices have about a place and about all of them, ``true_common``
    how many about the true map.
    """

    def __init__(self, place: int, common: int, true_common: int) -> None:
        super().__init__()
        self.set = _Set(place + TRUE_PLACE + 1, common + true_common, VALUE_HIDDEN)
        self.centre, self.spread = torch.zeros(common + true_common), torch.ones(common + true_common)
        self.hidden, self.out = nn.Linear(2 * VALUE_HIDDEN, VALUE_HIDDEN), nn.Linear(VALUE_HIDDEN, 1)

    def standardise(self, common: Tensor) -> None:
        """Take what is common to all places relative to its mean and standard deviation over some choices (C, N)."""
        self.centre, self.spread = common.mean(0), common.std(0) + 1e-3

    def forward(self, batch: Batch) -> Tensor:
        """Return the values (B,), in lidar ranges."""
        places = torch.cat([batch.places, batch.true_places, batch.costs[..., None] / 5.0], dim=-1)
        common = (torch.cat([batch.common, batch.true_common], dim=-1) - self.centre) / self.spread
        _, pooled = self.set(places, common, batch.there[:, :MOST])
        value: Tensor = self.out(torch.relu(self.hidden(pooled))).squeeze(-1) * UNIT
        return value


def weights_of(network: AdvantageNet) -> Weights:
    """Return copies of the weights in the layout of the network that flies: (inputs, outputs), float32."""
    arrays: list[NDArray[np.float32]] = []
    for layer in network.layers:
        arrays += [np.ascontiguousarray(layer.weight.detach().numpy().T), layer.bias.detach().numpy().copy()]
    return layout_of(network.has_options)(*arrays)


def load_into(network: AdvantageNet, weights: Weights) -> None:
    """Set the weights of a network to ``weights`` in the layout of :func:`weights_of`."""
    with torch.no_grad():
        for layer, weight, bias in zip(network.layers, weights[::2], weights[1::2], strict=True):
            layer.weight.copy_(torch.from_numpy(weight.T.copy()))
            layer.bias.copy_(torch.from_numpy(bias))
