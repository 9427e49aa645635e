"""Policy improvement from recorded choices: value networks that know the truth, advantages, the dueling network.

A round is that of :mod:`indoor_explorers.learners.places.learning`, for two actions: the value network of each half of
the flights judges the other half (van Hasselt 2010); advantages are discounted sums of later surprises (Schulman et al.
2016); the dueling network learns how much better flying home is, centred by the probabilities of the draw (Pan et al.
2022); the next policy is the present one times exp(A / temperature).
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from indoor_explorers.learners.pockets.improvement import discounted_surprises, minimise
from indoor_explorers.learners.reports.flights import TRUE, Choices
from indoor_explorers.learners.reports.network import WIDTH, NetworkWeights
from indoor_explorers.learners.reports.situation import NUMBERS

#: Share of later surprises that count, per lidar range of flight.
LATER = 0.8
#: Temperature of a round's step, in points: what flying home must be better by to become e times as likely.
TEMPERATURE = 0.1
#: Passes over the choices: of the value networks, and of the dueling network; their learning rates and weight decays.
VALUE_PASSES, PASSES, VALUE_RATE, RATE, DECAY = 12, 8, 2e-3, 1e-3, 1e-2
#: Errors beyond this, in points, count linearly.
ROBUST = 5.0
#: Width of the value networks' layers; scale of their output, and output 0, in points.
VALUE_WIDTH, UNIT, CENTRE = 96, 10.0, -30.0


class AdvantageNet(nn.Sequential):
    """The dueling network without its state value; it begins as the rule."""

    def __init__(self) -> None:
        out = nn.Linear(WIDTH, 1)
        nn.init.zeros_(out.weight)
        nn.init.zeros_(out.bias)
        super().__init__(nn.Linear(NUMBERS, WIDTH), nn.ReLU(), nn.Linear(WIDTH, WIDTH), nn.ReLU(), out)

    @property
    def layers(self) -> list[nn.Linear]:
        """The linear layers."""
        return [layer for layer in self if isinstance(layer, nn.Linear)]

    def weights(self) -> NetworkWeights:
        """Return copies of the weights in the layout of the network that flies."""
        arrays = [each.detach().numpy().T for layer in self.layers for each in (layer.weight, layer.bias)]
        return NetworkWeights(*(np.array(array, np.float32, order="C") for array in arrays))

    def load(self, weights: NetworkWeights) -> None:
        """Take over weights."""
        arrays = [torch.from_numpy(np.array(array.T, order="C")) for array in weights]
        with torch.no_grad():
            for layer, weight, bias in zip(self.layers, arrays[::2], arrays[1::2], strict=True):
                layer.weight.copy_(weight)
                layer.bias.copy_(bias)


def advantages(choices: Choices, values: NDArray[np.float32], later: float) -> NDArray[np.float32]:
    """Return the advantages of the choices, (C,), in points; ``later`` 1 gives the return less ``values`` (C,)."""
    discounts = np.ones_like(values)
    return discounted_surprises(choices.rewards, choices.durations, choices.lengths, values, later, discounts)


def learn_values(choices: Choices) -> NDArray[np.float32]:
    """Fit a value network to the returns of each half of the flights; return (C,) the predictions of the other's."""
    half = np.repeat(choices.flight % 2, choices.lengths)
    inputs = torch.from_numpy(np.concatenate([choices.numbers, choices.true], axis=1))
    inputs = (inputs - inputs.mean(0)) / (inputs.std(0) + 1e-3)
    judged = np.zeros(len(half), np.float32)
    returns = torch.from_numpy(advantages(choices, judged, 1.0))
    for taught in (0, 1):
        network = nn.Sequential(
            nn.Linear(NUMBERS + TRUE, VALUE_WIDTH),
            nn.ReLU(),
            nn.Linear(VALUE_WIDTH, VALUE_WIDTH),
            nn.ReLU(),
            nn.Linear(VALUE_WIDTH, 1),
        )

        def predicted(some: NDArray[np.int64], network: nn.Module = network) -> Tensor:
            values: Tensor = network(inputs[some]).squeeze(1) * UNIT + CENTRE
            return values

        def loss(some: NDArray[np.int64]) -> Tensor:
            return functional.smooth_l1_loss(predicted(some), returns[some], beta=ROBUST)

        minimise(network, np.flatnonzero(half == taught), VALUE_PASSES, VALUE_RATE, loss)
        others = np.flatnonzero(half != taught)
        with torch.no_grad():
            judged[others] = predicted(others).numpy()
    return judged


def learn_choices(network: AdvantageNet, choices: Choices, worth: NDArray[np.float32]) -> float:
    """Move a network to the next policy, by the advantages ``worth`` (C,) in points; return the mean loss."""
    inputs, targets = torch.from_numpy(choices.numbers), torch.from_numpy(worth)
    with torch.no_grad():
        before = network(inputs).squeeze(1)
    chosen = torch.from_numpy(choices.home.astype(np.float32) - choices.probabilities)

    def loss(some: NDArray[np.int64]) -> Tensor:
        better = TEMPERATURE * (network(inputs[some]).squeeze(1) - before[some])
        return functional.smooth_l1_loss(better * chosen[some], targets[some], beta=ROBUST)

    return minimise(network, np.arange(len(worth)), PASSES, RATE, loss, DECAY)


def explained(choices: Choices, values: NDArray[np.float32]) -> float:
    """Return the share of the variance of the returns that ``values`` (C,) explain; 1 at best."""
    returns = advantages(choices, np.zeros_like(values), 1.0)
    return float(1.0 - np.var(returns - values) / np.var(returns))
