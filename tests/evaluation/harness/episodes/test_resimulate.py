"""A record makes its episode again."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.episodes.resimulate import recorded_scenario, resimulate
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.evaluation.plugins import Raises, Wander

LOSSY = {"radio.model": "disc", "radio.range": 5.0, "radio.loss": 0.4, "budget": 80}


@pytest.mark.parametrize("policy", [Wander(), Raises()])
def test_an_episode_flown_again_is_the_recorded_one(policy):
    scenario = PRESETS["thesis-team-4"].for_evaluation().with_settings(LOSSY)
    stored = {"fingerprint": scenario.fingerprint, **scenario.model_dump(mode="json")}
    for record in fly(policy, "w", scenario, [Task(scenario.name, 0, seed) for seed in range(6)]):
        moments = 0
        for step, world in enumerate(resimulate(record, recorded_scenario(stored))):
            np.testing.assert_array_equal(world.state.cell[0], record.cells[step])
            assert world.state.team_covered[0] == record.covered[step, 0]
            np.testing.assert_array_equal(world.state.covered[0], record.covered[step, 1:])
            moments += 1
        assert moments == record.steps + 1


def test_maps_of_files_need_not_be_there(tmp_path):
    scenario = PRESETS["thesis-obstacles"].for_evaluation()
    stored = scenario.model_dump(mode="json") | {"map": {"source": "files", "paths": [str(tmp_path / "gone.png")]}}
    (record,) = fly(Wander(), "w", scenario, [Task(scenario.name, 0, 3)])
    assert len(list(resimulate(record, recorded_scenario(stored)))) == record.steps + 1
