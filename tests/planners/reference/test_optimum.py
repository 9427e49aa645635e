"""The policy that flies the fewest steps there are, or says that it does not know them."""

from __future__ import annotations

import pytest

from indoor_explorers.env import PRESETS, make_policy
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task


def flown(scenario: str, seed: int = 0, policy: str = "optimum", **parameters: float) -> Record:
    task = PRESETS[scenario].for_evaluation()
    (record,) = fly(make_policy(policy, **parameters), policy, task, [Task(scenario, 0, seed)])
    assert record.outcome is Outcome.COMPLETE
    return record


@pytest.mark.parametrize(
    ("scenario", "seed", "expected"), [("thesis-open", 0, 42), ("thesis-obstacles", 2, 55), ("thesis-team-2", 1, 23)]
)
def test_it_flies_what_is_proved(scenario, seed, expected):
    metrics = flown(scenario, seed).metrics
    assert metrics["t99"] == metrics["pilot_lower_bound"] == expected
    assert metrics["pilot_proved"] == 1.0
    assert metrics["t99"] <= flown(scenario, seed, "reference").metrics["t99"]


def test_other_aims_are_reached_as_soon():
    metrics = flown("thesis-obstacles", 2, aim=0.9).metrics
    assert metrics["t90"] == metrics["pilot_lower_bound"] == 38
    whole = flown("thesis-open", aim=1.0)
    assert whole.steps == 44


def test_what_the_effort_does_not_prove_is_said():
    metrics = flown("thesis-open", 3, expansions=10).metrics
    assert metrics["pilot_proved"] == 0.0
    assert metrics["pilot_lower_bound"] < metrics["t99"] <= flown("thesis-open", 3, "reference").metrics["t99"]


@pytest.mark.parametrize(("scenario", "parameters"), [("thesis-team-4", {}), ("thesis-open", {"expansions": 0})])
def test_where_it_does_not_search_it_flies_as_the_reference(scenario, parameters):
    record, reference = flown(scenario, **parameters), flown(scenario, policy="reference")
    assert record.cells.tolist() == reference.cells.tolist()
    assert record.metrics["pilot_proved"] == 0.0
    assert "pilot_lower_bound" not in record.metrics
