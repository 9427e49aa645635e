"""The picture of the choice of a planner: questions from top to bottom, each with the policy to fly if it is so.

Boxes are pale and the rest is transparent, for light and dark pages; it is narrow, for phones.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from matplotlib.figure import Figure

from indoor_explorers.evaluation.site.pictures.drawing import svg


class Step(NamedTuple):
    """A question and the policies to fly where its answer is yes."""

    question: str
    policies: tuple[str, ...]

    @property
    def answer(self) -> str:
        """The policies as the picture shows them."""
        return "\nor ".join(self.policies)


#: The questions in the order in which they are asked, and the policy where all answers are no.
STEPS = (
    Step("Is there a floor plan,\neven an outdated one?", ("prior-tour",)),
    Step("Does only what a home\nbase knows count?", ("return-to-base",)),
    Step("Do poses drift?", ("loop-closing",)),
    Step("A room of up to 600 cells,\na team?", ("horizon",)),
    Step("A room of up to 600 cells,\none UAV?", ("dddqn", "horizon")),
    Step("Rooms along corridors,\none UAV?", ("frontier-predictive", "dddqn")),
)
OTHERWISE = "frontier"
#: Inches of the picture, of half a box of a question and of an answer, and between rows.
WIDTH, QUESTION, ANSWER, DOWN = 4.0, 1.02, 0.73, 0.72
#: Where the middles of questions and answers are, in inches from the left.
LEFT, RIGHT = 1.06, 3.24
DARK, LINE, PALE, GREEN = "#1f2329", "#808690", "#e8eef7", "#dff0e3"


def which_planner_pictures() -> dict[str, bytes]:
    """Return the SVG file of the choice by name."""
    return {"which-planner.svg": svg(_draw)}


def _draw(figure: Figure) -> None:
    """Draw a row for each question, and the last answer below them."""
    height = DOWN * (len(STEPS) + 1)
    figure.set_size_inches(WIDTH, height)
    figure.set_facecolor("none")
    figure.set_layout_engine("none")
    axes: Any = figure.add_axes((0, 0, 1, 1), xlim=(0, WIDTH), ylim=(-height + DOWN / 2, DOWN / 2))
    axes.set_axis_off()
    for row, step in enumerate(STEPS):
        here = -row * DOWN
        _box(axes, LEFT, here, QUESTION, step.question, PALE)
        _box(axes, RIGHT, here, ANSWER, step.answer, GREEN, weight="bold")
        _arrow(axes, (LEFT + QUESTION, here), (RIGHT - ANSWER, here), "yes")
        _arrow(axes, (LEFT, here - 0.23), (LEFT, here - DOWN + 0.23), "no")
    _box(axes, LEFT, -len(STEPS) * DOWN, QUESTION, OTHERWISE, GREEN, weight="bold")


def _box(axes: Any, x: float, y: float, half: float, text: str, colour: str, weight: str = "normal") -> None:
    """Draw a text in a box with its middle at (x, y)."""
    axes.fill((x - half, x + half, x + half, x - half), (y - 0.23, y - 0.23, y + 0.23, y + 0.23), colour, zorder=1)
    axes.text(x, y, text, ha="center", va="center", fontsize=9, color=DARK, weight=weight, zorder=2)


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float], label: str) -> None:
    """Draw an arrow with a label on it."""
    style = {"arrowstyle": "-|>", "color": LINE, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=style)
    plate = {"boxstyle": "round,pad=0.12", "facecolor": "#f4f4f4", "edgecolor": "none"}
    middle = (start[0] + 0.46 * (end[0] - start[0]), start[1] + 0.4 * (end[1] - start[1]))
    axes.text(*middle, label, ha="center", va="center", fontsize=8, color=DARK, bbox=plate)
