"""Attention of each row to few others, compiled.

Torch has to gather all keys and values first, or to compute every pair of rows: updates then take twice as long.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.autograd.function import once_differentiable

from indoor_explorers.env.grid.compiled import kernel


def attention(query: Tensor, pair: Tensor, near: Tensor, heads: int) -> Tensor:
    """Return what each row of ``query`` (Q, d) finds by scaled dot-product attention to the rows ``near``, (Q, d).

    Args:
        query: (Q, d) float32.
        pair: (T, 2 d) float32, keys and values.
        near: (Q, K) int32 rows of ``pair``; negative for none; at least one a row.
        heads: Number of heads.

    """
    found: Tensor = _Attention.apply(query, pair, near, heads)  # type: ignore[no-untyped-call]  # as torch declares it
    return found


class _Attention(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, query: Tensor, pair: Tensor, near: Tensor, heads: int) -> Tensor:
        """Return the found rows; keep the shares of attention for the gradient."""
        out, shares = _attend(query.detach().numpy(), pair.detach().numpy(), near.numpy(), heads)
        ctx.save_for_backward(query, pair, near, torch.from_numpy(shares))
        return torch.from_numpy(out)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor, Tensor, None, None]:
        """Return the gradients of query and pair."""
        query, pair, near, shares = (each.detach().numpy() for each in ctx.saved_tensors)
        of_query, of_pair = _gradients(gradient.contiguous().numpy(), query, pair, near, shares)
        return torch.from_numpy(of_query), torch.from_numpy(of_pair), None, None


@kernel(fastmath=True)
def _attend(query: np.ndarray, pair: np.ndarray, near: np.ndarray, heads: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (Q, d) found rows and (Q, K, heads) shares of attention."""
    rows, units = query.shape
    size, scale = units // heads, np.float32(1.0 / math.sqrt(units // heads))
    out, shares = np.zeros((rows, units), np.float32), np.zeros((rows, near.shape[1], heads), np.float32)
    for q in range(rows):
        for h in range(heads):
            first, most, total = h * size, np.float32(-1e30), np.float32(0.0)
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    logit = np.float32(0.0)
                    for u in range(first, first + size):
                        logit += query[q, u] * pair[near[q, k], u]
                    shares[q, k, h] = logit * scale
                    most = max(most, shares[q, k, h])
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    shares[q, k, h] = math.exp(shares[q, k, h] - most)
                    total += shares[q, k, h]
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    shares[q, k, h] /= total
                    for u in range(first, first + size):
                        out[q, u] += shares[q, k, h] * pair[near[q, k], units + u]
    return out, shares


@kernel(fastmath=True)
def _gradients(
    gradient: np.ndarray, query: np.ndarray, pair: np.ndarray, near: np.ndarray, shares: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the gradients of query and pair from that of the found rows (Q, d)."""
    rows, units = query.shape
    heads = shares.shape[2]
    size, scale = units // heads, np.float32(1.0 / math.sqrt(units // heads))
    of_query, of_pair = np.zeros(query.shape, np.float32), np.zeros(pair.shape, np.float32)
    of_share = np.empty(near.shape[1], np.float32)
    for q in range(rows):
        for h in range(heads):
            first, mean = h * size, np.float32(0.0)
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    found = np.float32(0.0)
                    for u in range(first, first + size):
                        found += gradient[q, u] * pair[near[q, k], units + u]
                        of_pair[near[q, k], units + u] += shares[q, k, h] * gradient[q, u]
                    of_share[k] = found
                    mean += found * shares[q, k, h]
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    of_logit = shares[q, k, h] * (of_share[k] - mean) * scale
                    for u in range(first, first + size):
                        of_query[q, u] += of_logit * pair[near[q, k], u]
                        of_pair[near[q, k], u] += of_logit * query[q, u]
    return of_query, of_pair
