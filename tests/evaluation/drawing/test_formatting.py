"""Seeds and lists of names in words."""

import pytest

from indoor_explorers.evaluation.drawing.formatting import joined, seed_span
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.report.records import made_up, results_of
from tests.evaluation.reports import Page


@pytest.mark.parametrize(
    ("seeds", "text"),
    [
        ([], ""),
        ([3], "seed 3"),
        ([2, 0, 1, 1], "seeds 0 to 2"),
        (range(1_000_000, 1_000_030), "seeds 1000000 + 0..29"),
        (range(1_000_500, 1_000_530), "seeds 1000000 + 500..529"),
        (range(1_000_990, 1_001_010), "seeds 1000990 to 1001009"),
    ],
)
def test_large_seeds_are_counted_from_their_thousands(seeds, text):
    assert seed_span(seeds) == text


def test_the_table_by_seed_names_what_its_seeds_are_counted_from():
    records = [
        made_up(name, Task("room", 0, 1_000_000 + seed), late + seed)
        for name, late in (("a", 10), ("b", 12))
        for seed in range(6)
    ]
    text = Page(render(results_of(records))).text
    assert "seeds 1000000 + 0..5" in text
    assert "seed 1000000 +" in " ".join(text.split())


def test_names_are_joined_as_in_a_sentence():
    assert [joined(list(names)) for names in ("", "a", "ab", "abc")] == ["", "a", "a and b", "a, b and c"]
