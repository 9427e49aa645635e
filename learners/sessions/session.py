"""What every training does around its own loop: its folder, its progress, one thread for torch, ending at Ctrl-C."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Protocol

from indoor_explorers.env.errors import InputError


class Trial(Protocol):
    """An evaluation of greedy episodes, apart from training: a named tuple of figures."""

    def _asdict(self) -> dict[str, float]: ...


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a training is."""

    steps: int
    """Moves made, all environments together."""
    total_steps: int
    """Moves to make, as far as is known."""
    epsilon: float | None
    """Probability of a random move now; None for learners that draw from their policy."""
    loss: float
    """Mean loss since the last report, or the latest that a library tells; not a number before the first update."""
    steps_per_second: float
    """Moves a second since the training was started or resumed, evaluations included."""
    trial: Trial | None
    """The latest evaluation."""


def opened(out: Path, mark: str, *, resume: bool) -> bool:
    """Make the folder of a training; tell whether it holds one to go on with, which has the file ``mark``.

    Raises:
        InputError: it holds one that was not asked to be resumed, or cannot be made.

    """
    there = (out / mark).exists()
    if there and not resume:
        raise InputError(f"{out} already holds a training; give --resume to go on with it, or another --out")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot be made a folder for the training: {error.strerror}") from error
    return there


def passed(before: int, after: int, every: int) -> bool:
    """Tell whether a count has passed a multiple of ``every``."""
    return before // every < after // every


@contextmanager
def one_thread() -> Iterator[None]:
    """Run torch on one thread, so that sums are added in one order and equal seeds give equal weights."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


@contextmanager
def patience() -> Iterator[threading.Event]:
    """Turn the first Ctrl-C into an event, so that a step of a training is never cut in half."""
    interrupted = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield interrupted
        return

    def note(number: int, frame: FrameType | None) -> None:
        if interrupted.is_set():
            raise KeyboardInterrupt
        interrupted.set()

    previous = signal.signal(signal.SIGINT, note)
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, previous)


def noted(commits: Sequence[str | None], commit: str | None) -> list[str | None]:
    """Return the commits of the source that a training ran under, first one first, with the one it goes on under."""
    return [*commits, commit] if list(commits[-1:]) != [commit] else list(commits)
