"""The networks in training, in torch: the policy, as in :mod:`.network`, and the critics of the same shape."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from indoor_explorers.learners.attention.network import CLIP, NetworkSettings, Weights
from indoor_explorers.learners.attention.sparse import attention


class Batch(NamedTuple):
    """B graphs with T nodes in all, one after the other."""

    features: Tensor
    """(T, F)."""
    near: Tensor
    """(T, 1 + K) int32 rows that each node attends to: itself and its neighbours; negative for none."""
    own: Tensor
    """(B,) row of node 0 of each graph."""
    all: Tensor
    """(B, N) int32 rows of each graph; -1 for none."""
    actions: Tensor
    """(B, K) rows to choose from, 0 where there is none."""
    legal: Tensor
    """(B, K) bool, whether there is one."""


def batch_of(
    features: Sequence[NDArray[np.floating]],
    neighbours: Sequence[NDArray[np.integer]],
    actions: Sequence[NDArray[np.integer]],
) -> Batch:
    """Return graphs as a batch: (N', F) features and (N', K) neighbours of each, and the (K,) nodes to choose from."""
    sizes = np.array([len(each) for each in features])
    first = np.cumsum(sizes) - sizes
    edges, shift = np.concatenate(neighbours).astype(np.int32), np.repeat(first, sizes)[:, None]
    near = np.concatenate([np.arange(len(edges))[:, None], np.where(edges >= 0, edges + shift, -1)], axis=1)
    places, chosen = np.arange(sizes.max()), np.stack(actions).astype(np.int64)
    every = np.where(places < sizes[:, None], first[:, None] + places, -1)
    return Batch(
        torch.from_numpy(np.concatenate(features).astype(np.float32)),
        torch.from_numpy(near.astype(np.int32)),
        torch.from_numpy(first),
        torch.from_numpy(every.astype(np.int32)),
        torch.from_numpy(np.where(chosen >= 0, first[:, None] + chosen, 0)),
        torch.from_numpy(chosen >= 0),
    )


class _Block(nn.Module):
    """Attention and two layers, each with layer normalisation before it and a residual connection around it."""

    def __init__(self, units: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.before, self.between = nn.LayerNorm(units), nn.LayerNorm(units)
        self.query, self.pair, self.out = nn.Linear(units, units), nn.Linear(units, 2 * units), nn.Linear(units, units)
        self.wide, self.narrow = nn.Linear(units, 2 * units), nn.Linear(2 * units, units)

    def forward(self, x: Tensor, memory: Tensor, near: Tensor) -> Tensor:
        """Return x (Q, d) after attention to the rows ``near`` (Q, K) of ``memory`` (T, d)."""
        query, pair = self.query(self.before(x)), self.pair(self.before(memory))
        x = x + self.out(attention(query, pair, near, self.heads))
        hidden: Tensor = self.narrow(torch.relu(self.wide(self.between(x))))
        return x + hidden


class _GraphNet(nn.Module):
    """The encoder and the decoder."""

    def __init__(self, inputs: int, settings: NetworkSettings) -> None:
        super().__init__()
        units = settings.units
        self.embed = nn.Linear(inputs, units)
        self.layers = nn.ModuleList(_Block(units, settings.heads) for _ in range(settings.layers))
        self.decoder = _Block(units, settings.heads)
        self.joined = nn.Linear(2 * units, units)

    def encode(self, batch: Batch) -> tuple[Tensor, Tensor]:
        """Return the decoded node 0, (B, d), and the K nodes to choose from, (B, K, d)."""
        x = self.embed(batch.features)
        for layer in self.layers:
            x = layer(x, x, batch.near)
        own = x[batch.own]
        joined: Tensor = self.joined(torch.cat([self.decoder(own, x, batch.all), own], dim=-1))
        return joined, x[batch.actions]


class PolicyNet(_GraphNet):
    """The policy: a pointer to the neighbours of node 0."""

    def __init__(self, inputs: int, settings: NetworkSettings) -> None:
        super().__init__(inputs, settings)
        self.pointer_query, self.pointer_key = (nn.Linear(settings.units, settings.units, bias=False) for _ in range(2))

    def forward(self, batch: Batch) -> Tensor:
        """Return the logarithms of the probabilities, (B, K); large negative numbers where there is no node."""
        own, options = self.encode(batch)
        products = torch.einsum("bd,bkd->bk", self.pointer_query(own), self.pointer_key(options))
        logits = CLIP * torch.tanh(products / math.sqrt(own.shape[-1]))
        return torch.log_softmax(logits.masked_fill(~batch.legal, -1e8), dim=-1)


class CriticNet(_GraphNet):
    """A critic: the value of flying to each neighbour of node 0."""

    def __init__(self, inputs: int, settings: NetworkSettings) -> None:
        super().__init__(inputs, settings)
        self.hidden, self.value = nn.Linear(2 * settings.units, settings.units), nn.Linear(settings.units, 1)

    def forward(self, batch: Batch) -> Tensor:
        """Return the values (B, K), 0 where there is no node."""
        own, options = self.encode(batch)
        both = torch.cat([own[:, None].expand_as(options), options], dim=-1)
        values: Tensor = self.value(torch.relu(self.hidden(both))).squeeze(-1)
        return values.masked_fill(~batch.legal, 0.0)


def weights_of(network: nn.Module) -> Weights:
    """Return copies of the weights by name."""
    return {name: value.detach().numpy().copy() for name, value in network.state_dict().items()}
