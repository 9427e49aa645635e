"""Which policy is better where some tasks were not finished."""

import numpy as np
import pytest

from indoor_explorers.evaluation.statistics import Finding, all_pairs_test, contrasts, tied_ranks

BUDGET = 400.0
COUNT = 30


def flown(*failures, ahead=0.0):
    """(E, 2) times and whether they were finished; the first is ``ahead`` steps quicker where both finished."""
    rng = np.random.default_rng(1)
    times = rng.normal(60, 15, (COUNT, 1)) + rng.normal(0, 3, (COUNT, 2)) - [ahead, 0.0]
    reached = np.ones(times.shape, np.bool_)
    for policy, failed in enumerate(failures):
        reached[failed, policy] = False
    return np.where(reached, times, BUDGET), reached


def finding(times, reached):
    """What is found of the first policy against the second."""
    values, ended = ({"a": each[:, 0], "b": each[:, 1]} for each in (times, reached))
    found = contrasts(values, "b", reached=ended, chosen=True)["a"]
    better = all_pairs_test(times, None, reached).better()
    assert (found.finding is Finding.BETTER, found.finding is Finding.WORSE) == (better[0, 1], better[1, 0])
    assert tied_ranks(times, reached=reached) == [1 + better[1, 0], 1 + better[0, 1]]
    return found


def test_a_lead_over_the_tasks_that_both_finished_is_better_where_no_fewer_were_finished():
    assert finding(*flown([3], [3, 4], ahead=5.0)).finding is Finding.BETTER
    found = finding(*flown([3, 4], [3], ahead=5.0))
    assert (found.finding, found.shown, found.success_shown) == (Finding.MIXED, True, False)
    assert (found.both, found.pairs, found.finished) == (28, 30, (28, 29))
    assert found.difference.mean == pytest.approx(-5, abs=1.5)


def test_who_finishes_significantly_more_is_better_unless_it_is_slower():
    often = list(range(12))
    assert finding(*flown([], often)).finding is Finding.BETTER
    assert finding(*flown(often, [])).finding is Finding.WORSE
    assert finding(*flown([], often, ahead=-6.0)).finding is Finding.MIXED
    assert finding(*flown([], often[:3])).finding is Finding.OPEN


def test_a_policy_that_never_finishes_is_worse_and_has_no_difference():
    found = finding(*flown(list(range(COUNT)), []))
    assert (found.finding, found.both, found.difference.low) == (Finding.WORSE, 0, None)


def test_a_failure_that_both_have_changes_nothing():
    times, reached = flown([7], [7], ahead=1.0)
    kept = np.arange(COUNT) != 7
    whole, without = (
        all_pairs_test(each, None, ended) for each, ended in ((times, reached), (times[kept], reached[kept]))
    )
    assert whole.difference[0, 1] == pytest.approx(without.difference[0, 1])
    assert whole.adjusted_p[0, 1] == pytest.approx(without.adjusted_p[0, 1], abs=0.02)
    assert whole.success[0, 1] == 0
