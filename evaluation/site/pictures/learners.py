"""The pictures of the pages on learners: what the DDDQN sees, its network, and the values of one view's moves."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch
from numpy.typing import NDArray

from indoor_explorers.env import Action, World, scenario
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.evaluation.site.pictures.clusters import places, pockets
from indoor_explorers.evaluation.site.pictures.drawing import PLATE, UAV, cells, fly_steps, svg
from indoor_explorers.learners.dddqn.network.inference import NetworkWeights, q_values, without_network
from indoor_explorers.learners.dddqn.observation.layout import BEYOND, BLOCKED, GAINS, TOURS, VISITS
from indoor_explorers.learners.dddqn.policy import Dddqn
from indoor_explorers.learners.dddqn.weights import LoadedWeights, load_weights, shipped

#: The weights and the view that are shown: a seed for trials, and a step at which network and rule choose other moves.
NAME, SEED, STEP = "thesis-obstacles", 2, 9
MOVE_NAMES = tuple(action.name.lower() for action in Action)[:4]
#: The parts of a move's value besides V: name, colour, and the arrays of weights that make it.
TERMS = (
    ("the move's features, linear", "#0072b2", ("tours",)),
    ("the move's features, two layers", "#56b4e9", ("move_out", "move_out_bias")),
    ("all that is seen", "#e69f00", ("advantage", "advantage_bias")),
)
#: Colours of the network's move and of the rule's, of lines, and of pixels off the map.
CHOSEN, BY_RULE, LINE, OFF = "#d55e00", "#0072b2", "#444444", "#dddddd"
#: Colours of inputs, layers and outputs, and the size of a box in the diagram.
INPUT, LAYER, OUTPUT = "#dbe9f6", "#f4f4f4", "#fbe3cf"
WIDTH, HEIGHT = 2.6, 0.9
#: Which box leads to which.
ARROWS = (
    *(("image", "look"), ("look", "think"), ("moves", "below"), ("moves", "own"), ("moves", "tours")),
    *(("think", "value"), ("think", "all"), ("value", "q"), ("all", "q"), ("own", "q"), ("tours", "q")),
)


class Moment(NamedTuple):
    """Observation, features and values of the network at one step."""

    belief: NDArray[np.uint8]
    cell: tuple[int, int]
    scene: NDArray[np.float64]
    """(S,) from 0 to 1."""
    moves: NDArray[np.float32]
    """(4, F)."""
    q: NDArray[np.float32]
    """(4,) the values of the moves."""
    terms: list[NDArray[np.float32]]
    """(4,) the part of the values for each of ``TERMS``, less its mean; with V they add up to ``q``."""
    rule: NDArray[np.float32]
    """(4,) the values by the rule of ``tours``."""


def learner_pictures() -> dict[str, bytes]:
    """Return the SVG files of the pages by name."""
    drawn = {"sees": _sees, "network": _network, "values": _values, "places": places, "pockets": pockets}
    return {f"learner-{name}.svg": svg(draw) for name, draw in drawn.items()}


def _loaded() -> LoadedWeights:
    return load_weights(shipped()[NAME])


@cache
def moment() -> Moment:
    """Return the view of ``SEED`` after ``STEP`` steps of the shipped policy."""
    policy, loaded = Dddqn(), _loaded()
    world = World(scenario(NAME).for_evaluation())
    world.reset([SEED])
    pilot: Any = fly_steps(world, policy, STEP)[0, 0]
    view = world.view(0, 0)
    pilot.act(view)

    def value(weights: NetworkWeights) -> NDArray[np.float32]:
        q = np.zeros(4, np.float32)
        q_values(pilot.scenes, pilot.moves, weights, q[None])
        return q

    parts = {part for _, _, parts in TERMS for part in parts} | {"value", "value_bias"}
    terms = [value(_silent(loaded.weights, parts.difference(kept))) for _, _, kept in TERMS]
    rule = value(without_network(loaded.weights, loaded.layout))
    scene = pilot.scenes[0] / 255.0
    return Moment(np.array(view.belief), view.cell, scene, pilot.moves[0].copy(), value(loaded.weights), terms, rule)


def _silent(weights: NetworkWeights, parts: set[str]) -> NetworkWeights:
    return weights._replace(**{part: np.zeros_like(getattr(weights, part)) for part in parts})


def _sees(figure: Figure) -> None:
    seen, loaded = moment(), _loaded()
    layout, layers = loaded.layout, loaded.observation.layers
    figure.set_size_inches(7.0, 4.5)
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.0, 1.12))
    left, right = halves
    axes = left.subplots(3, 2).ravel()
    cells(axes[0], seen.belief, "", [seen.cell])
    for k, layer in enumerate(layers):
        _plane(axes[1 + k], seen, int(layout.layers[layout.layers >= 0][k]), layout.crop, 1, layer)
    for k, name in enumerate(("unknown", "free")):
        at = layout.coarse_at + k * layout.coarse**2
        _plane(axes[1 + len(layers) + k], seen, at, layout.coarse, 3, f"coarse: {name}")
    axes[0].set_title("what the UAV knows", fontsize=8.0)
    left.supxlabel("white 0, dark 1, hatched: off the map", fontsize=7.5)
    _features(right.subplots(), seen, layout.sides_at)


def _plane(axes: Any, seen: Moment, at: int, side: int, scale: int, name: str) -> None:
    """Draw a map of the image, whose pixels are ``scale`` cells wide."""
    plane = seen.scene[at : at + side * side].reshape(side, side)
    axes.patch.set(hatch="//////", edgecolor=OFF)
    tops = np.array(seen.cell)[:, None] - side * scale // 2 + scale * np.arange(side)
    rows, cols = (tops + scale > 0) & (tops < np.array(seen.belief.shape)[:, None])
    there = rows[:, None] & cols
    axes.imshow(np.ma.masked_where(~there, plane), cmap="Blues", vmin=0, vmax=1, interpolation="nearest")
    axes.plot(side // 2, side // 2, **UAV | {"markersize": 4})
    axes.set(xticks=[], yticks=[])
    axes.spines[["top", "right"]].set_visible(True)
    axes.set_title(f"{name}, {side}x{side}", fontsize=8.0)


def _features(axes: Any, seen: Moment, sides_at: int) -> None:
    """Draw the numbers about each move as a table, the map image's sides first."""
    table = np.vstack([seen.scene[sides_at : sides_at + 4], seen.moves.T])
    names = ["unknown cells on that side", *BLOCKED, *GAINS, *VISITS, *TOURS]
    axes.imshow(table, cmap="Blues", vmin=0, vmax=1.8, aspect="auto", interpolation="nearest")
    for (row, col), number in np.ndenumerate(table):
        axes.text(col, row, f"{number:.2f}", ha="center", va="center", fontsize=6.5)
    ends = np.cumsum([0, 2, len(GAINS), len(VISITS), len(TOURS)]) - 0.5
    axes.hlines(ends[1:-1], -0.5, 3.5, color=LINE, linewidth=0.8)
    for start, end, name in zip(ends[1:], ends[2:], ("gains", "", "tours"), strict=False):
        axes.text(3.6, (start + end) / 2, name, rotation=270, va="center", fontsize=7.5)
    axes.set_xticks(range(4), MOVE_NAMES, fontsize=7.5)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.tick_params(length=0, top=True, bottom=False, labeltop=True, labelbottom=False)
    axes.spines[:].set_visible(False)
    axes.set_title("about each move", fontsize=8.0)


def _network(figure: Figure) -> None:
    loaded = _loaded()
    weights, layout = loaded.weights, loaded.layout
    inputs, width = weights.look.shape
    features, small = weights.move_hidden.shape
    after = "layer norm, ReLU" if weights.layer_norm else "ReLU"
    fine = f"{len(loaded.observation.layers)} maps of {layout.crop}x{layout.crop}"
    planes = f"{fine},\n2 of {layout.coarse}x{layout.coarse}; 4 sides"
    shared = f"for each move:\n{features} to"
    boxes = {
        "image": (0.0, 3.0, INPUT, LINE, f"map image: {inputs}\n{planes}"),
        "moves": (0.0, 0.6, INPUT, LINE, f"4 moves with\n{features} features each"),
        "look": (3.3, 3.0, LAYER, LINE, f"linear, {inputs} to {width}\n{after}"),
        "think": (6.6, 3.0, LAYER, LINE, f"linear, {weights.think.shape[0]} to {width}\n{after}"),
        "value": (9.9, 3.6, OUTPUT, LINE, f"V: linear,\n{width} to {weights.value.shape[1]}"),
        "all": (9.9, 2.4, OUTPUT, TERMS[2][1], f"for all moves:\nlinear, {width} to {weights.advantage.shape[1]}"),
        "own": (6.6, 1.2, OUTPUT, TERMS[1][1], f"{shared} {small}, ReLU, to {weights.move_out.shape[1]}"),
        "tours": (6.6, 0.0, OUTPUT, TERMS[0][1], f"{shared} 1, linear"),
        "q": (13.2, 1.8, OUTPUT, LINE, "A: sum of the three\nQ = V + A - mean A\nof 4 moves"),
    }
    figure.set_size_inches(7.0, 2.6)
    axes = figure.subplots()
    for x, y, face, edge, text in boxes.values():
        look: dict[str, Any] = {"facecolor": face, "edgecolor": edge, "linewidth": 0.8 if edge == LINE else 2.0}
        axes.add_patch(FancyBboxPatch((x, y - HEIGHT / 2), WIDTH, HEIGHT, boxstyle="round,pad=0.08", **look))
        axes.text(x + WIDTH / 2, y, text, ha="center", va="center", fontsize=6.6)
    ends = {name: (x - 0.1, y) for name, (x, y, *_) in boxes.items()}
    ends["below"] = (boxes["think"][0] + WIDTH / 2, boxes["think"][1] - HEIGHT / 2 - 0.1)
    for one, other in ARROWS:
        start = boxes[one][0] + WIDTH + 0.1, boxes[one][1]
        axes.annotate("", ends[other], start, arrowprops={"arrowstyle": "->", "color": LINE, "linewidth": 0.8})
    axes.set(xlim=(-0.1, 13.3 + WIDTH), ylim=(-0.6, 4.2))
    axes.set_axis_off()
    size = sum(part.size for part in weights if isinstance(part, np.ndarray))
    axes.set_title(f"{NAME}: {size:,} weights")


def _values(figure: Figure) -> None:
    seen, layout = moment(), _loaded().layout
    figure.set_size_inches(7.0, 2.9)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.6))
    cells(left, seen.belief, f"{NAME}, seed {SEED}, step {STEP}", [seen.cell])
    for values, colour, name in ((seen.q, CHOSEN, "network"), (seen.rule, BY_RULE, "rule")):
        row, col = MOVES[int(values.argmax())].tolist()
        to = seen.cell[1] + 2.2 * col, seen.cell[0] + 2.2 * row
        left.annotate("", to, seen.cell[::-1], arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.8})
        side = "left" if col > 0 else "right"
        left.text(to[0] + 0.3 * col, to[1], name, ha=side, va="center", color=colour, weight="bold", bbox=PLATE)
    wide = 0.8 / len(TERMS)
    for n, (name, colour, _) in enumerate(TERMS):
        right.bar(np.arange(4) + (n - 1) * wide, seen.terms[n], wide, color=colour, label=name)
    right.plot(range(4), np.sum(seen.terms, axis=0), "D", color="#1b1f24", markersize=4, label="their sum, Q - V")
    right.axhline(0, color=LINE, linewidth=0.8)
    beyond = [
        BEYOND * seen.moves[:, layout.tours_at + TOURS.index(f"its steps beyond the shortest{mark}")]
        for mark in ("", " to 90 %")
    ]
    labels = zip(MOVE_NAMES, seen.q, *beyond, strict=True)
    right.set_xticks(
        range(4), [f"{name}\nQ {q:.2f}\n{goal:+.1f} / {mark:+.1f}" for name, q, goal, mark in labels], fontsize=7.5
    )
    right.set(ylabel="part of Q - V")
    right.set_xlabel("below Q: steps beyond the shortest tour to 99 % / 90 %", fontsize=7.5)
    figure.legend(loc="outside upper center", ncols=4, fontsize=7.5, handlelength=1.4)
