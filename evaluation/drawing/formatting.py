"""Formats of numbers and intervals."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

from indoor_explorers.evaluation.statistics import Estimate

MINUS, THIN_SPACE, EN_DASH = "\u2212", "\u202f", "\u2013"


def fixed(value: float | None, decimals: int, *, sign: bool = False) -> str:
    """Format with this many decimals, a real minus and thin spaces from 10 000 on; missing is a dash."""
    if value is None or math.isnan(value):
        return EN_DASH
    text = f"{abs(value):,.{decimals}f}".replace(",", THIN_SPACE if abs(value) >= 10_000 else "")
    zero = not any(digit in "123456789" for digit in text)
    return ("" if zero else MINUS if value < 0 else "+" if sign else "") + text


def decimals_for(largest: float, most: int = 1) -> int:
    """Return the number of decimals of a column with this largest value: three or four digits in all."""
    if largest >= 1000:
        return 0
    return min(most, 1 if largest >= 10 else 2)


def percent(share: float, decimals: int = 0) -> str:
    """Format a share; only 1 is ``100 %`` and only 0 is ``0 %``."""
    nearly = 100 - 10**-decimals
    value = 100 * share
    if 0 < share < 1:
        value = min(max(value, 10**-decimals), nearly)
    return f"{value:.{decimals}f}{THIN_SPACE}%"


def percent_as_given(share: float) -> str:
    """Return a share that a user gave as a percentage with the decimals that it has."""
    return f"{100 * share:g}{THIN_SPACE}%"


def interval(estimate: Estimate, decimals: int, *, sign: bool = False) -> str:
    """Format ``[low, high]``; empty without an interval."""
    if estimate.low is None:
        return ""
    return f"[{fixed(estimate.low, decimals, sign=sign)}, {fixed(estimate.high, decimals, sign=sign)}]"


def with_interval(estimate: Estimate, decimals: int = 1, *, sign: bool = False) -> str:
    """Format ``mean [low, high]``, or the mean alone."""
    return f"{fixed(estimate.mean, decimals, sign=sign)} {interval(estimate, decimals, sign=sign)}".strip()


def percent_interval(estimate: Estimate) -> str:
    """Format the interval of a share, ``[73, 98] %``; empty without one."""
    if estimate.low is None or estimate.high is None:
        return ""
    low, high = (percent(end).removesuffix(f"{THIN_SPACE}%") for end in (estimate.low, estimate.high))
    return f"[{low}, {high}]{THIN_SPACE}%"


def percent_with_interval(estimate: Estimate) -> str:
    """Format ``62 % [50 %, 70 %]``, or the share alone."""
    low, high = estimate.low, estimate.high
    return percent(estimate.mean) + ("" if low is None or high is None else f" [{percent(low)}, {percent(high)}]")


def p_value(p: float) -> str:
    """Format a p-value: ``= 0.031``, or ``< 0.001``."""
    return "< 0.001" if p < 0.001 else f"= {p:.3f}"


def counted(number: int, noun: str) -> str:
    """Return ``1 episode``, ``2 episodes``."""
    plural = noun[:-1] + "ies" if noun.endswith("y") else noun + "s"
    return f"{number} {noun if number == 1 else plural}"


def joined(names: Sequence[str]) -> str:
    """Return ``a``, ``a and b``, ``a, b and c``."""
    return " and ".join(part for part in (", ".join(names[:-1]), *names[-1:]) if part)


def span(values: Iterable[int]) -> str:
    """Return ``3``, or ``3 to 8`` from the smallest to the largest; empty without any."""
    found = sorted(set(values))
    return " to ".join(map(str, dict.fromkeys(found[:1] + found[-1:])))


def seed_span(seeds: Iterable[int]) -> str:
    """Return ``seed 3``, ``seeds 0 to 29``, ``seeds 1000000 + 0..29``; empty without any."""
    found = sorted(set(seeds))
    if len(found) < 2:
        return "".join(f"seed {seed}" for seed in found)
    base = seed_base(found)
    return f"seeds {base} + {found[0] - base}..{found[-1] - base}" if base else f"seeds {found[0]} to {found[-1]}"


def seed_base(seeds: Sequence[int]) -> int:
    """Return the whole thousands that large seeds have in common; 0 if they have none."""
    thousands = {seed // 1000 for seed in seeds}
    return 1000 * thousands.pop() if len(thousands) == 1 else 0


def slug(name: str) -> str:
    """Return a name as part of a file name: small letters, digits and hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:60] or "scenario"
