"""Where the episode seeds of a training come from: each training has a block of its own, which nothing else uses."""

from __future__ import annotations

from indoor_explorers.env.errors import InputError

#: Seeds in a block. The first block is left to comparisons; then each training has two: one to learn from and one for
#: its evaluations.
SEED_BLOCK = 2**40
#: Seeds of trainings, so that no episode's seed outgrows 63 bits.
MOST_SEEDS = 2**20


def training_seeds(seed: int) -> int:
    """Return where the episode seeds of a training begin.

    Raises:
        InputError: there are no seeds for such a training.

    """
    if not 0 <= seed < MOST_SEEDS:
        raise InputError(f"expected a seed from 0 to {MOST_SEEDS - 1}, got {seed}")
    return SEED_BLOCK * (1 + 2 * seed)


def prior_seeds(seed: int) -> int:
    """Return where the seeds of the maps that the map prior is fitted to begin: the last quarter of the training's."""
    return training_seeds(seed) + 3 * SEED_BLOCK // 4


def evaluation_seeds(seed: int) -> int:
    """Return where the episode seeds of a training's evaluations begin."""
    return training_seeds(seed) + SEED_BLOCK
