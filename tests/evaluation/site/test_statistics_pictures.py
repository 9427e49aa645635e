"""The pictures of the page on statistics show what the document says of them."""

import re
from itertools import pairwise

import numpy as np
import pytest

from indoor_explorers.evaluation.site.pictures.statistics import (
    DRAWN_EPISODES,
    hold,
    intervals_on_maps,
    league,
    means_of_times,
    samples_of_curves,
    shares_of_curves,
)
from indoor_explorers.evaluation.statistics import (
    all_pairs_test,
    paired_difference,
    smallest_detectable_difference,
    tied_ranks,
)
from tests.documents import ROOT

DOCUMENT = (ROOT / "evaluation" / "STATISTICS.md").read_text("utf-8")


def test_the_policy_that_fails_looks_faster_over_its_successes_alone():
    assert means_of_times("A") == (73.75, 73.75)
    assert means_of_times("B") == (55, 77.5)


def test_where_maps_differ_intervals_over_episodes_miss_the_mean():
    shares = {drawn: hold(intervals).mean() for drawn, intervals in intervals_on_maps(DRAWN_EPISODES).items()}
    assert shares["over episodes"] < 0.8
    assert 0.92 <= shares["over maps"] <= 0.98


def test_the_band_holds_whole_curves_more_often_than_pointwise_intervals():
    one_step, all_steps, band = shares_of_curves(list(samples_of_curves())).values()
    assert 0.93 <= one_step <= 0.97
    assert all_steps + 0.1 <= band <= 0.97


def test_ranks_are_shared_and_skip_and_an_interval_is_not_what_decides():
    values = league()
    adjusted_p = all_pairs_test(values).adjusted_p
    assert all(one < other for one, other in pairwise(values.mean(axis=0)))
    assert tied_ranks(values) == [1, 1, 2, 4]
    assert adjusted_p[0, 2] <= 0.05 < min(adjusted_p[0, 1], adjusted_p[1, 2])
    assert (paired_difference(values[:, 1], values[:, 0]).low or 0) > 0


def test_the_table_of_detectable_differences():
    rows = [re.findall(rf"^\| {head} \| (.+) \|$", DOCUMENT, re.MULTILINE) for head in ("n, .+?", "difference / s")]
    counts, told = (row[0].split(" | ") for row in rows)
    for count, size in zip(counts, told, strict=True):
        values = np.random.default_rng(0).normal(0, 1, int(count))
        found = smallest_detectable_difference((values - values.mean()) / values.std(ddof=1))
        assert found == pytest.approx(np.inf if size == "none" else float(size), abs=0.005)
