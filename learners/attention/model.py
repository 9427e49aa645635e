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


class Batch(NamedTuple):
    """B graphs, padded to N nodes."""

    features: Tensor
    """(B, N, F)."""
    near: Tensor
    """(B, N, 1 + K) which nodes each node attends to: itself and its neighbours, as rows of the (B N, F) features."""
    joined: Tensor
    """(B, N, 1 + K) bool, whether there is such a neighbour."""
    there: Tensor
    """(B, N) bool, whether there is such a node."""
    actions: Tensor
    """(B, K) nodes to choose from, 0 where there is none."""
    legal: Tensor
    """(B, K) bool, whether there is one."""


def batch_of(
    features: Sequence[NDArray[np.floating]],
    neighbours: Sequence[NDArray[np.integer]],
    actions: Sequence[NDArray[np.integer]],
) -> Batch:
    """Return graphs as a batch: (N', F) features and (N', K) neighbours of each, and the (K,) nodes to choose from."""
    most = max(len(each) for each in features)
    padded = torch.zeros(len(features), most, features[0].shape[1])
    there = torch.zeros(len(features), most, dtype=torch.bool)
    near = torch.full((len(features), most, 1 + neighbours[0].shape[1]), -1)
    near[:, :, 0] = torch.arange(most)
    for b, (rows, edges) in enumerate(zip(features, neighbours, strict=True)):
        padded[b, : len(rows)] = torch.from_numpy(rows.astype(np.float32))
        there[b, : len(rows)] = True
        near[b, : len(rows), 1:] = torch.from_numpy(edges.astype(np.int64))
    chosen = torch.from_numpy(np.stack(actions).astype(np.int64))
    joined, first = near >= 0, most * torch.arange(len(features))[:, None, None]
    return Batch(padded, near.clamp(min=0) + first, joined, there, chosen.clamp(min=0), chosen >= 0)


class _Block(nn.Module):
    """Attention and two layers, each with layer normalisation before it and a residual connection around it."""

    def __init__(self, units: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.of_head: Tensor  # (d, heads), 1 where a unit belongs to a head: sums over the units of each
        self.register_buffer("of_head", torch.eye(heads).repeat_interleave(units // heads, 0), persistent=False)
        self.before, self.between = nn.LayerNorm(units), nn.LayerNorm(units)
        self.query, self.pair, self.out = nn.Linear(units, units), nn.Linear(units, 2 * units), nn.Linear(units, units)
        self.wide, self.narrow = nn.Linear(units, 2 * units), nn.Linear(2 * units, units)

    def forward(self, x: Tensor, memory: Tensor, there: Tensor, near: Tensor | None = None) -> Tensor:
        """Return x (B, Q, d) after attention to the rows ``near`` (B, Q, K) of ``memory`` (B, N, d), or to all of it.

        ``there`` (B, Q, K), or (B, 1, N), tells which of these count.
        """
        query, pair = self.query(self.before(x)), self.pair(self.before(memory))
        pair = (
            pair[:, None] if near is None else pair.flatten(0, 1).index_select(0, near.flatten()).view(*near.shape, -1)
        )
        key, value = pair.chunk(2, dim=-1)
        logits = (query[:, :, None] * key) @ self.of_head / math.sqrt(query.shape[-1] / self.heads)
        shares = logits.masked_fill(~there[..., None], -torch.inf).softmax(dim=2)
        x = x + self.out(((shares @ self.of_head.T) * value).sum(dim=2))
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
            x = layer(x, x, batch.joined, batch.near)
        own = x[:, :1]
        decoded = self.decoder(own, x, batch.there[:, None])
        joined: Tensor = self.joined(torch.cat([decoded, own], dim=-1))
        options = x.gather(1, batch.actions[..., None].expand(-1, -1, x.shape[-1]))
        return joined.squeeze(1), options


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


def weights_of(network: PolicyNet) -> Weights:
    """Return copies of the weights by name."""
    return {name: value.detach().numpy().copy() for name, value in network.state_dict().items()}
