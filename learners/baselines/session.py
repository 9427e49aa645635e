"""A training as its user meets it: progress to look at, and a Ctrl-C that loses nothing."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

from indoor_explorers.learners.baselines.trial import Trial


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a training is."""

    steps: int
    """Moves made, all environments together."""
    total_steps: int
    """Moves to make."""
    epsilon: float | None
    """Probability of a random move now; None for learners that draw from their policy."""
    loss: float
    """The library's latest loss; not a number before the first update."""
    steps_per_second: float
    """Moves a second since the training was started or resumed, evaluations included."""
    trial: Trial | None
    """The latest evaluation."""


@contextmanager
def one_thread() -> Iterator[None]:
    """Run torch on one thread: the same sums in the same order, and no slower for small networks."""
    import torch  # loads when it is used, and not to list the policies

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


@contextmanager
def patience() -> Iterator[threading.Event]:
    """Turn the first Ctrl-C into an event, so that an update is never cut in half; a second one stops at once."""
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
