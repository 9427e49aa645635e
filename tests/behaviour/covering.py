"""Covering arrays: few rows of settings in which every two settings meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, product
from typing import Any


def pairwise(factors: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Return rows of one level for each factor, so that each pair of levels of two factors is in some row.

    Greedy: the next row is the one, of the full product, with the most pairs that no row has yet. Most faults show with
    one setting or with two together; the full product needs many times as many rows.
    """
    rows = [dict(zip(factors, levels, strict=True)) for levels in product(*factors.values())]
    missing = {pair for row in rows for pair in combinations(row.items(), 2)}
    chosen = []
    while missing:
        best = max(rows, key=lambda row: sum(pair in missing for pair in combinations(row.items(), 2)))
        missing -= set(combinations(best.items(), 2))
        chosen.append(best)
    return chosen
