"""The dueling network for acting, with the pull of the tours, compiled: row by row, with a fixed order of additions.

A matrix library may change the order of additions with the batch size or the number of threads, which can decide
ties between moves differently. Here decisions are the same, bit for bit, in any batch, process and engine, and acting
needs no torch. Tests compare it with :class:`indoor_explorers.learners.dddqn.network.model.DuelingNetwork`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.encoding import (
    AttentionWeights,
    BlockWeights,
    ConvolutionWeights,
    apply_blocks,
    encode,
    encoded_size,
    encoder_shapes,
    encoder_weights,
)
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout, search_costs, tour_costs
from indoor_explorers.planners.toolbox.networks.layers import as_layer, layer_norm, linear, relu

Array = NDArray[np.float32]


class NetworkWeights(NamedTuple):
    """The network's arrays; matrices are (inputs, outputs). Arrays of disabled parts are empty."""

    look: Array
    look_bias: Array
    look_scale: Array
    look_shift: Array
    think: Array
    think_bias: Array
    think_scale: Array
    think_shift: Array
    value: Array
    value_bias: Array
    advantage: Array
    advantage_bias: Array
    move_hidden: Array
    move_hidden_bias: Array
    move_out: Array
    move_out_bias: Array
    tours: Array
    layer_norm: bool
    dueling: bool
    crop: int
    frames: int
    convolution: ConvolutionWeights
    attention: AttentionWeights
    blocks: BlockWeights


def shapes(layout: ObservationLayout, config: NetworkConfig) -> dict[str, tuple[int, ...]]:
    """Return names and shapes of the network's arrays as torch stores them: (outputs, inputs)."""
    joined = config.width + 4 * layout.features
    linear = {"look": (config.width, encoded_size(layout, config)), "think": (config.width, joined)}
    if config.dueling:
        linear["value"] = (1, config.width)
    linear["advantage"] = (4, config.width)
    if tour_costs(layout, config.tour_cost, config.tour_cost) is not None:
        linear["tours"] = (1, layout.features)
    linear |= {"move_hidden": (config.move_width, layout.features), "move_out": (1, config.move_width)}
    found = encoder_shapes(layout, config)
    for name, shape in linear.items():
        found |= {f"{name}.weight": shape} | ({} if name == "tours" else {f"{name}.bias": shape[:1]})
        if config.layer_norm and name in ("look", "think"):
            found |= {f"{name}_norm.weight": shape[:1], f"{name}_norm.bias": shape[:1]}
    return found


def weights_from(
    arrays: Mapping[str, NDArray[Any]], layout: ObservationLayout, config: NetworkConfig
) -> NetworkWeights:
    """Arrange the arrays of :func:`shapes`, (outputs, inputs) or (outputs,), for acting."""
    matrices = ("think", "value", "advantage", "move_hidden", "move_out")
    names = ["look.weight", "look.bias", "look_norm.weight", "look_norm.bias"]
    for name in matrices:
        names += [f"{name}.weight", f"{name}.bias"]
        names += [f"{name}_norm.weight", f"{name}_norm.bias"] * (name == "think")
    there = shapes(layout, config)
    empty = {name: np.zeros((0, 0) if name == "value.weight" else 0, np.float32) for name in names if name not in there}
    found: list[Any] = [as_layer({**arrays, **empty}[name]) for name in names]
    found += [_tours(arrays, layout, config), config.layer_norm, config.dueling, layout.crop, layout.frames]
    return NetworkWeights._make([*found, *encoder_weights(arrays, config)])


def _tours(arrays: Mapping[str, NDArray[Any]], layout: ObservationLayout, config: NetworkConfig) -> Array:
    """Return the linear weights (F,) from a move's features to its value: learned ones plus the pull of the tours."""
    parts = [arrays["tours.weight"][0]] if "tours.weight" in arrays else []
    pull = tour_costs(layout, config.tour_pull, 0.0, kinds=config.kinds)
    parts += [] if pull is None else [pull]
    return np.sum(parts, axis=0, dtype=np.float32) if parts else np.zeros(0, np.float32)


def without_network(weights: NetworkWeights, layout: ObservationLayout) -> NetworkWeights:
    """Return weights whose values are the costs of the planner features alone: steps, then delay beyond the best.

    Raises :class:`InputError` if the observation has no planner features.
    """
    costs = search_costs(layout)
    if costs is None:
        raise InputError("expected weights with planner features where the network is off, got weights without any")
    zeros = [np.zeros_like(part) if isinstance(part, np.ndarray) else part for part in weights]
    return NetworkWeights._make(zeros)._replace(tours=costs)


@kernel(entry=False)
def _own_values(moves: np.ndarray, weights: NetworkWeights, out: np.ndarray) -> None:
    """Add the output of the network that the moves share, and of the linear weights of their features."""
    hidden = np.empty(weights.move_hidden.shape[1], np.float32)
    for k in range(4):
        linear(moves[k], weights.move_hidden, weights.move_hidden_bias, hidden)
        total = weights.move_out_bias[0]
        for j in range(hidden.shape[0]):
            total += max(hidden[j], np.float32(0.0)) * weights.move_out[j, 0]
        for i in range(weights.tours.shape[0]):
            total += moves[k, i] * weights.tours[i]
        out[k] += total


@kernel()
def q_values(scenes: np.ndarray, moves: np.ndarray, weights: NetworkWeights, q: np.ndarray) -> None:
    """Write the values ``q`` (B, 4) of scenes (B, inputs) uint8 and move features (B, 4, features) float32."""
    width, features = weights.look.shape[1], moves.shape[2]
    look, think = np.empty(width, np.float32), np.empty(width, np.float32)
    pixels = np.empty(scenes.shape[1], np.float32)
    encoding = weights.convolution.near.size + weights.attention.patch.size > 0
    code = np.empty(weights.look.shape[0], np.float32) if encoding else pixels
    joined = np.empty(width + 4 * features, np.float32)
    value = np.empty(1, np.float32)
    for b in range(scenes.shape[0]):
        for i in range(pixels.shape[0]):
            pixels[i] = scenes[b, i] * np.float32(1.0 / 255.0)
        if encoding:
            encode(pixels, weights.crop, weights.frames, weights.convolution, weights.attention, code)
        linear(code, weights.look, weights.look_bias, look)
        apply_blocks(look, weights.blocks)
        if weights.layer_norm:
            layer_norm(look, weights.look_scale, weights.look_shift)
        relu(look)
        for i in range(width):
            joined[i] = look[i]
        for k in range(4):
            for i in range(features):
                joined[width + k * features + i] = moves[b, k, i]
        linear(joined, weights.think, weights.think_bias, think)
        if weights.layer_norm:
            layer_norm(think, weights.think_scale, weights.think_shift)
        relu(think)
        linear(think, weights.advantage, weights.advantage_bias, q[b])
        _own_values(moves[b], weights, q[b])
        if weights.dueling:
            linear(think, weights.value, weights.value_bias, value)
            mean = (q[b, 0] + q[b, 1] + q[b, 2] + q[b, 3]) / np.float32(4.0)
            for k in range(4):
                q[b, k] += value[0] - mean
