"""Ranges of seeds: disjoint, and as the document has them."""

import re
from itertools import pairwise
from pathlib import Path

import pytest

from indoor_explorers.env.scenarios.seed_sets import SEED_BLOCK, SEED_SETS, SeedUse, fresh_test_set, seed_set, use_of

STATISTICS = Path(__file__).parents[3] / "evaluation" / "STATISTICS.md"


def test_no_seed_has_two_uses_and_none_is_in_a_trainings_block():
    ordered = sorted(SEED_SETS, key=lambda each: each.first)
    assert all(one.seeds.stop <= other.first for one, other in pairwise(ordered))
    assert ordered[-1].seeds.stop <= SEED_BLOCK
    assert len({each.name for each in SEED_SETS}) == len(SEED_SETS)


def test_the_document_has_the_same_sets():
    rows = re.findall(r"^\| `([\w-]+)` \| (.+?) to (.+?) \| (\w+) \| (\d+) \| ", STATISTICS.read_text(), re.MULTILINE)
    told = {name: (number(first), number(last), use, int(count)) for name, first, last, use, count in rows}
    assert told == {each.name: (each.first, each.seeds[-1], str(each.use), each.published) for each in SEED_SETS}


def number(text: str) -> int:
    return int(eval(text.replace(",", "").replace("^", "**"), {}))


@pytest.mark.parametrize(
    ("seeds", "use"),
    [
        (range(1_000_000, 1_000_500), SeedUse.TEST),
        (range(1_000_000, 1_000_501), None),
        (range(10), SeedUse.TRIAL),
        (range(9_100_000, 9_100_024), SeedUse.TUNING),
        (range(SEED_BLOCK, SEED_BLOCK + 9), SeedUse.TRAINING),
        (range(2 * SEED_BLOCK, 2 * SEED_BLOCK + 9), SeedUse.VALIDATION),
        (range(2 * SEED_BLOCK - 1, 2 * SEED_BLOCK + 1), None),
    ],
)
def test_the_use_of_seeds(seeds: range, use: SeedUse | None):
    assert use_of(seeds) is use


def test_the_next_release_has_a_test_set_that_nothing_was_published_on():
    assert fresh_test_set().published == 0
    assert fresh_test_set().use is SeedUse.TEST
    assert fresh_test_set().size >= seed_set("test-1").size
