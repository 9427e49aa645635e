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
    logits = np.empty(near.shape[1], np.float32)
    for q in range(rows):
        for first in range(0, units, size):
            asked, found = query[q, first : first + size], out[q, first : first + size]
            most, total = np.float32(-1e30), np.float32(0.0)
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    key, logit = pair[near[q, k], first : first + size], np.float32(0.0)
                    for u in range(size):
                        logit += asked[u] * key[u]
                    logits[k] = logit * scale
                    most = max(most, logits[k])
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    logits[k] = math.exp(logits[k] - most)
                    total += logits[k]
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    share, value = logits[k] / total, pair[near[q, k], units + first : units + first + size]
                    shares[q, k, first // size] = share
                    for u in range(size):
                        found[u] += share * value[u]
    return out, shares


@kernel(fastmath=True)
def _gradients(
    gradient: np.ndarray, query: np.ndarray, pair: np.ndarray, near: np.ndarray, shares: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the gradients of query and pair from that of the found rows (Q, d)."""
    rows, units = query.shape
    size = units // shares.shape[2]
    scale = np.float32(1.0 / math.sqrt(size))
    of_query, of_pair = np.zeros(query.shape, np.float32), np.zeros(pair.shape, np.float32)
    of_share = np.empty(near.shape[1], np.float32)
    for q in range(rows):
        for first in range(0, units, size):
            keys, values = slice(first, first + size), slice(units + first, units + first + size)
            given, asked, of_asked = gradient[q, keys], query[q, keys], of_query[q, keys]
            mean = np.float32(0.0)
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    share, found = shares[q, k, first // size], np.float32(0.0)
                    value, of_value = pair[near[q, k], values], of_pair[near[q, k], values]
                    for u in range(size):
                        found += given[u] * value[u]
                        of_value[u] += share * given[u]
                    of_share[k] = found
                    mean += found * share
            for k in range(near.shape[1]):
                if near[q, k] >= 0:
                    of_logit = shares[q, k, first // size] * (of_share[k] - mean) * scale
                    key, of_key = pair[near[q, k], keys], of_pair[near[q, k], keys]
                    for u in range(size):
                        of_asked[u] += of_logit * key[u]
                        of_key[u] += of_logit * asked[u]
    return of_query, of_pair
