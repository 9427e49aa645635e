"""Checks what pilots tell about an episode, since it becomes columns of every table."""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping, Sequence

import numpy as np

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import one_line

#: Limits of a tally: names, and characters of a name.
MOST_NAMES, LONGEST_NAME = 64, 64
#: What the names of these statistics begin with in records.
PREFIX = "pilot_"


def mean_tallies(tallies: Sequence[object]) -> dict[str, float | None]:
    """Return the means of the UAVs' tallies by name, with the prefix of records.

    Raises:
        InputError: one is not a dict of finite numbers by short names, or there are too many names.

    """
    checked = [_checked(tally) for tally in tallies]
    names = sorted({name for tally in checked for name in tally})
    if len(names) > MOST_NAMES:
        raise InputError(f"expected at most {MOST_NAMES} names in the tallies of a team, got {len(names)}")
    return {PREFIX + name: float(np.mean([tally[name] for tally in checked if name in tally])) for name in names}


def _checked(tally: object) -> dict[str, float]:
    if not isinstance(tally, Mapping):
        raise InputError(f"expected tally() to return a dict, got {type(tally).__name__}")
    if len(tally) > MOST_NAMES:
        raise InputError(f"expected at most {MOST_NAMES} names in a tally, got {len(tally)}")
    return dict(_entry(name, value) for name, value in tally.items())


def _entry(name: object, value: object) -> tuple[str, float]:
    if not isinstance(name, str) or not name.isprintable() or not 0 < len(name) <= LONGEST_NAME:
        shown = one_line(repr(name), LONGEST_NAME)
        raise InputError(f"expected names of a tally to be texts of 1 to {LONGEST_NAME} characters, got {shown}")
    if not isinstance(value, numbers.Real) or not math.isfinite(number := float(value)):
        raise InputError(f"expected tally {name!r} to be a finite number, got {one_line(repr(value), LONGEST_NAME)}")
    return str(name), number
