"""As good within a margin: by plain t tests, in a family, and how many tasks would resolve it."""

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.evaluation.statistics import (
    Finding,
    contrasts,
    equivalence_test,
    sign_flip_test,
    significance,
    units_to_resolve,
)


def paired(ratio=1.0, noise=0.03, count=40, seed=1):
    rng = np.random.default_rng(seed)
    tasks = rng.lognormal(4, 0.4, count)
    return tasks * (ratio + rng.normal(0, noise, count)), tasks * (1 + rng.normal(0, noise, count))


@pytest.mark.parametrize("ratio", [1.0, 1.03, 0.96])
def test_it_is_the_larger_of_two_one_sided_tests(ratio):
    values, baseline = paired(ratio)
    sides = 1.05 * baseline - values, 1.05 * values - baseline
    by_t = max(stats.ttest_1samp(side, 0, alternative="greater").pvalue for side in sides)
    both = np.stack([values, baseline], axis=1)
    assert equivalence_test(both, [(0, 1)], 0.05)[0] == pytest.approx(by_t)
    assert equivalence_test(both, [(0, 1)], 0.05) == equivalence_test(both[:, ::-1], [(0, 1)], 0.05)


def test_more_pairs_ask_for_more_and_wider_margins_for_less():
    values = np.stack([*paired(1.02, 0.06), *paired(1.02, 0.06, seed=2)], axis=1)
    alone, many = (
        equivalence_test(values, [(0, 1)], 0.05)[0],
        equivalence_test(values, [(0, 1), (2, 3), (0, 3)], 0.05)[0],
    )
    assert alone <= many
    assert equivalence_test(values, [(0, 1)], 0.1)[0] < alone
    assert equivalence_test(values, [], 0.05).tolist() == []


def test_floors_of_one_building_are_one():
    values, baseline = paired(1.0, noise=0.02)
    apart = 0.06 * baseline * np.repeat(np.random.default_rng(3).choice([-1, 1], 8), 5)
    both = np.stack([values + apart, baseline], axis=1)
    alone, together = (equivalence_test(both, [(0, 1)], 0.05, maps=maps)[0] for maps in (None, np.arange(40) // 5))
    assert alone < together


def test_what_is_found_is_one_of_three():
    rng = np.random.default_rng(5)
    values, base = paired(count=60)
    family = {
        "base": base,
        "like": values,
        "behind": 1.1 * values,
        "little": 1.02 * base,
        "loud": base + rng.normal(0, 30, 60),
    }
    found = contrasts(family, "base", margin=0.05)
    assert {name: each.finding for name, each in found.items()} == {
        "like": Finding.AS_GOOD,
        "behind": Finding.WORSE,
        "little": Finding.WORSE,
        "loud": Finding.OPEN,
    }
    assert found["little"].equivalent  # slower, by less than the margin
    assert not contrasts(family, "base")["like"].equivalent


@pytest.mark.parametrize("ratio", [1.0, 1.1])
def test_so_many_tasks_resolve_it_in_80_percent(ratio, monkeypatch):
    monkeypatch.setattr(significance, "FLIPS", 999)
    rng, pilot = np.random.default_rng(6), paired(ratio, noise=0.08, count=20, seed=2 if ratio > 1 else 1)
    need = int(units_to_resolve(*pilot, 0.05, level=0.05))
    assert need > 20
    resolved = 0
    for _ in range(200):
        drawn = np.stack(pilot, axis=1)[rng.integers(0, 20, need)]
        equal = equivalence_test(drawn, [(0, 1)], 0.05)[0]
        resolved += (sign_flip_test(drawn[:, 0] - drawn[:, 1]) if ratio > 1 else equal) <= 0.05
    assert 0.72 <= resolved / 200 <= 0.9


def test_how_many_resolve_it_is_more_than_there_are():
    assert np.isnan(units_to_resolve(np.ones(1), np.ones(1), 0.05, level=0.05))
    assert units_to_resolve(*paired(noise=0.001, count=5), 0.05, level=0.05) == 6  # fewer are never significant
