"""Layers of small networks, compiled: for one input at a time, with a fixed order of additions.

A matrix library may change the order of additions with the batch size or the number of threads. Here outputs are the
same, bit for bit, in any batch, process and engine, and need no torch.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel


def as_layer(array: NDArray[Any]) -> NDArray[np.float32]:
    """Return a weight (outputs, inputs, ...) or a bias (outputs,) of torch as these layers take it.

    Matrices are then (inputs, outputs), kernels of convolutions (rows, columns, inputs, filters).
    """
    axes = (*range(2, array.ndim), 1, 0) if array.ndim > 1 else (0,)
    return np.ascontiguousarray(array.transpose(axes), np.float32)


@kernel(entry=False)
def linear(x: np.ndarray, weight: np.ndarray, bias: np.ndarray, out: np.ndarray) -> None:
    """Write x W + b to ``out`` (M,), for x (N,), W (N, M) and b (M,), float32; zero inputs are skipped."""
    for j in range(out.shape[0]):
        out[j] = bias[j]
    for i in range(x.shape[0]):
        value = x[i]
        if value != 0.0:
            for j in range(out.shape[0]):
                out[j] += value * weight[i, j]


@kernel(entry=False)
def relu(x: np.ndarray) -> None:
    """Apply max(x, 0) to x (N,) float32 in place."""
    for j in range(x.shape[0]):
        x[j] = max(x[j], np.float32(0.0))


@kernel()
def perceptron(
    x: np.ndarray,
    first: np.ndarray,
    first_bias: np.ndarray,
    second: np.ndarray,
    second_bias: np.ndarray,
    out: np.ndarray,
    out_bias: np.ndarray,
) -> np.ndarray:
    """Return the outputs (M,) of two hidden layers, each with ReLU, and a linear one, for x (N,); all float32."""
    one, two = np.empty(first_bias.shape[0], np.float32), np.empty(second_bias.shape[0], np.float32)
    outputs = np.empty(out_bias.shape[0], np.float32)
    linear(x, first, first_bias, one)
    relu(one)
    linear(one, second, second_bias, two)
    relu(two)
    linear(two, out, out_bias, outputs)
    return outputs


@kernel(entry=False)
def layer_norm(x: np.ndarray, scale: np.ndarray, shift: np.ndarray) -> None:
    """Apply layer normalisation (Ba et al. 2016) to x (N,) float32 in place."""
    mean = variance = 0.0
    for j in range(x.shape[0]):
        mean += x[j]
    mean /= x.shape[0]
    for j in range(x.shape[0]):
        variance += (x[j] - mean) ** 2
    spread = 1.0 / np.sqrt(variance / x.shape[0] + 1e-5)
    for j in range(x.shape[0]):
        x[j] = np.float32((x[j] - mean) * spread) * scale[j] + shift[j]


@kernel(entry=False)
def _add_eight(
    x: np.ndarray, places: np.ndarray, shifts: np.ndarray, weight: np.ndarray, first: int, out: np.ndarray
) -> None:
    """Add the products of eight inputs, from ``first`` on, to the sums of all P places, (P, filters).

    One input after the other, as if each was added by itself; but sums are loaded and stored once for eight.
    """
    w0, w1, w2, w3 = weight[first], weight[first + 1], weight[first + 2], weight[first + 3]
    w4, w5, w6, w7 = weight[first + 4], weight[first + 5], weight[first + 6], weight[first + 7]
    s0, s1, s2, s3 = shifts[first], shifts[first + 1], shifts[first + 2], shifts[first + 3]
    s4, s5, s6, s7 = shifts[first + 4], shifts[first + 5], shifts[first + 6], shifts[first + 7]
    for p in range(out.shape[0]):
        at, total = places[p], out[p]
        x0, x1, x2, x3 = x[at + s0], x[at + s1], x[at + s2], x[at + s3]
        x4, x5, x6, x7 = x[at + s4], x[at + s5], x[at + s6], x[at + s7]
        for f in range(out.shape[1]):
            half = (((total[f] + x0 * w0[f]) + x1 * w1[f]) + x2 * w2[f]) + x3 * w3[f]
            total[f] = (((half + x4 * w4[f]) + x5 * w5[f]) + x6 * w6[f]) + x7 * w7[f]


@kernel(entry=False)
def convolved(x: np.ndarray, weight: np.ndarray, bias: np.ndarray, stride: int) -> np.ndarray:
    """Return ReLU of the convolution of ``x`` (H, W, C), without padding.

    ``weight`` is (rows, columns, inputs, filters).
    """
    side, inputs, filters = weight.shape[0], weight.shape[2], weight.shape[3]
    rows, cols = (x.shape[0] - side) // stride + 1, (x.shape[1] - side) // stride + 1
    line, run = x.shape[1] * inputs, side * inputs
    places, shifts = np.empty(rows * cols, np.uint64), np.empty(side * run, np.uint64)
    for k in range(shifts.shape[0]):
        shifts[k] = k // run * line + k % run
    out = np.empty((rows * cols, filters), np.float32)
    for p in range(rows * cols):
        places[p] = p // cols * stride * line + p % cols * stride * inputs
        out[p] = bias
    flat, matrix = x.reshape(x.size), weight.reshape((side * run, filters))
    together = side * run // 8 * 8
    for first in range(0, together, 8):
        _add_eight(flat, places, shifts, matrix, first, out)
    for k in range(together, side * run):
        for p in range(rows * cols):
            for f in range(filters):
                out[p, f] += flat[places[p] + shifts[k]] * matrix[k, f]
    relu(out.reshape(out.size))
    return out.reshape((rows, cols, filters))
