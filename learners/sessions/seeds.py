"""Episode seeds of trainings: each training has a block of its own, which nothing else uses."""

from __future__ import annotations

from indoor_explorers.env.errors import InputError

#: Seeds in a block. Comparisons have the first block; then each training has two, one for its training episodes and one
#: for its evaluations.
SEED_BLOCK = 2**40
#: Number of training seeds; with this many, every episode's seed fits into 63 bits.
MOST_SEEDS = 2**20


def training_seeds(seed: int) -> int:
    """Return the first episode seed of a training.

    Raises:
        InputError: ``seed`` is not between 0 and :data:`MOST_SEEDS` - 1.

    """
    if not 0 <= seed < MOST_SEEDS:
        raise InputError(f"expected a seed from 0 to {MOST_SEEDS - 1}, got {seed}")
    return SEED_BLOCK * (1 + 2 * seed)


def prior_seeds(seed: int) -> int:
    """Return the first seed of the maps that the map prior is fitted to: the last quarter of the training's block."""
    return training_seeds(seed) + 3 * SEED_BLOCK // 4


def evaluation_seeds(seed: int) -> int:
    """Return the first episode seed of a training's evaluations."""
    return training_seeds(seed) + SEED_BLOCK
