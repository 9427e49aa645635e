"""The tables of kinds of buildings: what flights knew after so many metres."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, make_policy
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.site.studies.level_kinds import (
    LEVELS,
    ONE_HEIGHT,
    Flight,
    answer_row,
    metres_row,
    planner_row,
)

FLAT = Flight(np.array([0.0, 0.5, 1.0, 1.0]), np.array([0.1, 0.2, 0.5, 0.5]), np.array([0.0, 0.1, 0.4, 0.4]))
TALL = Flight(np.array([0.0, 0.5, 1.0, 30.0]), np.array([0.1, 0.5, 0.9, 1.0]), np.array([0.0, 0.2, 0.8, 1.0]))
SLOW = TALL._replace(metres=2 * TALL.metres)
FLIGHTS = {ONE_HEIGHT: [FLAT] * 5, LEVELS: [TALL] * 5, "slow": [SLOW] * 5}


def test_shares_after_some_metres_and_metres_to_a_share():
    assert FLAT.at(0.0) == (0.1, 0.0)
    assert FLAT.at(0.7) == (0.2, 0.1)
    assert FLAT.at(np.inf) == (0.5, 0.4)
    assert FLAT.metres_to(0.2) == 0.5
    assert FLAT.metres_to(0.6) == np.inf


def test_the_rows_of_the_tables():
    known, surface, at_one_height, as_much, *shares = answer_row(FLIGHTS)
    assert known.startswith("50")
    assert surface.startswith("40")
    assert (at_one_height, as_much) == ("1 [1, 1]", "0 [0, 0]")
    assert shares == ["1 [1, 1]", "30 [30, 30]"]
    assert next(metres_row([FLAT, TALL])).replace("\N{NARROW NO-BREAK SPACE}", " ") == "70 % / 60 %"
    ratio, p, *_ = planner_row([FLIGHTS, FLIGHTS], "slow")
    assert ratio == "2.00 [2.00, 2.00]"
    assert float(p) == pytest.approx(2 / 2**10, abs=1e-3)
    assert list(planner_row([FLIGHTS], ONE_HEIGHT)) == ["-"] * 4


@pytest.mark.parametrize("elevation", [15.0, 90.0])
def test_a_flight_is_what_the_record_says(elevation):
    task = PRESETS["one-storey"].for_evaluation().with_settings({"team": 1, "budget": 30, "lidar.elevation": elevation})
    (record,) = fly(make_policy("frontier-nearest"), "frontier-nearest", task, [Task(task.name, 0, 3)])
    flight = Flight.of(record, task)
    assert flight.metres[-1] == 0.5 * record.metrics["path_length"]
    assert flight.surface[-1] == record.metrics["surface"]
    assert (np.diff(flight.surface) >= 0).all()
    np.testing.assert_array_equal(flight.free, record.curve)
