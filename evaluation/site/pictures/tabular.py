"""The picture of the page on tabular learning: training curves, flown by the functions that the page shows."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.site.pictures.drawing import svg

PAGE = Path(__file__).resolve().parents[1] / "pages" / "guides" / "tabular.md"
#: Seeds of the trainings that a line is the mean of, and the episodes that it is smoothed over.
SEEDS, SMOOTHED = (1, 2, 3), 50
#: The states of the page and their colours, and the learners and their lines.
STATES = {name: colour for name, (colour, *_) in zip(("near", "place", "whole"), COLOURS, strict=False)}
LEARNERS: dict[str, Any] = {"Q-learning": "-", "Sarsa": (0, (3, 1.5))}


def tabular_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    return {"tabular-curves.svg": svg(_curves)}


@cache
def page_functions() -> dict[str, Any]:
    """Return what the script of the page defines, by name."""
    (script,) = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    names: dict[str, Any] = {"__name__": "tabular"}
    exec(compile(script, str(PAGE), "exec"), names)
    return names


def training(obstacles: int, state: str, learner: str, seed: int) -> tuple[Any, list[int]]:
    """Return the table of a training and the steps of each of its episodes."""
    names = page_functions()
    table, steps = names["train"](names["room"](obstacles), names[state], learner == "Sarsa", seed)
    return table, steps


def _smoothed(runs: list[list[int]]) -> NDArray[np.float64]:
    """Return the mean of some curves, and of each point with the episodes before it."""
    return np.convolve(np.mean(runs, axis=0), np.full(SMOOTHED, 1 / SMOOTHED), mode="valid")


def _curves(figure: Figure) -> None:
    figure.set_size_inches(7.0, 2.9)
    left, right = figure.subplots(1, 2, sharey=True)
    names = page_functions()
    for axes, obstacles, learners, title in (
        (left, 0, tuple(LEARNERS), "empty rooms"),
        (right, 2, ("Q-learning",), "rooms with two obstacles"),
    ):
        for state, colour in STATES.items():
            for learner in learners:
                curve = _smoothed([training(obstacles, state, learner, seed)[1] for seed in SEEDS])
                episodes = np.arange(SMOOTHED, SMOOTHED + len(curve))
                axes.plot(episodes, curve, color=colour, linestyle=LEARNERS[learner], linewidth=1.3)
        planner = mean(names["planner"](names["room"](obstacles), seed) for seed in names["TESTS"])
        axes.axhline(planner, color="black", linewidth=0.9, linestyle=(0, (1, 1.5)))
        axes.set(title=title, xlabel="training episodes", xlim=(0, names["EPISODES"]), ylim=(0, names["BUDGET"] + 2))
    left.set_ylabel("steps to explore the room")
    lines = [Line2D([], [], color=colour, label=state) for state, colour in STATES.items()]
    lines += [Line2D([], [], color="#666666", linestyle=style, label=name) for name, style in LEARNERS.items()]
    lines.append(Line2D([], [], color="black", linewidth=0.9, linestyle=(0, (1, 1.5)), label="frontier-nearest"))
    figure.legend(handles=lines, loc="outside lower center", ncols=6)
