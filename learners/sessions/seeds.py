"""Episode seeds of trainings: each has a block for training and one for its evaluations, which nothing else uses."""

from __future__ import annotations

import json
from pathlib import Path

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.scenarios.seed_sets import SEED_BLOCK, SeedUse

#: Number of training seeds; with this many, every episode's seed fits into 63 bits.
MOST_SEEDS = 2**20


def training_seeds(seed: int) -> int:
    """Return the first episode seed of a training.

    Raises :class:`InputError` if ``seed`` is not between 0 and :data:`MOST_SEEDS` - 1.
    """
    if not 0 <= seed < MOST_SEEDS:
        raise InputError(f"expected a seed from 0 to {MOST_SEEDS - 1}, got {seed}")
    return SEED_BLOCK * (1 + 2 * seed)


def episode_seed(first: int, number: int, maps: int) -> int:
    """Return the seed of an episode; with ``maps`` other than 0 there are that many seeds, used in turn."""
    return first + (number % maps if maps else number)


def prior_seeds(seed: int) -> int:
    """Return the first seed of the maps that the map prior is fitted to: the last quarter of the training's block."""
    return training_seeds(seed) + 3 * SEED_BLOCK // 4


def evaluation_seeds(seed: int) -> int:
    """Return the first episode seed of a training's evaluations."""
    return training_seeds(seed) + SEED_BLOCK


def recorded_seeds(path: Path) -> dict[str, list[range]]:
    """Return the episode seeds of a training by their use, from its record; empty without one.

    ``compared_on`` in a record holds the first and the last seed of rooms that former weights or settings were compared
    on.
    """
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        first, validation = training_seeds(record["seed"]), evaluation_seeds(record["seed"])
        return {
            SeedUse.TRAINING: [range(first, first + SEED_BLOCK)],
            SeedUse.VALIDATION: [range(validation, validation + record["config"]["evaluation_episodes"])],
            SeedUse.TUNING: [range(low, high + 1) for low, high in record.get("compared_on", ())],
        }
    except (OSError, ValueError, KeyError, TypeError):
        return {}
