"""Layers of small networks, compiled: for one input at a time, with a fixed order of additions.

A matrix library may change the order of additions with the batch size or the number of threads. Here outputs are the
same, bit for bit, in any batch, process and engine, and need no torch.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.compiled import kernel


@kernel(entry=False)
def linear(x: np.ndarray, weight: np.ndarray, bias: np.ndarray, out: np.ndarray) -> None:
    """Write x W + b; zero inputs are skipped."""
    for j in range(out.shape[0]):
        out[j] = bias[j]
    for i in range(x.shape[0]):
        value = x[i]
        if value != 0.0:
            for j in range(out.shape[0]):
                out[j] += value * weight[i, j]


@kernel(entry=False)
def relu(x: np.ndarray) -> None:
    """Apply max(x, 0) in place."""
    for j in range(x.shape[0]):
        x[j] = max(x[j], np.float32(0.0))


@kernel(entry=False)
def convolved(x: np.ndarray, weight: np.ndarray, bias: np.ndarray, stride: int) -> np.ndarray:
    """Return ReLU of the convolution of ``x`` (H, W, C), without padding; zero inputs are skipped.

    ``weight`` is (rows, columns, inputs, filters).
    """
    side, filters = weight.shape[0], weight.shape[3]
    rows, cols = (x.shape[0] - side) // stride + 1, (x.shape[1] - side) // stride + 1
    out = np.empty((rows, cols, filters), np.float32)
    for i in range(rows):
        for j in range(cols):
            total = out[i, j]
            total[:] = bias
            for a in range(side):
                for b in range(side):
                    for c in range(x.shape[2]):
                        seen = x[i * stride + a, j * stride + b, c]
                        if seen != 0.0:
                            for f in range(filters):
                                total[f] += seen * weight[a, b, c, f]
            for f in range(filters):
                total[f] = max(total[f], np.float32(0.0))
    return out
