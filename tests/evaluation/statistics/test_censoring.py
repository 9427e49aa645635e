"""Times that some episodes never reach."""

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import ecdf_of_times


def test_shares_by_hand():
    steps, share = ecdf_of_times([5, None, 3, 5, None], 10)
    assert steps.tolist() == [0, 3, 5, 10]
    assert share.tolist() == [0.0, 0.2, 0.6, 0.6]


def test_no_share_is_above_the_success_rate():
    times = np.where(np.arange(30) < 9, np.arange(30) * 7.0, np.nan)
    steps, share = ecdf_of_times(times, 100)
    assert share.max() == share[-1] == 9 / 30
    assert steps[0] == 0
    assert share[0] == 1 / 30


def test_levels_reached_at_once_at_the_last_step_and_never():
    assert ecdf_of_times([0, 10], 10)[1].tolist() == [0.5, 1.0]
    assert ecdf_of_times([np.nan, np.nan], 10)[1].tolist() == [0.0, 0.0]


def test_shares_are_the_kaplan_meier_estimate():
    rng = np.random.default_rng(1)
    true = rng.gamma(2.0, 40.0, 50).round()
    steps, share = ecdf_of_times(np.where(true <= 90, true, np.nan), 90)
    censored = stats.CensoredData(true[true <= 90], right=np.full((true > 90).sum(), 90.0))
    assert share == pytest.approx(stats.ecdf(censored).cdf.evaluate(steps))


@pytest.mark.parametrize("times", [[11], [-1], [np.inf]])
def test_times_out_of_the_budget_are_refused(times):
    with pytest.raises(InputError, match="budget of 10 steps"):
        ecdf_of_times(times, 10)


def test_no_episodes_are_refused():
    with pytest.raises(InputError, match="at least one episode"):
        ecdf_of_times([], 10)
