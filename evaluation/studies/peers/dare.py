"""DARE: its simulator and its expert planner, run from a clone (Cao et al., ICRA 2025).

The rules are those of its own tests: 0.4 m a cell, a robot that jumps between nodes 4 m apart and scans 20 m around
each, and ends where no node has any utility, or after 128 moves. The measure is the metres flown.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from indoor_explorers.env.errors import InputError
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.evaluation.studies.peers.maps import asked_maps
from indoor_explorers.planners.toolbox.peers.dare import DARE, EXPERT_NEEDS
from indoor_explorers.planners.toolbox.peers.process import Need, Peer, PeerProcess

CODE = DARE.with_files(
    {
        "classes/env/env.py": "75767de424da976f1b6f557388e7856f8ccbf3b13cbffeb521b31b18c9047264",
        "classes/env/sensor.py": "380dbdb6932365a8a24413ff95cb5287b44e64fa58400c143017b66927251c52",
    }
)
CITATION = "Y. Cao et al., DARE, ICRA 2025, doi:10.1109/ICRA55743.2025.11128196"
#: What the simulator imports.
NEEDS = (*EXPERT_NEEDS, Need(package="torch"), Need(package="matplotlib"))
#: What drives the simulator in its process.
SCRIPT = Path(__file__).with_name("dare_script.py")
#: Metres a cell, metres that its lidar sees, and moves after which it stops.
CELL, LIDAR_RANGE, MOST_MOVES = 0.4, 20.0, 128
#: Seconds that a move may take.
TIME_LIMIT = 120.0


class DareSimulator:
    """The simulator in a process of its own."""

    def __init__(self, clone: Path, interpreter: str, *, scans_on_the_way: bool = False) -> None:
        """Check a clone; the process starts with the first episode.

        Args:
            clone: the folder of the clone.
            interpreter: the Python of an environment with :data:`NEEDS`.
            scans_on_the_way: whether the robot scans in every cell that it passes, and not at nodes alone.

        Raises:
            InputError: the clone is not what is expected.

        """
        self.folder, self.scans_on_the_way = CODE.checked(clone), scans_on_the_way
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
        return asked_maps(wanted, names)

    def begin(self, name: str, seed: int) -> GraphState:
        """Start an episode on a map; the seed is for the expert planner."""
        return GraphState.of(self.process.ask("begin", name=name, seed=seed), CELL)

    def move(self, node: int | None) -> GraphState:
        """Move to a node, None for the one that the expert planner chooses."""
        return GraphState.of(self.process.ask("step", node=node, on_the_way=self.scans_on_the_way), CELL)
