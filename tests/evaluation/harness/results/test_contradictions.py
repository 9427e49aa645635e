"""Metrics of many records at once are those of each."""

import numpy as np
import pytest

from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, team_metrics
from indoor_explorers.evaluation.harness.results.contradictions import contradictions
from tests.evaluation.harness.results.test_store import filled


def changed(record, **metrics):
    return record.__class__(**{**vars(record), "metrics": record.metrics | metrics})


@pytest.fixture
def records(tmp_path):
    return filled(tmp_path / "results.db")


def test_what_the_runner_computed_contradicts_nothing(records):
    for record in records:
        told = team_metrics(record.covered, record.team, record.reachable, record.budget)
        assert told.items() <= record.metrics.items()
    assert contradictions(records) == {}


@pytest.mark.parametrize("metric", ["auc", "auc_worst", "auc_mean", *LEVELS, "path_length", "messages_bytes"])
@pytest.mark.parametrize("place", [0, 2])
def test_a_metric_that_its_steps_do_not_give_is_found(records, metric, place):
    old = records[place].metrics[metric]
    records[place] = changed(records[place], **{metric: (old or 0.0) + 0.01})
    ((key, why),) = contradictions(records).items()
    assert key == (records[place].policy, records[place].task)
    assert why.startswith(f"{metric} is ")
    assert np.isfinite(float(why.split()[2].rstrip(",")))
