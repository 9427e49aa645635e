"""Fit the map prior: the probability that an unknown cell of a scenario's maps is free and reachable.

UAVs fly to the nearest place with a view of unknown cells. Every few ticks each unknown cell with a known obstacle near
it becomes an example: the cells around it, and whether coverage counts it. This happens before the training, on maps
that no training episode uses, unless the training has a number of maps.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import GAINS
from indoor_explorers.learners.dddqn.observation.map_prior import (
    INPUTS,
    PATCH,
    UNITS,
    MapPrior,
    no_prior,
    prior_from,
    write_patch,
)
from indoor_explorers.learners.sessions.seeds import episode_seed

#: Most parallel episodes, and ticks between two collections of examples.
EPISODES, EVERY = 1024, 5
#: Most cells of all parallel maps together, and fewest parallel episodes.
CELLS, FEWEST = 2**18, 16
#: Ticks after which collecting ends, and after which it ends if there is no example yet.
TICKS, PATIENCE = 300, 50
#: Epochs, examples in one update, Adam's initial step size.
ROUNDS, BATCH, RATE = 5, 256, 3e-3
#: Fewest examples to fit a prior; maps with fewer have hardly any obstacles.
LEAST = 1_000


class PriorExamples(NamedTuple):
    """N unknown cells."""

    patch: NDArray[np.uint8]
    """(N, 49) the 7x7 cells around each."""
    counts: NDArray[np.bool_]
    """(N,) whether coverage counts each."""


@kernel()
def _note(belief: np.ndarray, counts: np.ndarray, patch: np.ndarray, label: np.ndarray, found: int) -> int:
    """Add the unknown cells of one belief (H, W) that have obstacles nearby; return the new number of examples."""
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            if found < len(label) and belief[r, c] == UNKNOWN and write_patch(belief, r, c, patch[found]) > 0:
                label[found] = counts[r, c]
                found += 1
    return found


def collect(scenario: Scenario, first_seed: int, most: int, maps: int = 0) -> PriorExamples:
    """Collect up to ``most`` examples on maps whose seeds begin at ``first_seed``; 0 ``maps`` are as many as needed."""
    seeds = (episode_seed(first_seed, number, maps) for number in count())
    sight = ObservationConfig(layers=("unknown",), coarse=0, sides=False, visits=False, tours=False)
    flight = VectorFlight(scenario, sight, no_prior(), 1, lambda: next(seeds))
    episodes = min(max(CELLS // (flight.shape[0] * flight.shape[1]), FEWEST), EPISODES)
    flight = VectorFlight(scenario, sight, no_prior(), episodes, lambda: next(seeds))
    patch, label, found = np.zeros((most, PATCH * PATCH), np.uint8), np.zeros(most, np.bool_), 0
    state, team = flight.world.state, scenario.team
    nearest = 1 + GAINS.index("distance to the nearest gain")
    for tick in range(1, TICKS):
        flight.observe(np.arange(flight.columns))
        flight.step(np.where(flight.over, 4, flight.moves[:, :, nearest].argmin(axis=1)))
        if tick % EVERY == 0:
            for column in np.flatnonzero(~flight.over).tolist():
                episode, agent = divmod(column, team)
                found = _note(state.belief[episode, agent], state.counts[episode], patch, label, found)
        flight.restart(np.flatnonzero(flight.over.reshape(state.end.shape).all(axis=1)))
        if found == most or (found == 0 and tick == PATIENCE):
            break
    return PriorExamples(patch[:found], label[:found])


def collect_all(scenarios: Sequence[Scenario], first_seed: int, most: int, maps: int = 0) -> PriorExamples:
    """Collect up to ``most`` examples from several scenarios, equally many from each, as :func:`collect` does."""
    parts = [collect(scenario, first_seed, most // len(scenarios), maps) for scenario in scenarios]
    return PriorExamples(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def fit_prior(examples: PriorExamples, seed: int) -> MapPrior:
    """Return the prior fitted to the examples by maximum likelihood; no prior if there are too few."""
    if len(examples.counts) < LEAST:
        return no_prior()
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        net = nn.Sequential(nn.Linear(INPUTS, UNITS), nn.ReLU(), nn.Linear(UNITS, 1))
        optimiser = torch.optim.Adam(net.parameters(), lr=RATE)
        for tick in range(ROUNDS):
            for group in optimiser.param_groups:
                group["lr"] = RATE * (1.0 - tick / ROUNDS)
            for chosen in torch.split(torch.randperm(len(examples.counts)), BATCH):
                inputs = torch.from_numpy(_inputs(examples.patch[chosen.numpy()]))
                wanted = torch.from_numpy(examples.counts[chosen.numpy()].astype(np.float32))
                loss = nn.functional.binary_cross_entropy_with_logits(net(inputs)[:, 0], wanted)
                optimiser.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                optimiser.step()
    hidden, hidden_bias, out, out_bias = (parameter.detach().numpy() for parameter in net.parameters())
    return prior_from(
        {"prior.hidden": hidden.T, "prior.hidden_bias": hidden_bias, "prior.out": out[0], "prior.out_bias": out_bias}
    )


def _inputs(patch: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the one-hot inputs (N, 147) of the prior's network for patches (N, 49)."""
    return np.concatenate([patch == kind for kind in (1, 2, 3)], axis=1).astype(np.float32)
