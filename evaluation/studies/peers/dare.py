"""DARE: its simulator and its expert planner, run from a clone (Cao et al., ICRA 2025).

The rules are those of its own tests: 0.4 m a cell, a robot that jumps between nodes 4 m apart and scans 20 m around
each, and ends where no node has any utility, or after 128 moves. The measure is the metres flown.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.planners.toolbox.peers.clone import PublishedCode
from indoor_explorers.planners.toolbox.peers.process import Need, Peer, PeerProcess

CODE = PublishedCode(
    url="https://github.com/marmotlab/DARE",
    commit="9a1c3c984747b354c75374e57bde3a9a7b32c204",
    files={
        "parameter.py": "f5a2c19f512a97872e9fd98fe4c62303ba078eea5ef390a177927b9e6459a70d",
        "classes/utils.py": "52d14807010244568ef64e9dd69fe43d95e163a2f6d0c84df7de0e66975d6196",
        "classes/env/env.py": "75767de424da976f1b6f557388e7856f8ccbf3b13cbffeb521b31b18c9047264",
        "classes/env/sensor.py": "380dbdb6932365a8a24413ff95cb5287b44e64fa58400c143017b66927251c52",
        "classes/agent/agent.py": "f4a0d1540f82cfda11e7e17f3ca5524ffadd35998d4f7ef5fed6f7c1db6bdf3d",
        "classes/agent/node_manager.py": "1471c973874c71c1fed27562f4f6aca7d932814ed0d0321dddd2c665dbd9c4c8",
        "classes/agent/quads.py": "b6e2efa63d526d89973c271f98cb30231dfd02f79c08bce69c08d57f2217d242",
        "classes/planner/expert_planner.py": "954479d7afe3f9f98eb6b056a038ed5f584c8236bb0c9ad5d6690c6febc55153",
        "classes/planner/ortools_solver.py": "3103b65ca6502f84b732bd2881f52f23de033620b0b0e4f9cac0195eaecce9fa",
    },
)
CITATION = "Y. Cao et al., DARE, ICRA 2025, doi:10.1109/ICRA55743.2025.11128196"
#: What the simulator imports.
NEEDS = (
    Need(package="numpy", below=2),
    Need(package="scikit-image", module="skimage"),
    Need(package="ortools"),
    Need(package="torch"),
    Need(package="imageio"),
    Need(package="matplotlib"),
)
#: What drives the simulator in its process.
SCRIPT = Path(__file__).with_name("dare_script.py")
#: Metres a cell, metres that its lidar sees, and moves after which it stops.
CELL, LIDAR_RANGE, MOST_MOVES = 0.4, 20.0, 128
#: Seconds that a move may take.
TIME_LIMIT = 120.0


class DareSimulator:
    """The simulator in a process of its own."""

    def __init__(self, clone: Path, interpreter: str) -> None:
        """Check a clone; the process starts with the first episode.

        Raises:
            InputError: the clone is not what is expected.

        """
        self.folder = CODE.checked(clone)
        peer = Peer(interpreter=interpreter, folder=self.folder, script=SCRIPT, needs=NEEDS, time_limit=TIME_LIMIT)
        self.process = PeerProcess(peer)

    def maps(self, wanted: Sequence[str]) -> list[str]:
        """Return names of test maps in the simulator's order: all, the first few for a number, or some by name.

        Raises:
            InputError: there is no such map.

        """
        names = sorted(path.name for path in (self.folder / "maps_test").glob("*.png"))
        if not names:
            raise InputError(f"{self.folder}: expected maps in maps_test, found none; {CODE.how_to_fetch}")
        if len(wanted) == 1 and wanted[0].isdecimal() and 0 < int(wanted[0]) <= len(names):
            return names[: int(wanted[0])]
        named = {path.removesuffix(".png"): path for path in names}
        for each in wanted:
            if each.removesuffix(".png") not in named:
                known = did_you_mean(each, named) if not each.isdecimal() else f"; there are {len(names)} maps"
                raise InputError(f"--maps: expected a number of maps or names of them, got {each!r}{known}")
        return [named[each.removesuffix(".png")] for each in wanted] or names

    def begin(self, name: str, seed: int) -> GraphState:
        """Start an episode on a map; the seed is for the expert planner."""
        return GraphState.of(self.process.ask("begin", name=name, seed=seed), CELL)

    def move(self, node: int | None) -> GraphState:
        """Move to a node, None for the one that the expert planner chooses."""
        return GraphState.of(self.process.ask("step", node=node), CELL)
