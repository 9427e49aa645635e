"""The dueling network for acting, compiled: one row at a time, in one fixed order of additions.

A matrix library may add in another order for another batch size or thread count, and a tie between two
moves then falls differently. Here a decision is the same, bit for bit, in any batch, process and engine,
and acting needs no torch. The test suite holds it against
:class:`indoor_explorers.learners.dddqn.network.DuelingNetwork`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.compiled import kernel
from indoor_explorers.learners.dddqn.observation import MOVE_FEATURES, SCENE

Array = NDArray[np.float32]
_WIDTH, _MOVE_WIDTH, _FEATURES = 256, 16, len(MOVE_FEATURES)
#: Names and shapes of the network's arrays, as torch stores them: (outputs, inputs).
SHAPES: tuple[tuple[str, tuple[int, ...]], ...] = (
    ("look.weight", (_WIDTH, SCENE)),
    ("look.bias", (_WIDTH,)),
    ("look_norm.weight", (_WIDTH,)),
    ("look_norm.bias", (_WIDTH,)),
    ("think.weight", (_WIDTH, _WIDTH + 4 * _FEATURES)),
    ("think.bias", (_WIDTH,)),
    ("think_norm.weight", (_WIDTH,)),
    ("think_norm.bias", (_WIDTH,)),
    ("value.weight", (1, _WIDTH)),
    ("value.bias", (1,)),
    ("advantage.weight", (4, _WIDTH)),
    ("advantage.bias", (4,)),
    ("move_hidden.weight", (_MOVE_WIDTH, _FEATURES)),
    ("move_hidden.bias", (_MOVE_WIDTH,)),
    ("move_out.weight", (1, _MOVE_WIDTH)),
    ("move_out.bias", (1,)),
)


class Weights(NamedTuple):
    """The network's arrays; matrices are (inputs, outputs)."""

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


def weights_from(arrays: Mapping[str, NDArray[Any]]) -> Weights:
    """Arrange the arrays of :data:`SHAPES` for acting."""
    return Weights(*(np.ascontiguousarray(arrays[name].T, np.float32) for name, _ in SHAPES))


@kernel()
def _linear(x: np.ndarray, weight: np.ndarray, bias: np.ndarray, out: np.ndarray) -> None:
    """Write x W + b; inputs that are zero cost nothing."""
    out[:] = bias
    for i in range(x.shape[0]):
        value = x[i]
        if value != 0.0:
            for j in range(out.shape[0]):
                out[j] += value * weight[i, j]


@kernel()
def _norm_relu(x: np.ndarray, scale: np.ndarray, shift: np.ndarray) -> None:
    """Apply layer normalisation (Ba et al. 2016) and ReLU in place."""
    mean = variance = 0.0
    for j in range(x.shape[0]):
        mean += x[j]
    mean /= x.shape[0]
    for j in range(x.shape[0]):
        variance += (x[j] - mean) ** 2
    spread = 1.0 / np.sqrt(variance / x.shape[0] + 1e-5)
    for j in range(x.shape[0]):
        x[j] = max(np.float32((x[j] - mean) * spread) * scale[j] + shift[j], np.float32(0.0))


@kernel()
def _own_advantages(moves: np.ndarray, weights: Weights, out: np.ndarray) -> None:
    """Add what each move's own features say to its advantage."""
    hidden = np.empty(weights.move_hidden.shape[1], np.float32)
    for k in range(4):
        _linear(moves[k], weights.move_hidden, weights.move_hidden_bias, hidden)
        total = weights.move_out_bias[0]
        for j in range(hidden.shape[0]):
            total += max(hidden[j], np.float32(0.0)) * weights.move_out[j, 0]
        out[k] += total


@kernel()
def q_values(scene: np.ndarray, moves: np.ndarray, weights: Weights, q: np.ndarray) -> None:
    """Write the values ``q`` (B, 4) of scenes (B, 696) uint8 and move features (B, 4, 8) float32."""
    width = weights.look.shape[1]
    look, think = np.empty(width, np.float32), np.empty(width, np.float32)
    pixels = np.empty(scene.shape[1], np.float32)
    joined = np.empty(width + moves.shape[1] * moves.shape[2], np.float32)
    value = np.empty(1, np.float32)
    for b in range(scene.shape[0]):
        for i in range(pixels.shape[0]):
            pixels[i] = scene[b, i] * np.float32(1.0 / 255.0)
        _linear(pixels, weights.look, weights.look_bias, look)
        _norm_relu(look, weights.look_scale, weights.look_shift)
        joined[:width] = look
        joined[width:] = moves[b].ravel()
        _linear(joined, weights.think, weights.think_bias, think)
        _norm_relu(think, weights.think_scale, weights.think_shift)
        _linear(think, weights.value, weights.value_bias, value)
        _linear(think, weights.advantage, weights.advantage_bias, q[b])
        _own_advantages(moves[b], weights, q[b])
        mean = (q[b, 0] + q[b, 1] + q[b, 2] + q[b, 3]) / np.float32(4.0)
        for k in range(4):
            q[b, k] += value[0] - mean
