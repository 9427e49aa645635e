"""A made-up clone with the modules that DARE's expert planner is made of: its planner flies to the nearest new node."""

import hashlib
from pathlib import Path

from indoor_explorers.planners.toolbox.peers.clone import PublishedCode

FILES = {
    "parameter.py": "CELL_SIZE, NODE_RESOLUTION = 0.4, 4.0\n",
    "classes/utils.py": """
from parameter import *

class MapInfo:
    def __init__(self, cells, left, top, size):
        assert cells.shape[0] == cells.shape[1] and set(cells.ravel().tolist()) <= {1, 127, 255}
        self.map, self.map_origin_x, self.map_origin_y, self.cell_size = cells, left, top, size
""",
    "classes/agent/agent.py": """
import torch

class Agent:
    def __init__(self, number, nodes):
        self.frontier = set()

    def update_map(self, info):
        self.map_info = self.updating_map_info = info

    def update_updating_map(self, location):
        pass

    def update_frontiers(self):
        pass
""",
    "classes/agent/node_manager.py": """
from types import SimpleNamespace
import numpy as np
from classes.utils import *

class Node:
    def __init__(self, coords):
        self.coords, self.utility, self.neighbor_list = np.array(coords), 2, []

    def set_visited(self):
        self.utility = 0

class Tree(dict):
    def __iter__(self):
        return iter([SimpleNamespace(data=node) for node in self.values()])

    def find(self, key):
        return SimpleNamespace(data=self[tuple(key)]) if tuple(key) in self else None

class NodeManager:
    def __init__(self):
        self.nodes_dict = Tree()

    def update_graph(self, location, frontiers, updating, info):
        for row, col in np.argwhere(info.map == 255):
            x, y = info.map_origin_x + col * info.cell_size, info.map_origin_y + row * info.cell_size
            key = round(x / NODE_RESOLUTION) * NODE_RESOLUTION, round(y / NODE_RESOLUTION) * NODE_RESOLUTION
            if abs(key[0] - x) + abs(key[1] - y) < 0.01 and key not in self.nodes_dict.keys():
                self.nodes_dict[key] = Node(key)
        for x, y in self.nodes_dict.keys():
            sides = [(1, 0), (-1, 0), (0, 1), (0, -1)]
            ends = [(x + right * NODE_RESOLUTION, y + down * NODE_RESOLUTION) for right, down in sides]
            self.nodes_dict[x, y].neighbor_list = [end for end in ends if end in self.nodes_dict.keys()]
""",
    "classes/planner/expert_planner.py": """
import os, time
from copy import deepcopy
from pathlib import Path

class ExpertPlanner:
    def __init__(self, nodes):
        self.nodes, self.last_viewpoints = nodes, None
        Path(f"{os.getpid()}.pid").touch()

    def plan_coverage_paths(self, locations):
        for ending in Path(".").glob("*.once"):
            how = ending.stem
            ending.unlink()
            if how == "exit":
                os._exit(3)
            time.sleep(60)
        away, before = self.nodes.Dijkstra(locations[0])
        useful = [tuple(each.data.coords) for each in self.nodes.nodes_dict if each.data.utility > 0]
        path = [min(useful, key=away.get)]
        assert away[path[0]] < 1e8
        while before[path[0]] not in (None, tuple(locations[0])):
            path.insert(0, before[path[0]])
        return [path]
""",
}


def write_clone(folder: Path) -> PublishedCode:
    """Write the clone, and return the code that recognises it."""
    for name, text in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    digests = {name: hashlib.sha256(text.encode()).hexdigest() for name, text in FILES.items()}
    return PublishedCode(url="https://example.org/DARE", commit="1" * 40, files=digests)
