"""The uses of episode seeds: disjoint ranges, so that no policy is tested on seeds of its training or tuning.

Test sets have a number. Each is meant for the tables of one release; ``published`` counts how often figures on it were
published. STATISTICS.md has the same table.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

#: Seeds in a block. Comparisons use the first block; then each training has two, for its training episodes and for its
#: validation.
SEED_BLOCK = 2**40


class SeedUse(StrEnum):
    """The use of the episodes of a range of seeds."""

    TRIAL = "trial"
    """First looks, examples and tests of the code: no published figure."""
    TUNING = "tuning"
    """Choices of settings, of planners' parameters, and among weights."""
    TEST = "test"
    """Published figures."""
    TRAINING = "training"
    """Training episodes, and the maps that a map prior is fitted to."""
    VALIDATION = "validation"
    """Evaluations by which the best weights of a training are selected, or tuned parameters are taken or left."""


class SeedSet(NamedTuple):
    """A range of seeds with one use."""

    name: str
    use: SeedUse
    first: int
    size: int
    published: int = 0
    """Number of publications of figures of learned policies on these seeds, including every change of them."""

    @property
    def seeds(self) -> range:
        """The seeds."""
        return range(self.first, self.first + self.size)


SEED_SETS = (
    SeedSet("trials", SeedUse.TRIAL, 0, 1_000),
    SeedSet("test-2", SeedUse.TEST, 1_000, 100, published=2),
    SeedSet("test-1", SeedUse.TEST, 1_000_000, 500, published=16),
    SeedSet("test-3", SeedUse.TEST, 5_000_000, 500, published=1),
    SeedSet("test-4", SeedUse.TEST, 8_000_000, 100, published=1),
    SeedSet("tuning", SeedUse.TUNING, 9_000_000, 1_000_000, published=4),
    SeedSet("test-5", SeedUse.TEST, 20_000_000, 1_000_000, published=2),
    SeedSet("test-6", SeedUse.TEST, 21_000_000, 1_000_000, published=2),
    SeedSet("test-7", SeedUse.TEST, 22_000_000, 1_000_000, published=8),
    SeedSet("test-8", SeedUse.TEST, 23_000_000, 1_000_000, published=1),
    SeedSet("test-9", SeedUse.TEST, 24_000_000, 1_000_000),
    SeedSet("suites-train", SeedUse.TRAINING, 30_000_000, 1_000_000),
    SeedSet("suites-validation", SeedUse.VALIDATION, 31_000_000, 1_000_000),
    SeedSet("suites-test", SeedUse.TEST, 32_000_000, 1_000_000, published=3),
    SeedSet("ablation", SeedUse.TUNING, 2**39, 2**20, published=1),
    SeedSet("tune", SeedUse.TUNING, 2**39 + 2**20, 2**20),
    SeedSet("tune-fresh", SeedUse.VALIDATION, 2**39 + 2**21, 2**20, published=1),
)


def seed_set(name: str) -> SeedSet:
    """Return the set of that name."""
    return next(each for each in SEED_SETS if each.name == name)


def use_of(seeds: range) -> SeedUse | None:
    """Return the common use of some seeds; None if there is none."""
    first, last = seeds[0] // SEED_BLOCK, seeds[-1] // SEED_BLOCK
    if first != last:
        return None
    if first > 0:
        return SeedUse.TRAINING if first % 2 else SeedUse.VALIDATION
    return next((each.use for each in SEED_SETS if seeds[0] in each.seeds and seeds[-1] in each.seeds), None)


def fresh_test_set() -> SeedSet:
    """Return the first test set without published figures."""
    return next(each for each in SEED_SETS if each.use is SeedUse.TEST and not each.published)
