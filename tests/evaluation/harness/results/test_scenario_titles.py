"""Titles tell what of a preset was changed; names stay as they are stored."""

import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.experiment.experiment import with_sweeps
from indoor_explorers.evaluation.harness.results.scenario_titles import scenario_title


@pytest.mark.parametrize(
    ("settings", "title"),
    [
        ({}, "thesis-team-4"),
        ({"team": 2}, "thesis-team-4 team=2"),
        ({"radio.range": [1, 5]}, "thesis-team-4 radio.range=1"),
        ({"radio.range": [1, 5], "team": 2}, "thesis-team-4 radio.range=1 team=2"),
        ({"map.source": "cave", "goal": 0.5}, "thesis-team-4 goal=0.5 map.source=cave"),
        ({"name": "mine", "team": 2}, "mine"),
        ({"name": "thesis-team-4 at night", "team": 2}, "thesis-team-4 at night"),
        (
            {"team": 2, "budget": 9, "goal": 0.5, "spawn": "clustered", "radio.model": "none"},
            "thesis-team-4 budget=9 goal=0.5 radio.model=none and 2 more settings",
        ),
    ],
)
def test_a_changed_preset_is_told_by_what_differs(settings, title):
    stored = with_sweeps(PRESETS["thesis-team-4"].for_evaluation(), settings)[0].model_dump(mode="json")
    assert scenario_title(stored["name"], stored) == title


def test_what_earlier_results_lack_does_not_differ():
    stored = PRESETS["office-base-2"].for_evaluation().model_dump(mode="json", exclude={"base", "drift"})
    assert scenario_title(stored["name"], stored) == "office-base-2"
