"""DARE's expert planner, the TARE of its simulator, as a policy: ``dare-expert:DIR`` of a clone."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import ALL_CELLS, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded
from indoor_explorers.planners.toolbox.peers.dare import DARE, EXPERT_NEEDS
from indoor_explorers.planners.toolbox.peers.process import Peer, PeerProcess

SCRIPT = Path(__file__).with_name("dare_expert_script.py")
#: The variable that names the interpreter, and where it is sought in the clone otherwise.
PYTHON, IN_CLONE = "DARE_PYTHON", ".venv/bin/python"


@dataclass(frozen=True, kw_only=True)
class DareExpert(Parameters, Policy):
    """Fly from node to node of DARE's graph as its expert planner chooses, which tours viewpoints as TARE does.

    It knows only what the UAV has seen. Nodes are a fifth of the lidar range apart, as in DARE's simulator; the UAV
    scans on the way between them too, which the robot there does not. Where the planner has nothing left, or its nodes
    cannot be reached, the UAV flies to the nearest frontier cell. Each UAV plans alone, in a process of its own.

    Y. Cao, J. Lew, J. Liang, J. Cheng, G. Sartoretti, "DARE: diffusion policy for autonomous robot exploration", ICRA
    2025, doi:10.1109/ICRA55743.2025.11128196; C. Cao, H. Zhu, H. Choset, J. Zhang, "TARE: a hierarchical framework for
    efficiently exploring complex 3D environments", RSS 2021, doi:10.15607/RSS.2021.XVII.018.

    Raises:
        InputError: ``clone`` is not a clone of DARE at the commit expected, or there is no interpreter.

    """

    plans_for: ClassVar[str] = ALL_CELLS

    clone: str
    """Path of the clone."""
    python: str = ""
    """The Python interpreter of an environment with the planner's packages; empty for the one that the variable
    DARE_PYTHON names, or else ``.venv/bin/python`` in the clone."""
    time_limit: float = bounded(50.0, least=0.01)
    """Seconds that a plan may take."""

    def __post_init__(self) -> None:
        super().__post_init__()
        DARE.checked(self.clone)
        if shutil.which(python := self.interpreter) is None:
            packages = " ".join(f"'{need.requirement}'" for need in EXPERT_NEEDS)
            environment = Path(self.clone, ".venv")
            raise InputError(
                f"{python}: expected the Python interpreter of an environment for DARE, found none; make one with "
                f"`python -m venv {environment} && {environment}/bin/pip install {packages}`, or name one as {PYTHON}"
            )

    @property
    def interpreter(self) -> str:
        """The path of the interpreter."""
        return str(expanded(self.python or os.environ.get(PYTHON) or Path(self.clone, IN_CLONE)))

    def process(self) -> PeerProcess:
        """Return a process of the planner, not started yet."""
        return PeerProcess(
            Peer(
                interpreter=self.interpreter,
                folder=expanded(self.clone).resolve(),
                script=SCRIPT,
                needs=EXPERT_NEEDS,
                time_limit=self.time_limit,
            )
        )

    def pilot(self, briefing: Briefing) -> DareExpertPilot:
        """Make the pilot of one UAV for one episode."""
        return DareExpertPilot(briefing, self.process())

    def provenance(self) -> dict[str, str]:
        """Return the commit of the clone and the versions of the packages."""
        with self.process() as process:
            process.start()
            versions = {f"peer_{name}": version or "?" for name, version in process.versions.items()}
        return {"peer_commit": DARE.commit, "peer_python": str(process.python), **versions}


class DareExpertPilot(GoalPilot):
    """Fly to the first node of the planner's way, and plan again there.

    Args:
        briefing: Briefing of the UAV.
        process: The planner's process, which ends with the pilot.

    """

    straight = True

    def __init__(self, briefing: Briefing, process: PeerProcess) -> None:
        super().__init__(briefing)
        self._process, self._begun = process, False
        self._seed = int(briefing.rng.integers(2**32))
        self._to_frontier = False
        self._none, self._lost = 0, 0

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether the node is reached, or the frontier cell is none any more."""
        return view.cell == goal or (self._to_frontier and super().is_spent(view, goal))

    def choose(self, view: View) -> Cell | None:
        """Return the next node, or else the nearest frontier cell."""
        path = self._path(view)
        cells = np.asarray(self.paths.flat(path), np.int32)
        open_ = (self.steps_from(view, view.cell).ravel()[cells] < UNREACHABLE) & ~self.near_banned(view, cells)
        goals = cells[open_ & (cells != self.paths.flat([view.cell])[0])]
        self._to_frontier = not len(goals)
        self._none += not len(path)
        self._lost += bool(len(path)) and self._to_frontier
        return self.nearest_frontier(view) if self._to_frontier else divmod(int(goals[0]), self.paths.width)

    def tally(self) -> dict[str, float]:
        """Return also how often the planner had nothing left, and how often none of its nodes could be reached."""
        return super().tally() | {"nothing_left": float(self._none), "unreachable_nodes": float(self._lost)}

    def _path(self, view: View) -> NDArray[np.int32]:
        """Return the cells (K, 2) of the planner's way."""
        if not self._begun:
            self._process.ask("begin", lidar_range=float(self.briefing.lidar_range), seed=self._seed)
            self._begun = True
        row, col = view.cell
        steps = self.steps_from(view, view.cell)
        path: NDArray[np.int32] = self._process.ask("plan", belief=view.belief, steps=steps, row=row, col=col)["path"]
        return path


def opened(path: str, **parameters: Any) -> DareExpert:
    """Return the planner of a clone, ``dare-expert:DIR``."""
    return DareExpert(clone=path, **parameters)
