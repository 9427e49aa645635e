"""Every shipped policy: the contract, termination, and information, on rooms, mazes, the office and real maps."""

from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, Scenario, check_policy, make_policy, policy_names
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.evaluation.episodes.record import Outcome
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.experiment.experiment import Task

from .policies import PLANNERS, REGISTERED

MAPS = Path(__file__).resolve().parents[2] / "shared" / "maps"


def flown(name, scenario, seeds, map_count=1):
    tasks = [Task(scenario.name, index, seed) for index in range(map_count) for seed in seeds]
    return list(fly(make_policy(name), name, scenario, tasks))


def dithers(cells, most=6):
    """Whether a UAV flies A-B-A-B for more than ``most`` steps in a row; (S, N, 2) cells."""
    back = (cells[2:] == cells[:-2]).all(axis=2) & (cells[1:-1] != cells[:-2]).any(axis=2)
    run = np.zeros(back.shape[1], int)
    for step in back:
        run = np.where(step, run + 1, 0)
        if (run > most).any():
            return True
    return False


def test_the_shipped_policies_are_installed():
    assert set(REGISTERED) <= set(policy_names())


@pytest.mark.parametrize("name", REGISTERED)
def test_it_passes_the_conformance_suite(name):
    policy = make_policy(name)
    hidden = check_policy(policy)["no hidden knowledge"]
    assert hidden.endswith("knows the true map" if policy.privileged else "changed nothing")


@pytest.mark.parametrize("name", PLANNERS)
@pytest.mark.parametrize("scenario", ["thesis-open", "thesis-obstacles", "thesis-team-2", "thesis-team-4"])
def test_it_completes_the_thesis_rooms_without_dithering(name, scenario):
    for record in flown(name, PRESETS[scenario].for_evaluation(), range(500, 510)):
        assert record.outcome is Outcome.COMPLETE, record.task
        assert not dithers(record.cells), record.task
        assert record.metrics["collisions"] == 0


@pytest.mark.parametrize("name", PLANNERS)
def test_it_completes_the_office(name):
    (record,) = flown(name, PRESETS["office"].for_evaluation(), [8])
    assert record.outcome is Outcome.COMPLETE
    assert not dithers(record.cells)


@pytest.mark.parametrize("name", PLANNERS)
@pytest.mark.parametrize("team", [1, 3])
def test_it_completes_a_real_map(name, team):
    path = MAPS / "slam" / "Sarmis2_map_adj.yaml"
    if not path.exists():
        pytest.skip("the real maps are not here")
    scenario = Scenario(
        name="flat",
        map=FileMaps(paths=(str(path),), resolution=0.25),
        team=team,
        spawn="clustered",
        lidar={"range": 10.0},
        radio={"model": "disc", "range": 15.0},
        on_collision="block",
    ).for_evaluation()
    (record,) = flown(name, scenario, [3])
    assert record.outcome is Outcome.COMPLETE
    assert not dithers(record.cells)


def test_every_planner_beats_chance():
    scenario = PRESETS["thesis-obstacles"].for_evaluation()
    areas = {name: np.mean([r.metrics["auc"] for r in flown(name, scenario, range(900, 920))]) for name in REGISTERED}
    assert all(areas[name] > areas["random"] + 0.1 for name in PLANNERS), areas
