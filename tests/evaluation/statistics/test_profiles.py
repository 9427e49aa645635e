"""Performance profiles by hand."""

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import performance_profile, performance_ratios

NEVER = np.nan
TIMES = np.array([[10.0, 20.0], [30.0, 10.0], [10.0, NEVER], [NEVER, NEVER], [5.0, 5.0]])


def test_ratios_by_hand():
    expected = [[1, 2], [3, 1], [1, np.inf], [np.inf, np.inf], [1, 1]]
    assert performance_ratios(TIMES).tolist() == expected


def test_a_profile_by_hand():
    tau, share = performance_profile(performance_ratios(TIMES))
    assert tau.tolist() == [1, 2, 3]
    assert share[:, 0].tolist() == [0.6, 0.6, 0.8]
    assert share[:, 1].tolist() == [0.4, 0.6, 0.6]


def test_the_last_share_is_the_success_rate():
    times = np.random.default_rng(1).gamma(3.0, 30.0, (40, 4))
    times[times > 120] = np.nan
    _, share = performance_profile(performance_ratios(times))
    assert (np.diff(share, axis=0) >= 0).all()
    assert share[-1] == pytest.approx(np.isfinite(times).mean(axis=0))


def test_a_level_that_is_there_at_the_start_counts_as_one_step():
    assert performance_ratios(np.array([[0.0, 1.0, 4.0]])).tolist() == [[1, 1, 4]]


def test_tasks_that_nobody_solved_leave_only_tau_one():
    tau, share = performance_profile(np.full((3, 2), np.inf))
    assert tau.tolist() == [1]
    assert share.tolist() == [[0, 0]]


def test_what_is_no_table_of_ratios_is_refused():
    with pytest.raises(InputError, match="at least 1"):
        performance_profile(np.array([[1.0, 0.5]]))
    with pytest.raises(InputError, match="at least 0"):
        performance_ratios(np.array([[1.0, -2.0]]))
    with pytest.raises(InputError, match=r"\(3,\)"):
        performance_profile(np.ones(3))
    with pytest.raises(InputError, match=r"\(0, 2\)"):
        performance_ratios(np.ones((0, 2)))
