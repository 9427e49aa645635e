"""Writes the notebook ``notebooks/first.ipynb`` with the outputs of a real run; Jupyter is not needed for that.

    python -P -m indoor_explorers.evaluation.site.notebook

runs the cells in order, as ``__main__`` in an empty folder, and stores what they print (nbformat 4.5).
"""

from __future__ import annotations

import io
import json
import subprocess
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from indoor_explorers.env.files import write_whole

NOTEBOOK = Path(__file__).parent / "notebooks" / "first.ipynb"
#: The ten cells: texts begin with a heading, all others are Python.
CELLS = (
    """\
# A first comparison

A UAV with a lidar explores a room that it does not know. This notebook flies one episode, writes a planner of its
own, compares it with two others, and says where to see every flight. Install the package first (`pip install -c
constraints.txt .`); the first run compiles for some seconds. `python -P -m indoor_explorers.evaluation.site.notebook`
has written the outputs.
""",
    """\
from indoor_explorers.env import World, make_policy, scenario

world = World(scenario("thesis-obstacles"))
world.reset(seeds=[3])
pilot = make_policy("frontier").pilot(world.briefing(0, 0))
steps = 0
while world.flying.any():
    world.step([[pilot.act(world.view(0, 0))]])
    steps += 1
print(f"{world.team_coverage[0]:.1%} of the free cells known after {steps} steps")
""",
    """\
## A planner of your own

A policy is what all UAVs share, a pilot flies one of them. It sees its own map, its cell and the legal moves, never
the true map. This one flies to the neighbouring cell that it has visited least.
""",
    """\
from dataclasses import dataclass

import numpy as np

from indoor_explorers.env import Briefing, Pilot, Policy, View

MOVES = np.array([(1, 0), (0, -1), (-1, 0), (0, 1)])  # down, left, up, right: the numbers of the actions


class NoveltyPilot(Pilot):
    def __init__(self, briefing: Briefing) -> None:
        self.rng, self.visits = briefing.rng, {}

    def act(self, view: View) -> int:
        here = tuple(view.cell)
        self.visits[here] = self.visits.get(here, 0) + 1
        legal = self.rng.permutation(np.flatnonzero(view.legal[:4]))
        if not len(legal):
            return 4  # stay
        return int(min(legal, key=lambda move: self.visits.get(tuple(view.cell + MOVES[move]), 0)))


@dataclass(frozen=True, kw_only=True)
class Novelty(Policy):
    def pilot(self, briefing: Briefing) -> NoveltyPilot:
        return NoveltyPilot(briefing)
""",
    """\
## Compare it

All policies fly the same ten rooms from the same starts. A class of a notebook can be flown in this process alone,
`workers=0`, and has no file whose changes would be noticed, so `fresh` flies it anew. A planner in a file is flown by
all cores, is kept from the true map, and is not flown twice: `indoor-explorers new planner NAME` makes one.
""",
    """\
from indoor_explorers.evaluation import compare

policies = ["random", "frontier-nearest", "__main__:Novelty"]
table = compare("results/first", policies=policies, scenario="thesis-obstacles", episodes=10, workers=0, fresh=True)
print(len(table), "rows:", ", ".join(table.columns))
""",
    """\
## The table

T90 and T99 are the steps until 90 % and 99 % of the cells are known, AUC the mean coverage, with 95 % intervals. An
episode that never gets there counts as its budget. `table` is a DataFrame with every metric.
""",
    """\
print(table)
""",
    """\
## Watch the flights

`report.html` opens from disk, with the curves and every episode to replay step by step. This address opens the room
of seed 3, the one that was flown above, with two policies side by side.
""",
    """\
from pathlib import Path

report = Path("results/first/report.html")
assert report.exists()
print(f"{report}#replay=s1;task=0,3;panels=frontier-nearest,__main__%3ANovelty")
""",
)


def is_code(text: str) -> bool:
    """Return whether a cell is Python."""
    return not text.startswith("#")


def printed() -> list[str]:
    """Run the cells of code in this process, in order, as ``__main__``, and return what each prints."""
    found = []
    for number, text in enumerate(CELLS):
        if is_code(text):
            with redirect_stdout(io.StringIO()) as out:
                exec(compile(text, f"cell-{number}", "exec"), vars(sys.modules["__main__"]))
            found.append(out.getvalue())
    return found


def printed_by_a_process() -> list[str]:
    """Run the cells in a process of its own, in an empty folder, and return what each prints."""
    code = "import json; from indoor_explorers.evaluation.site.notebook import printed; print(json.dumps(printed()))"
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-c", code]
        done = subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True)
    return list(json.loads(done.stdout))


def notebook(outputs: list[str]) -> dict[str, Any]:
    """Return the notebook with the outputs of its cells of code."""
    left = iter(outputs)
    cells = [_code(k, text, next(left)) if is_code(text) else _text(k, text) for k, text in enumerate(CELLS)]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def _text(number: int, text: str) -> dict[str, Any]:
    return {"cell_type": "markdown", "id": f"cell-{number}", "metadata": {}, "source": _lines(text)}


def _code(number: int, text: str, printed: str) -> dict[str, Any]:
    outputs = [{"name": "stdout", "output_type": "stream", "text": printed.splitlines(keepends=True)}] * bool(printed)
    about = {"cell_type": "code", "execution_count": 1 + number // 2, "id": f"cell-{number}", "metadata": {}}
    return about | {"outputs": outputs, "source": _lines(text)}


def _lines(text: str) -> list[str]:
    return text.rstrip("\n").splitlines(keepends=True)


if __name__ == "__main__":
    write_whole(NOTEBOOK, json.dumps(notebook(printed_by_a_process()), indent=1, ensure_ascii=False) + "\n")
