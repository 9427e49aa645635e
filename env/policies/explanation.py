"""Why a UAV flies where it does: what a pilot chose among, with the scores and what they are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.policies.view import View

#: Most candidates of an explanation: the best ones.
MOST = 12
#: What is said of a policy whose pilots explain nothing.
SILENT = "this policy does not explain its actions"


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A cell that a UAV could choose."""

    cell: Cell
    """Row and column."""
    score: float
    """What the choice goes by: the larger, the better."""
    parts: Mapping[str, float] = field(default_factory=dict)
    """What the score is made of, by name, such as a gain and a number of steps."""


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """The latest choice of a UAV."""

    step: int
    """Step of the choice."""
    goal: Cell | None
    """Row and column of the goal; None without one."""
    candidates: tuple[Candidate, ...] = ()
    """What it chose among, the best first, at most ``MOST``; empty where the rule compares none."""
    score: str = ""
    """What the scores are, in a few words."""
    path: tuple[Cell, ...] = ()
    """The cells that are left of the way to the goal, from the UAV's on."""
    mates: Mapping[int, Cell] = field(default_factory=dict)
    """The cells to which it supposes that its teammates fly, by their numbers."""
    note: str = ""
    """What else there is to say, such as who chose instead of the rule; empty for nothing."""


def cell_text(cell: Sequence[int], levels: Levels | None = None) -> str:
    """Return a cell as text: its row and column, after its level on a map of several ``levels``."""
    place = cell if levels is None or levels.number == 1 else levels.voxel((cell[0], cell[1]))
    return f"({', '.join(map(str, place))})"


def sentence(told: Explanation | None, levels: Levels | None = None) -> str:
    """Return what an explanation says of the goal, and its note; ``levels`` are those of the map."""
    if told is None:
        return SILENT
    steps = len(told.path) - 1
    way = "" if steps < 1 else f", {steps} step{'s' * (steps > 1)} away"
    goal = "no goal"
    if told.goal is not None:
        goal = f"flies to {cell_text(told.goal, levels)}{way}, chosen at step {told.step}"
    return f"{goal}; {told.note}" if told.note else goal


def ranked(
    cells: NDArray[np.integer], width: int, scores: ArrayLike, parts: Mapping[str, ArrayLike]
) -> tuple[Candidate, ...]:
    """Return the best candidates among (K,) flat cells of a map ``width`` cells wide.

    ``scores`` and each of ``parts`` are (K,); candidates whose score is not finite are left out. Equal ones keep their
    order.
    """
    values = np.asarray(scores, np.float64)
    columns = {name: np.broadcast_to(np.asarray(each, np.float64), values.shape) for name, each in parts.items()}
    order = np.argsort(-values, kind="stable")
    order = order[np.isfinite(values[order])][:MOST]
    return tuple(
        Candidate(
            cell=divmod(int(cells[k]), width),
            score=float(values[k]),
            parts={name: float(each[k]) for name, each in columns.items()},
        )
        for k in order.tolist()
    )


def of_moves(
    view: View, action: int, scores: NDArray[np.floating], score: str, parts: Mapping[str, NDArray[np.floating]]
) -> Explanation:
    """Return the explanation of a move chosen by the ``scores`` (4,) or (5,) of all; ``parts`` are of the same size.

    The candidates are the cells that the moves lead to; illegal moves have a score that is not finite. A note says
    where ``action`` is not the move of the highest score, or is illegal, so that the UAV stays.
    """
    cells = np.asarray(view.cell) + MOVES[: len(scores)]
    inside = np.asarray(view.legal[: len(scores)], np.bool_)
    flat = np.where(inside, cells @ (view.belief.shape[1], 1), 0)
    values = np.where(inside, scores, -np.inf)
    own = not np.isfinite(values).any() or values[min(action, len(values) - 1)] < values.max()
    legal = bool(view.legal[action])
    row, col = MOVES[min(action, len(MOVES) - 1)].tolist() if legal else (0, 0)
    moved = view.cell[0] + row, view.cell[1] + col
    note = "not the move of the highest score" if own else ""
    return Explanation(
        step=view.step,
        goal=moved,
        candidates=ranked(flat, view.belief.shape[1], values, parts),
        score=score,
        path=(view.cell, moved),
        note=note if legal else "an illegal move: the UAV stays",
    )
