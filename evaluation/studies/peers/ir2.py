"""IR2: its simulator of teams with a radio that walls weaken, run from a clone (Tan et al., IROS 2024).

The rules are those of its own tests. Robots move in turn, one node a step, and scan 80 pixels around it. Linked ones,
directly or through others, merge their maps after every move. A flight ends once every robot knows 99 % of the free
pixels. The measures are the steps and the pixels flown by the robot that flies most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from indoor_explorers.env.errors import InputError
from indoor_explorers.evaluation.studies.peers.by_path import Turn
from indoor_explorers.evaluation.studies.peers.maps import asked_maps
from indoor_explorers.planners.toolbox.peers.ir2 import IR2
from indoor_explorers.planners.toolbox.peers.process import Need, Peer, PeerProcess

CODE = IR2.with_files(
    {
        "graph.py": "b1d5d41810d68273b0a588dca960c4eb10261f4acf6e0ab7744321b25c46f822",
        "sensor.py": "a7a71eabcb0dde3b586dddfb21f7b5f77ef3bd1d7462f2bda094f7945b8e8f73",
        "ss_realistic_model.py": "dee2f76a4673dd663138acfe1a4654f2cccb0ba103dac0346d5c7bace0f26b92",
        "test_parameter.py": "6616067502c3493138a9e61835669320c1509cf07fa95fe73334c4f2c9a8d309",
    }
)
#: What drives it in the process.
SCRIPT = Path(__file__).with_name("ir2_script.py")
CITATION = "D. M. S. Tan et al., IR2, IROS 2024, arXiv:2409.04730"
#: What the simulator imports.
NEEDS = (
    Need(package="numpy", below=2),
    Need(package="scikit-image", module="skimage"),
    Need(package="scikit-learn", module="sklearn"),
    Need(package="scipy"),
    Need(package="matplotlib"),
)
#: Pixels that its lidar sees, and from which on distance costs signal.
LIDAR_RANGE, RADIO_RANGE = 80.0, 35.0
#: Seed of the first map of a set; each map has the next one, as in the flights of its weights that were repeated.
FIRST_SEED = 20261005
#: Maps of a set that its own tests fly.
TASKS = 100
#: Seconds that a move may take.
TIME_LIMIT = 300.0


@dataclass(frozen=True, kw_only=True)
class TestSet:
    """A folder of test maps, with the settings that IR2 has for it."""

    team: int
    most_steps: int
    most_nodes: int
    """Nodes of a global graph from which on it is thinned at every step."""


SETS = {
    "hybrid": TestSet(team=4, most_steps=196, most_nodes=200),
    "corridor": TestSet(team=4, most_steps=196, most_nodes=200),
    "complex": TestSet(team=5, most_steps=384, most_nodes=340),
}


@dataclass(frozen=True)
class Task:
    """A map of a test set, and the seed that draws the radio."""

    part: str
    map: str
    """File name."""
    seed: int


class Ir2Simulator:
    """The simulator in a process of its own."""

    def __init__(self, clone: Path, interpreter: str, *, mended: bool = False) -> None:
        """Check a clone; the process starts with the first episode.

        Args:
            clone: the folder of the clone.
            interpreter: the Python of an environment with :data:`NEEDS`.
            mended: whether every robot writes into a map of its own. In the simulator as it is, linked robots share one
                map, into which each still writes when the contact has ended, until its next move.

        Raises:
            InputError: the clone is not what is expected.

        """
        self.folder, self.mended = CODE.checked(clone), mended
        peer = Peer(interpreter=interpreter, folder=self.folder, script=SCRIPT, needs=NEEDS, time_limit=TIME_LIMIT)
        self.process = PeerProcess(peer)

    def tasks(self, part: str, wanted: Sequence[str] = ()) -> list[Task]:
        """Return tasks of a test set in the simulator's order: all 100, the first few for a number, or some by name.

        Raises:
            InputError: there is no such map.

        """
        folder = self.folder / "DungeonMaps/test" / part
        names = sorted((path.name for path in folder.glob("*.png")), reverse=True)
        if not names:
            raise InputError(f"{folder}: expected maps, found none; fetch them with `{CODE.how_to_fetch}`")
        seeds = {name: FIRST_SEED + k for k, name in enumerate(names[:TASKS])}
        return [Task(part, name, seeds[name]) for name in asked_maps(wanted, list(seeds))]

    def begin(self, task: Task) -> Turn:
        """Start an episode."""
        settings = SETS[task.part]
        return Turn.of(
            self.process.ask(
                "begin",
                **{"part": task.part, "name": task.map, "seed": task.seed, "mended": self.mended},
                **{"team": settings.team, "most_nodes": settings.most_nodes},
            )
        )

    def move(self, node: int) -> Turn:
        """Move the robot whose turn it is to a node."""
        return Turn.of(self.process.ask("move", node=node))
