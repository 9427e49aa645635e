"""The policy network in numpy, and its weights file: flying it needs no torch.

An encoder of masked self-attention over the edges of the graph, a decoder in which the UAV's node attends to all nodes,
and a pointer that scores the neighbours of the UAV's node (the policy network of ARiADNE 2023). :mod:`.model` has the
same network in torch. Matrix products are numpy's, so outputs may differ between machines in the last digits.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from indoor_explorers.learners.attention.graph import FEATURES, Graph, GraphSettings
from indoor_explorers.learners.sessions.settings import Settings
from indoor_explorers.planners.toolbox.networks.weights_file import read_once, read_weights_file, write_weights_file

Array = NDArray[np.float32]
Weights = dict[str, Array]
#: Scores of the pointer are clipped to this by a hyperbolic tangent.
CLIP = 10.0
#: Added to variances in layer normalisation.
EPSILON = 1e-5


class NetworkSettings(Settings):
    """Sizes of the networks. The paper has 128 units, 8 heads and 6 layers; these train on two CPU cores."""

    units: int = Field(32, ge=4, le=512)
    """Width of the node embeddings, a multiple of ``heads``."""
    heads: int = Field(4, ge=1, le=16)
    """Attention heads."""
    layers: int = Field(3, ge=1, le=12)
    """Layers of the encoder."""

    @model_validator(mode="after")
    def _divisible(self) -> NetworkSettings:
        if self.units % self.heads:
            raise ValueError(f"units is {self.units}, no multiple of heads, {self.heads}; change one of them")
        return self


class Loaded(NamedTuple):
    """The content of a weights file."""

    weights: Weights
    network: NetworkSettings
    graph: GraphSettings


def shapes(inputs: int, settings: NetworkSettings) -> dict[str, tuple[int, ...]]:
    """Return the shapes of a policy network's weights by name, as torch lays them out."""
    d = settings.units
    found: dict[str, tuple[int, ...]] = {"embed.weight": (d, inputs), "embed.bias": (d,)}
    for block in (*(f"layers.{k}" for k in range(settings.layers)), "decoder"):
        for name, rows, cols in (
            ("query", d, d),
            ("pair", 2 * d, d),
            ("out", d, d),
            ("wide", 2 * d, d),
            ("narrow", d, 2 * d),
        ):
            found |= {f"{block}.{name}.weight": (rows, cols), f"{block}.{name}.bias": (rows,)}
        found |= {f"{block}.{norm}.{part}": (d,) for norm in ("before", "between") for part in ("weight", "bias")}
    found |= {"joined.weight": (d, 2 * d), "joined.bias": (d,)}
    return found | {f"{name}.weight": (d, d) for name in ("pointer_query", "pointer_key")}


def scores(graph: Graph, loaded: Loaded) -> Array:
    """Return the scores of the K neighbours of node 0, (K,): logits of the policy; -inf where there is none."""
    weights, heads = loaded.weights, loaded.network.heads
    near = np.concatenate([np.arange(len(graph.cells))[:, None], graph.neighbours], axis=1)
    x = encoded(graph.features, near, weights, loaded.network.layers, heads)
    found = pointed(decoded(x, 0, weights, heads), x[graph.neighbours[0]], weights)
    return np.where(graph.neighbours[0] >= 0, found, np.float32(-np.inf))


def encoded(features: Array, near: NDArray[np.integer], weights: Weights, layers: int, heads: int) -> Array:
    """Return the (N, d) embeddings of N nodes after attention of each to the nodes ``near`` (N, K), -1 for none."""
    x, there = linear(features, weights, "embed"), near >= 0
    for k in range(layers):
        x = _block(x, x, near, there, weights, f"layers.{k}", heads)
    return x


def decoded(x: Array, own: int, weights: Weights, heads: int) -> Array:
    """Return the state (d,) of node ``own`` after attention to all of (N, d) nodes."""
    everything = np.arange(len(x))[None]
    node = x[own : own + 1]
    seen = _block(node, x, everything, np.ones_like(everything, np.bool_), weights, "decoder", heads)
    return np.asarray(linear(np.concatenate([seen, node], axis=1), weights, "joined")[0])


def pointed(state: Array, options: Array, weights: Weights) -> Array:
    """Return the pointer's scores (K,) of (K, d) options in a state (d,)."""
    query = state @ weights["pointer_query.weight"].T
    keys = options @ weights["pointer_key.weight"].T
    return np.asarray(CLIP * np.tanh(keys @ query / np.float32(np.sqrt(len(query)))))


def linear(x: Array, weights: Weights, name: str) -> Array:
    """Return the rows of x (N, inputs) through the layer ``name``, (N, outputs)."""
    return np.asarray(x @ weights[f"{name}.weight"].T + weights[f"{name}.bias"])


def _norm(x: Array, weights: Weights, name: str) -> Array:
    centred = x - x.mean(axis=-1, keepdims=True)
    scaled = centred / np.sqrt(np.square(centred).mean(axis=-1, keepdims=True) + np.float32(EPSILON))
    return np.asarray(scaled * weights[f"{name}.weight"] + weights[f"{name}.bias"])


def _block(
    x: Array,
    memory: Array,
    near: NDArray[np.integer],
    there: NDArray[np.bool_],
    weights: Weights,
    name: str,
    heads: int,
) -> Array:
    """Return Q rows x (Q, d) after attention to the rows ``near`` (Q, K) of ``memory`` (N, d), and two layers."""
    units = x.shape[1]
    normed = _norm(memory, weights, f"{name}.before")
    first = normed if x is memory else _norm(x, weights, f"{name}.before")
    query = linear(first, weights, f"{name}.query").reshape(-1, heads, units // heads)
    pair = linear(normed, weights, f"{name}.pair").reshape(-1, 2, heads, units // heads)[near]
    logits = np.einsum("qhd,qkhd->qhk", query, pair[:, :, 0]) / np.float32(np.sqrt(units // heads))
    logits = np.where(there[:, None], logits, np.float32(-np.inf))
    shares = np.exp(logits - logits.max(axis=-1, keepdims=True))
    shares /= shares.sum(axis=-1, keepdims=True)
    mixed = np.einsum("qhk,qkhd->qhd", shares, pair[:, :, 1]).reshape(-1, units)
    x = x + linear(mixed, weights, f"{name}.out")
    hidden = np.maximum(linear(_norm(x, weights, f"{name}.between"), weights, f"{name}.wide"), 0.0)
    return np.asarray(x + linear(hidden, weights, f"{name}.narrow"))


def write_weights(path: Path, loaded: Loaded) -> None:
    """Write weights with the settings that flying them needs."""
    about = {"network": loaded.network.model_dump(), "graph": loaded.graph.model_dump()}
    write_weights_file(path, loaded.weights, about)


@read_once
def load_weights(path: Path) -> Loaded:
    """Return the content of a weights file; a process reads the file once, and again when it changes.

    Raises:
        InputError: the file is missing or holds another network.

    """
    file = read_weights_file(path, "attention-sac")
    network, graph = file.described(
        lambda about: (NetworkSettings(**about["network"]), GraphSettings(**about["graph"]))
    )
    return Loaded(file.checked(shapes(FEATURES, network)), network, graph)
