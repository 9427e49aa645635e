"""The published policy networks in numpy, by the layers of :mod:`indoor_explorers.learners.attention.network`."""

from __future__ import annotations

import numpy as np

from indoor_explorers.learners.attention.network import Array, Weights, decoded, encoded, linear, pointed
from indoor_explorers.learners.published.checkpoint import Sizes
from indoor_explorers.learners.published.sighted import Directions, Observation


def scores(seen: Observation, weights: Weights, sizes: Sizes) -> Array:
    """Return the scores (M,) of the nodes to choose from, or (M, 3) of each of them with three headings."""
    x = encoded(seen.features, seen.near, weights, sizes.layers, sizes.heads)
    looks = seen.directions
    if looks is not None:
        x = linear(
            np.concatenate([x, _convolved(looks.frontiers, weights)], axis=1), weights, "node_frontiers_embedding"
        )
    state, options = decoded(x, seen.own, weights, sizes.heads), x[np.maximum(seen.options, 0)]
    if looks is not None:
        options = _with_headings(options, looks, seen, weights)
    found = pointed(state, options.reshape(-1, sizes.units), weights)
    return found.reshape(options.shape[:-1])


def _convolved(rows: Array, weights: Weights) -> Array:
    """Return the convolution of width 3 over (N, C) rows, (N, units), with zeros before and after them."""
    kernel = weights["frontiers_embedding.weight"]
    padded = np.pad(rows, ((1, 1), (0, 0)))
    parts = (padded[k : k + len(rows)] @ kernel[:, :, k].T for k in range(3))
    return np.asarray(sum(parts, weights["frontiers_embedding.bias"]))


def _with_headings(options: Array, looks: Directions, seen: Observation, weights: Weights) -> Array:
    """Return the embeddings (M, 3, units) of nodes (M, units) to choose from with each of three headings."""
    visited = linear(looks.visited[seen.options], weights, "visited_headings_embedding")
    headings = linear(looks.headings, weights, "best_headings_embedding")
    both = np.repeat(np.concatenate([options, visited], axis=1)[:, None], headings.shape[1], axis=1)
    return linear(np.concatenate([both, headings], axis=2), weights, "neighboring_node_embedding")
