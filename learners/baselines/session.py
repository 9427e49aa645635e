"""A training as its user meets it: progress to look at."""

from __future__ import annotations

from dataclasses import dataclass

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
