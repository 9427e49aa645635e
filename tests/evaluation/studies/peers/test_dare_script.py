"""The script that drives DARE, on classes with its interface: a corridor of three nodes, of which the last is new."""

import sys
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.evaluation.studies.peers.dare import CELL, SCRIPT
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.planners.toolbox.peers.process import Peer, PeerProcess

#: Files of the clone; coordinates are (x, y) in metres from the start, cells (column, row).
FILES = {
    "parameter.py": "CELL_SIZE, FREE, OCCUPIED = 0.4, 255, 1",
    "classes/utils.py": """
import numpy as np
def get_cell_position_from_coords(coords, info):
    return np.around(coords.reshape(-1, 2) / 0.4 + np.array([2, 1])).astype(int)
""",
    "classes/env/env.py": """
import numpy as np
class Env:
    def __init__(self, index, test):
        assert (index, test) == (1, True)
        self.ground_truth = np.full((3, 26), 1)
        self.ground_truth[1, 1:25] = 255
        self.robot_belief = np.where(np.arange(26) < 14, self.ground_truth, 127)
        self.belief_info, self.robot_locations = None, np.array([[0.0, 0.0]])
    def step(self, target, number):
        self.robot_locations[number] = target
        self.robot_belief[1:] = self.ground_truth[1:]
    def update_robot_belief(self, cell):
        self.robot_belief[0, cell[0]] = 255
""",
    "classes/agent/agent.py": """
import numpy as np
class Agent:
    def __init__(self, number, graph):
        self.graph, self.travel_dist, self.at = graph, 0.0, np.zeros(2)
    def update_graph(self, info, location):
        self.travel_dist += float(np.hypot(*(location - self.at)))
        self.at = location
        self.graph.grow(location)
""",
    "classes/agent/node_manager.py": """
from types import SimpleNamespace as Some
import numpy as np
class NodeManager:
    def __init__(self):
        self.nodes_dict = []
    def grow(self, location):
        ends = [np.array([4.0 * k, 0.0]) for k in range(3)]
        known = [ends[0], ends[1]] if location[0] == 0 else ends
        points = {(4.8, 0.0), (4.8, 0.4)} if location[0] == 0 else set()
        self.nodes_dict = [
            Some(data=Some(coords=end, utility=len(points) * (k == 1), neighbor_list=[end, *ends],
                           observable_frontiers=points if k == 1 else set()))
            for k, end in enumerate(known)
        ]
""",
    "classes/planner/expert_planner.py": """
import numpy as np
class ExpertPlanner:
    def __init__(self, graph):
        self.drawn = np.random.random()
    def plan_coverage_paths(self, locations):
        return [[(4.0, 0.0), (8.0, 0.0)]]
""",
}


@pytest.fixture
def process(tmp_path: Path):
    for name, text in FILES.items() | {("maps_test/1.png", ""), ("maps_test/10.png", "")}:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    with PeerProcess(Peer(interpreter=sys.executable, folder=tmp_path, script=SCRIPT)) as process:
        yield process


@pytest.mark.parametrize("asked", [1, None], ids=["to a node", "where the expert goes"])
def test_states_are_in_cells_and_metres(process: PeerProcess, asked: int | None) -> None:
    """Unknown neighbours are left out, and a point that no node counts is none."""
    start = GraphState.of(process.ask("begin", name="10.png", seed=0), CELL)
    assert start.belief[1].tolist() == [2] + 13 * [1] + 12 * [0]
    assert start.nodes.tolist() == [[1, 2], [1, 12]]
    assert start.edges.tolist() == [[0, 0], [0, 0], [0, 1], [1, 0], [1, 1], [1, 1]]
    assert start.frontiers.tolist() == [[1, 14], [2, 14]]
    assert start.sights.tolist() == [[1, 0], [1, 1]]
    assert (start.node, start.metres, start.done, start.useful.tolist()) == (0, 0.0, False, [1])
    assert start.explored == pytest.approx(13 / 24)
    assert np.isclose(start.away, [0.0, 4.0]).all()
    end = GraphState.of(process.ask("step", node=asked, on_the_way=False), CELL)
    assert (end.node, end.metres, end.done, len(end.nodes), len(end.frontiers)) == (1, 4.0, True, 3, 0)


def test_the_robot_scans_in_every_cell_that_it_passes_if_asked(process: PeerProcess) -> None:
    """The small simulator marks the columns of scans in its first row: nine between nodes ten cells apart."""
    process.ask("begin", name="10.png", seed=0)
    end = GraphState.of(process.ask("step", node=1, on_the_way=True), CELL)
    assert np.flatnonzero(end.belief[0] == 1).tolist() == list(range(3, 12))
