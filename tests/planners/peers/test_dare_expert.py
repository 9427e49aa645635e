"""DARE's expert planner flies in this world from a clone: here a made-up one, and the real one where there is one."""

import gc
import os
import sys
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, Policy, make_policy
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.planners.peers import dare_expert, dare_expert_script
from indoor_explorers.planners.peers.dare_expert import IN_CLONE, PYTHON, DareExpert
from indoor_explorers.planners.toolbox.peers.process import Need
from tests.planners.peers.fake_dare import write_clone
from tests.processes import runs, wait_until

ROOM = PRESETS["thesis-open"].for_evaluation()
#: A clone of DARE, whose interpreter DARE_PYTHON names.
CLONE = os.environ.get("DARE_CLONE")
needs_clone = pytest.mark.skipif(
    None in (CLONE, os.environ.get(PYTHON)), reason=f"DARE_CLONE and {PYTHON} name no clone of DARE and no interpreter"
)


@pytest.fixture
def clone(tmp_path, monkeypatch):
    """A made-up clone that this interpreter runs."""
    monkeypatch.setattr(dare_expert, "DARE", write_clone(tmp_path / "DARE"))
    monkeypatch.setattr(dare_expert, "EXPERT_NEEDS", (Need(package="numpy"),))
    return tmp_path / "DARE"


def flown(policy: Policy, scenario=ROOM, seeds=(500,)) -> list[Record]:
    return list(fly(policy, "dare-expert", scenario, [Task(scenario.name, 0, seed) for seed in seeds]))


def length(one, other) -> float:
    return float(np.hypot(*np.subtract(one, other)))


@pytest.mark.slow
@pytest.mark.parametrize("team", [1, 2])
def test_it_explores_all_by_the_nodes_of_the_planner_and_then_by_frontiers(clone: Path, team: int) -> None:
    scenario = ROOM.model_copy(update={"team": team})
    (record,) = flown(DareExpert(clone=str(clone), python=sys.executable), scenario)
    assert record.outcome is Outcome.COMPLETE, record
    assert record.metrics["collisions"] == 0
    gc.collect()
    pids = [int(file.stem) for file in clone.glob("*.pid")]
    assert len(pids) == team
    assert not any(map(runs, pids))


def test_the_goals_are_nodes_and_the_first_one_is_where_the_uav_starts(clone: Path) -> None:
    """With a lidar of 8 nodes are 2 cells apart, and the made-up planner goes from each to one beside it."""
    goals, starts = [], []

    class Noting(dare_expert.DareExpertPilot):
        def choose(self, view):
            starts.extend([view.cell] * (view.step == 0))
            goal = super().choose(view)
            if not self._to_frontier:
                goals.append((view.cell, goal))
            return goal

    class NotingExpert(DareExpert):
        def pilot(self, briefing):
            return Noting(briefing, self.process())

    scenario = PRESETS["thesis-obstacles"].for_evaluation()
    scenario = scenario.model_copy(update={"lidar": scenario.lidar.model_copy(update={"range": 8.0})})
    (record,) = flown(NotingExpert(clone=str(clone), python=sys.executable), scenario)
    assert record.outcome is Outcome.COMPLETE
    here, there = np.array(goals).swapaxes(0, 1) - starts[0]
    assert len(there) > 2
    assert not (there % 2).any()
    at_nodes = ~(here % 2).any(axis=1)
    assert at_nodes.sum() > 2
    assert set(np.abs(there - here).sum(axis=1)[at_nodes]) == {2}


@pytest.mark.parametrize(
    ("ending", "told"),
    [
        ("exit", "ended with exit code 3"),
        pytest.param("hang", "gave no answer within 2 s", marks=pytest.mark.slow),
    ],
)
def test_a_process_that_fails_costs_its_own_episode(clone: Path, ending: str, told: str) -> None:
    (clone / f"{ending}.once").touch()
    policy = DareExpert(clone=str(clone), python=sys.executable, time_limit=2.0)
    records = flown(policy, seeds=(500, 501))
    assert sorted(record.outcome for record in records) == sorted([Outcome.FAILED, Outcome.COMPLETE])
    (failed,) = (record.reason for record in records if record.outcome is Outcome.FAILED)
    assert failed.startswith(f"PeerFailure: the process of DARE {told}")
    assert "\n" not in failed
    gc.collect()
    wait_until(lambda: not any(runs(int(file.stem)) for file in clone.glob("*.pid")), 10.0)


def test_a_wrong_folder_or_environment_is_told_in_one_line(clone: Path, tmp_path, monkeypatch) -> None:
    monkeypatch.delenv(PYTHON, raising=False)
    with pytest.raises(InputError, match=r"expected a clone of https://example.org/DARE at commit 1111111"):
        DareExpert(clone=str(tmp_path))
    with pytest.raises(InputError, match=r"expected the Python interpreter .*`python -m venv .*/DARE/\.venv && "):
        DareExpert(clone=str(clone))
    with pytest.raises(InputError, match="expected time_limit of at least"):
        DareExpert(clone=str(clone), python=sys.executable, time_limit=0.0)
    monkeypatch.setenv(PYTHON, sys.executable)
    assert DareExpert(clone=str(clone)).interpreter == sys.executable
    monkeypatch.delenv(PYTHON)
    (clone / IN_CLONE).parent.mkdir(parents=True)
    (clone / IN_CLONE).symlink_to(sys.executable)
    found = DareExpert(clone=str(clone)).provenance()
    assert found["peer_commit"] == 40 * "1"
    assert found["peer_numpy"] == np.__version__


def test_cells_are_scaled_to_the_metres_of_the_planner() -> None:
    """At 50 cells all is as in DARE; at any range nodes are whole cells apart, and lengths have one decimal."""
    cell, parameters = dare_expert_script.scaled(50.0)
    assert (cell, parameters["NODE_RESOLUTION"], parameters["SENSOR_RANGE"]) == (0.4, 4.0, 20.0)
    assert (parameters["FRONTIER_CELL_SIZE"], parameters["UTILITY_RANGE"]) == (1.6, 16.0)
    assert parameters["UPDATING_MAP_SIZE"] == 96.0
    for lidar in (3.0, 4.5, 7.0, 10.0, 16.0, 20.0, 33.0, 80.0):
        cell, parameters = dare_expert_script.scaled(lidar)
        apart = parameters["NODE_RESOLUTION"] / cell
        assert apart == pytest.approx(max(1, round(lidar / 5)))
        assert parameters["SENSOR_RANGE"] == pytest.approx(lidar * cell, abs=0.051)
        assert 10 * cell == pytest.approx(round(10 * cell))


def test_the_faster_search_finds_shortest_paths() -> None:
    rng = np.random.default_rng(3)
    points = [tuple(point) for point in rng.uniform(0, 9, (30, 2))]
    graph = nx.random_geometric_graph(30, 2.2, pos=dict(enumerate(points)), seed=0)
    links = {
        points[k]: [(points[j], float(np.hypot(*np.subtract(points[k], points[j])))) for j in graph[k]] for k in graph
    }
    for k, end in graph.edges:
        graph.edges[k, end]["weight"] = dict(links[points[k]])[points[end]]
    away, before = dare_expert_script._shortest(links, points[0])
    expected = nx.single_source_dijkstra_path_length(graph, 0)
    assert [away[point] for point in points] == pytest.approx([expected.get(k, 1e8) for k in range(30)])
    assert 5 < len(expected) < 30
    for k in expected:
        if k:
            previous = before[points[k]]
            assert away[points[k]] == pytest.approx(away[previous] + dict(links[previous])[points[k]])


@needs_clone
@pytest.mark.slow
@pytest.mark.parametrize("lidar", [3.0, 10.0])
def test_the_planner_of_the_clone_explores_a_room_and_repeats_itself(lidar: float) -> None:
    scenario = ROOM.model_copy(update={"lidar": ROOM.lidar.model_copy(update={"range": lidar})})
    policy = make_policy(f"dare-expert:{CLONE}")
    first, again = (flown(policy, scenario, (500, 501)) for _ in range(2))
    for one, other in zip(first, again, strict=True):
        assert one.outcome is Outcome.COMPLETE
        assert np.array_equal(one.actions, other.actions)
        assert one.metrics["pilot_unreachable_nodes"] == 0
