"""A family of comparisons with one baseline."""

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import (
    contrasts,
    effect_size,
    holm,
    paired_difference,
    probability_of_improvement,
    sign_flip_test,
    smallest_detectable_difference,
    win_tie_loss,
)


def flown(count=40):
    rng = np.random.default_rng(1)
    base = rng.normal(100, 30, count)
    return {
        "same": base + rng.normal(0, 5, count),
        "base": base,
        "better": base - 4 + rng.normal(0, 5, count),
        "worse": base + 8 + rng.normal(0, 5, count),
    }


@pytest.mark.parametrize("maps", [None, np.arange(40) // 4, np.arange(40) // 20])
def test_a_contrast_holds_what_each_statistic_says_alone(maps):
    values = flown()
    found = contrasts(values, "base", maps=maps)
    assert list(found) == ["same", "better", "worse"]
    p_values = [sign_flip_test(values[name] - values["base"], maps) for name in found]
    for name, adjusted, contrast in zip(found, holm(p_values), found.values(), strict=True):
        pair = values[name], values["base"]
        assert list(contrast.difference) == pytest.approx(list(paired_difference(*pair, maps=maps)))
        assert list(contrast.improvement) == pytest.approx(list(probability_of_improvement(*pair, maps=maps)))
        assert contrast.tally == win_tie_loss(*pair)
        assert contrast.effect_size == effect_size(pair[0] - pair[1])
        detectable = smallest_detectable_difference(pair[0] - pair[1], level=0.05 / 3, maps=maps)
        assert contrast.detectable == pytest.approx(detectable)
        assert contrast.adjusted_p == adjusted >= contrast.p_value
        assert contrast.pairs == 40


def test_planted_differences_are_shown_and_no_other():
    found = contrasts(flown(), "base")
    assert [name for name, contrast in found.items() if contrast.shown] == ["better", "worse"]
    assert found["better"].improvement.mean > 0.7
    assert found["worse"].difference.low > 0
    assert found["same"].detectable < 4


def test_what_was_not_shown_alone_is_not_shown_in_a_family():
    values = {"base": np.zeros(6), "one": np.array([1.0, 2, 3, 4, 5, 6])}
    assert contrasts(values, "base")["one"].shown
    values["other"] = np.array([1.0, -2, 3, -4, 5, -6])
    assert not contrasts(values, "base")["one"].shown
    assert contrasts(values, "base")["one"].p_value == 2 / 64
    assert contrasts(values, "base")["one"].detectable == np.inf


def test_a_contrast_says_what_it_is_about():
    over = contrasts(flown(), "base", maps=np.arange(40) // 4)["same"]
    on = contrasts(flown(), "base", maps=np.arange(40) // 20)["same"]
    assert (over.maps, over.over_maps) == (10, True)
    assert (on.maps, on.over_maps) == (2, False)
    assert contrasts(flown(), "base")["same"].maps == 40


def test_where_more_is_better_the_sides_change():
    values = flown()
    less, more = contrasts(values, "base"), contrasts(values, "base", lower_is_better=False)
    assert less["better"].tally == more["better"].tally[::-1]
    assert less["better"].improvement.mean + more["better"].improvement.mean == pytest.approx(1)
    assert less["better"].difference == more["better"].difference


def test_a_baseline_alone_is_compared_with_nothing():
    assert contrasts({"base": [1.0, 2.0]}, "base") == {}


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(InputError, match="did you mean 'base'"):
        contrasts(flown(), "bass")
    with pytest.raises(InputError, match="2 and 1"):
        contrasts({"base": [1.0], "other": [1.0, 2.0]}, "base")
    with pytest.raises(InputError, match="at least one paired difference"):
        contrasts({"base": [], "other": []}, "base")


def test_policies_with_the_same_values_count_as_one():
    values = flown()
    alone, doubled = (
        contrasts(values, "base"),
        contrasts({**values, "copy": values["same"], "twin": values["base"]}, "base"),
    )
    assert all(doubled[name].adjusted_p == contrast.adjusted_p for name, contrast in alone.items())
    assert (doubled["copy"].adjusted_p, doubled["twin"].adjusted_p) == (alone["same"].adjusted_p, 1.0)
