"""Damage of a store, and how a refusal names it."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import one_line
from indoor_explorers.evaluation.harness.experiment.experiment import Task

#: Errors of reading a damaged row.
UNREADABLE = (ValueError, KeyError, TypeError, AttributeError, OverflowError, MemoryError, RecursionError, zlib.error)
#: The way out where a store cannot be mended.
REPLACE = "replace it by a copy, or use another folder"
NO_CHECKSUM = "it does not match its checksum"


class Damage(NamedTuple):
    """A damaged episode."""

    rowid: int
    policy: str
    task: Task
    why: str

    def __str__(self) -> str:
        """Name the episode and what is wrong with it."""
        scenario, index, seed = self.task
        return f"policy {self.policy!r}, scenario {scenario!r}, map {index}, seed {seed}: {self.why}"


def damaged(path: Path, what: object, remedy: str = REPLACE) -> InputError:
    """Return the error that a store is damaged."""
    return InputError(f"{path} is damaged: {one_line(str(what))}; {remedy}")


def damaged_episodes(path: Path, found: Sequence[Damage]) -> InputError:
    """Return the error that some episodes of a store are damaged."""
    what = f"episode of {found[0]}" if len(found) == 1 else f"{len(found)} episodes, first of {found[0]}"
    return damaged(path, what, f"the same compare command flies what is damaged again, or {REPLACE}")
