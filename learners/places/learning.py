"""Policy improvement from recorded choices: value networks that know the map, advantages, and the dueling network.

One round of policy iteration:

1. Two value networks learn the returns, each from one half of the flights, and judge the other half (double
   estimation, van Hasselt 2010), so that no return is compared with a value that has seen it.
2. The advantages of the chosen places are sums of later surprises, discounted (Schulman et al. 2016, arXiv:1506.02438).
3. A dueling network (Wang et al. 2016, arXiv:1511.06581) learns them. Its values are relative to the mean over the
   places, weighted with the probabilities that the flight chose them with (Pan et al. 2022, "Direct Advantage
   Estimation", arXiv:2109.06093).
4. The next policy chooses with probabilities p exp(A / temperature), p the present ones (policy mirror descent): the
   network learns their logarithms.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from indoor_explorers.learners.places.flights import ChoiceArrays
from indoor_explorers.learners.places.model import AdvantageNet, ValueNet, batch_of
from indoor_explorers.learners.places.scene import MOST
from indoor_explorers.learners.pockets.improvement import discounted_surprises, minimise

#: Share of later surprises that count, per lidar range of flight.
LATER = 0.7
#: Temperature of a round's step, in lidar ranges: what a place must be better by to become e times as likely.
TEMPERATURE = 0.3
#: Passes over the choices: of the value networks, of the dueling network, and of the options' layers where they learn
#: alone, as fewer of the choices are of them.
VALUE_PASSES, DUELING_PASSES, OPTION_PASSES = 6, 3, 8
#: Learning rates of the value networks and of the dueling network; weight decay of the latter.
VALUE_RATE, RATE, DECAY = 2e-3, 1e-3, 1e-2
#: Errors beyond this, in lidar ranges, count linearly.
ROBUST = 3.0


def advantages(choices: ChoiceArrays, values: NDArray[np.float32], later: float) -> NDArray[np.float32]:
    """Return the advantages of the chosen places, (C,), in lidar ranges (generalised advantage estimation).

    ``values`` (C,) are the predicted returns at the choices. ``later`` is lambda per lidar range: 1 gives the return
    less the value, 0 the temporal-difference error until the next choice alone.
    """
    rewards, durations, discounts = (choices.arrays[name] for name in ("rewards", "durations", "discounts"))
    return discounted_surprises(rewards, durations, choices.lengths, values, later, discounts)


def learn_values(choices: ChoiceArrays) -> NDArray[np.float32]:
    """Fit a value network to the returns of each half of the flights; return (C,) the predictions of the other's."""
    judged, half = np.zeros(len(choices.half), np.float32), choices.half
    returns = torch.from_numpy(advantages(choices, judged, 1.0))
    common = [choices.arrays[name] for name in ("common", "true_common")]
    for taught in (0, 1):
        network = ValueNet(choices.arrays["places"].shape[-1], *(each.shape[-1] for each in common))
        if choices.arrays["there"].shape[1] > MOST:  # with options there are numbers of very different spread
            network.standardise(torch.from_numpy(np.concatenate(common, axis=1)))

        def loss(some: NDArray[np.int64], network: ValueNet = network) -> Tensor:
            return functional.smooth_l1_loss(network(batch_of(choices, some)), returns[some], beta=ROBUST)

        minimise(network, np.flatnonzero(half == taught), VALUE_PASSES, VALUE_RATE, loss)
        judged[half != taught] = outputs(network, choices)[half != taught]
    return judged


@torch.no_grad()
def outputs(network: nn.Module, choices: ChoiceArrays) -> NDArray[np.float32]:
    """Return a network's outputs for all choices, (C, ...)."""
    parts = np.array_split(np.arange(len(choices.half)), 1 + len(choices.half) // 8192)
    return np.concatenate([network(batch_of(choices, some)).numpy() for some in parts])


def learn_choices(
    network: AdvantageNet, choices: ChoiceArrays, worth: NDArray[np.float32], passes: int = DUELING_PASSES
) -> float:
    """Move a network to the next policy, by the advantages ``worth`` (C,) in lidar ranges; return the mean loss."""
    before = torch.from_numpy(outputs(network, choices))
    weights, chosen = (torch.from_numpy(choices.arrays[name]) for name in ("probabilities", "chosen"))
    targets = torch.from_numpy(worth)

    def loss(some: NDArray[np.int64]) -> Tensor:
        changes = TEMPERATURE * (network(batch_of(choices, some)) - before[some])
        mean = (changes * weights[some]).sum(dim=1)
        beyond = changes.gather(1, chosen[some][:, None]).squeeze(1) - mean
        return functional.smooth_l1_loss(beyond, targets[some], beta=ROBUST)

    return minimise(network, np.arange(len(worth)), passes, RATE, loss, DECAY)


def explained(choices: ChoiceArrays, values: NDArray[np.float32]) -> float:
    """Return the share of the variance of the returns that ``values`` (C,) explain; 1 at best."""
    returns = advantages(choices, np.zeros_like(values), 1.0)
    return float(1.0 - np.var(returns - values) / np.var(returns))
