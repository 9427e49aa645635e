"""The thesis's figures 4.1 to 4.20, of the trainings in ``thesis.csv``: as it was on the left, mended on the right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator

from indoor_explorers.env import FREE, UNKNOWN, World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.state import End
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, fixed, percent
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import percent_axis
from indoor_explorers.evaluation.site.pictures.drawing import MARKED, UAV, cells, svg
from indoor_explorers.evaluation.site.pictures.map_marks import legend as map_legend
from indoor_explorers.evaluation.site.pictures.map_marks import line, mark, uav_at
from indoor_explorers.evaluation.site.pictures.thesis_lines import LABELS, SEEDS, Curve, Pair, curve_legend, draw_greedy
from indoor_explorers.evaluation.site.studies.thesis import VERSIONS, pairs, replayed
from indoor_explorers.evaluation.studies.thesis.drawing import BUDGET, draw_scores, greedy_curve, hue_of, training_curve

#: Inches; wide enough for two panels whose labels are legible on a phone.
WIDTH, ROW, FLIGHT = 5.2, 1.65, 2.6
#: Of the dots, which as vectors would be most of the file.
DPI = 240
#: Seeds for trials of three flights of the shipped weights: a round is enough, one is stuck after it, one before.
CIRCLES = (37, 31, 10)
#: Colours of UAVs, as in the thesis the first is blue; and how UAVs end, with their marks.
UAVS = tuple(COLOURS[k][0] for k in (0, 1, 2, 3))
_CRASHED, _STUCK = ("crashed", {"marker": "X", "markersize": 9}), ("stuck", {"marker": "s", "markersize": 7})
ENDS: dict[End, tuple[str, dict[str, Any]]] = {
    End.COLLISION: _CRASHED,
    End.OUT_OF_BOUNDS: _CRASHED,
    End.STUCK: _STUCK,
}


class Row(NamedTuple):
    """Two panels side by side."""

    title: str
    draw: Callable[[Axes, int], None]
    """Draws the panel of a version, by its place."""
    height: float = ROW


def thesis_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    drawn: dict[str, Callable[[Figure], None]] = {
        "rewards-1": partial(_rewards, scores="4.1", explored="4.2", group="rewards-1"),
        "circle": _circle,
        "rewards-2": partial(_rewards, scores="4.4", explored="4.5", group="rewards-2"),
        "rewards-3": partial(_rewards, scores="4.6", explored="4.7", group="rewards-3"),
        "open": _open,
        "obstacles": _obstacles,
        "two": _two,
        "radio": _radio,
        "four": _four,
    }
    return {f"thesis-{name}.svg": svg(draw) for name, draw in drawn.items()}


def _all(name: str) -> list[Pair]:
    """Return the trainings of an experiment, a pair for each seed."""
    return [pair for pair in pairs() if pair[0].run.experiment.name == name]


def _distinct(group: str) -> list[tuple[str, Pair]]:
    """Return the trainings of a reward scenario with the letters of their rules; equal trainings are one."""
    found: dict[Any, tuple[str, Pair]] = {}
    for pair in pairs():
        if pair[0].run.experiment.group == group:
            letter = "abc"[int(pair[0].run.experiment.name[-1])]
            same = (pair[0].seed, *(training.run.scores.tobytes() for training in pair))
            found[same] = (found[same][0] + letter if same in found else letter, pair)
    trained = sorted(found.values(), key=lambda each: each[1][0].seed)
    return [(letters.replace("abc", f"a{EN_DASH}c"), pair) for letters, pair in trained]


def _sheet(figure: Figure, rows: Sequence[Row], legend: Sequence[Line2D], columns: int = 4) -> None:
    """Draw rows of two panels, and a legend below all."""
    figure.set_dpi(DPI)
    figure.set_size_inches(WIDTH, sum(row.height for row in rows) + 0.25 * -(-len(legend) // columns))
    panels = figure.subplots(len(rows), 2, height_ratios=[row.height for row in rows], squeeze=False)
    for row, pair in zip(rows, panels, strict=True):
        if row.height == ROW:
            pair[1].sharey(pair[0])
        for k, axes in enumerate(pair):
            row.draw(axes, k)
            axes.set_title(LABELS[k] if k else f"{row.title}, {LABELS[k]}")
        if row.height == ROW:
            pair[1].tick_params(labelleft=False)
            pair[1].set_ylabel("")
    if legend:
        map_legend(figure, legend, columns)


def _scores(title: str, pair: Pair) -> Row:
    """Return the row with the score of each training episode."""

    def draw(axes: Axes, k: int) -> None:
        training = pair[k]
        look = {"color": hue_of(VERSIONS, VERSIONS[k]), "markersize": 3.2, "rasterized": True}
        draw_scores(axes, training.run.scores, training.every, **look)
        axes.set(xlabel="training episode", ylabel="score", xlim=(0, len(training.run.scores) * training.every))
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: fixed(value, 0)))

    return Row(f"{title}, seed {pair[0].seed}", draw)


def _explored(title: str, curves: Sequence[Curve], *, greedy: bool = False) -> Row:
    """Return the row with the mean explored share by step: of training episodes still flying, or of greedy ones."""

    def draw(axes: Axes, k: int) -> None:
        for curve in curves:
            training = curve.pair[k]
            shares = (greedy_curve if greedy else training_curve)(training.run)
            look: dict[str, Any] = {"color": curve.colour or hue_of(VERSIONS, VERSIONS[k]), "linewidth": 1.4}
            look["linestyle"] = SEEDS[training.seed]
            axes.plot(np.arange(len(shares)), shares, **look)
        axes.axhline(0.9, color="#999999", linewidth=0.6, linestyle=(0, (1, 2)))
        axes.set(xlim=(0, BUDGET), ylim=(0, 1.02), xlabel="step", ylabel="explored")
        percent_axis(axes.yaxis)

    return Row(title, draw)


def _greedy(title: str, trained: Sequence[Pair]) -> Row:
    """Return the row with the greedy evaluations during training."""

    def draw(axes: Axes, k: int) -> None:
        for pair in trained:
            draw_greedy(axes, pair[k].run.greedy, pair[k].seed)

    return Row(title, draw)


def _flights(title: str, pair: Pair) -> Row:
    """Return the row with a greedy episode of each version."""
    return Row(f"{title}, seed {pair[0].seed}", lambda axes, k: _flight(axes, replayed(pair[k])), FLIGHT)


def _rewards(figure: Figure, scores: str, explored: str, group: str) -> None:
    trained = _distinct(group)
    rows = [_scores(scores + letters, pair) for letters, pair in trained]
    rows.append(_explored(explored, [Curve(pair) for _, pair in trained]))
    rows.append(_greedy(f"{scores}c, greedy", _all(f"{group}-stuck-2")))
    _sheet(figure, rows, curve_legend(greedy=True, seeds=True), 3)


def circle(seed: int) -> Iterator[World]:
    """Yield the world at the start and after each step of an episode of the shipped weights in the empty room."""
    policy, world = make_policy("dddqn-thesis"), World(scenario("thesis-rewards-1-stuck-2"))
    world.reset([seed])
    yield world
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        yield world


def _circle(figure: Figure) -> None:
    figure.set_size_inches(WIDTH, 2.5)
    for axes, seed in zip(figure.subplots(1, len(CIRCLES)), CIRCLES, strict=True):
        _flight(axes, circle(seed))
        axes.set_title(f"4.3, seed {seed}")
    start, *_, stuck = _marks(1)
    map_legend(figure, [start, stuck], 2)


def _flight(axes: Any, states: Iterator[World]) -> None:
    """Draw an episode: what the team has explored, the path of each UAV, and where it ended."""
    paths = []
    for world in states:
        paths.append(world.state.cell[0].copy())
    state, by_uav = world.state, np.array(paths, np.float64).swapaxes(0, 1)
    seen = (state.union[0] != UNKNOWN) & (state.truth[0] == FREE)
    ends = [End(int(end)) for end in state.end[0]]
    ended = ", ".join(
        f"{count} {end}" if len(ends) > 1 else end for end, count in Counter(map(_end_name, ends)).items()
    )
    cells(axes, np.where(seen, MARKED, state.truth[0]), "")
    for uav, (path, end) in enumerate(zip(by_uav, ends, strict=True)):
        beside = 0.16 * (uav - (len(ends) - 1) / 2)  # so that equal paths are both visible
        look = {"color": UAVS[uav], "zorder": 4}
        line(axes, path + beside, **look)
        uav_at(axes, tuple(path[0] + beside), color=UAVS[uav], clip_on=False)
        if end in ENDS:
            uav_at(axes, tuple(path[-1] + beside), color=UAVS[uav], clip_on=False, **ENDS[end][1])
    said = f"{percent(float(world.team_coverage[0]))} in {len(paths) - 1} steps: {ended}"
    axes.text(0.5, -0.03, said, transform=axes.transAxes, ha="center", va="top")


def _end_name(end: End) -> str:
    return ENDS[end][0] if end in ENDS else "goal" if end == End.GOAL else "budget"


def _marks(team: int) -> list[Line2D]:
    """Return the legend of flights: UAVs at their starts, and how they ended."""
    uavs = [mark(f"UAV {uav + 1}" if team > 1 else "start", **UAV | {"color": UAVS[uav]}) for uav in range(team)]
    crash, stuck = (dict(look) | {"color": "#444444"} for _, look in (ENDS[End.COLLISION], ENDS[End.STUCK]))
    return [*uavs, mark("crashed", **crash), mark("stuck", **stuck)]


def _open(figure: Figure) -> None:
    groups = ("rewards-1", "rewards-2", "rewards-3")
    colours = {group: COLOURS[k][0] for k, group in enumerate(groups)}
    curves = [
        Curve(pair, group.replace("-", " "), colour)
        for group, colour in colours.items()
        for _, pair in _distinct(group)
    ]
    rows = [_explored("4.8", curves), _explored("4.8, greedy", curves, greedy=True)]
    _sheet(figure, rows, curve_legend(curves, seeds=True), 5)


def _obstacles(figure: Figure) -> None:
    trained = _all("obstacles-1")
    rows = [_scores("4.9", pair) for pair in trained]
    rows += [_greedy("4.9, greedy", trained), _flights("4.10", trained[0])]
    _sheet(figure, rows, curve_legend(greedy=True, seeds=True) + _marks(1), 3)


def _two(figure: Figure) -> None:
    pair = _all("team-2-radio-0")[0]
    rows = [_scores("4.11", pair), _greedy("4.11, greedy", [pair]), _flights("4.12", pair)]
    _sheet(figure, rows, curve_legend(greedy=True) + _marks(2))


def _radio(figure: Figure) -> None:
    teams = _teams("team-2")
    pair_of = {curve.pair[0].run.experiment.name: curve.pair for curve in teams}
    rows = [
        _scores("4.13", pair_of["team-2-radio-1"]),
        _scores("4.14", pair_of["team-2-radio-3"]),
        _flights("4.15", pair_of["team-2-radio-1"]),
        _explored("4.16", teams),
        _explored("4.16, greedy", teams, greedy=True),
    ]
    _sheet(figure, rows, curve_legend(teams) + _marks(2), 3)


def _four(figure: Figure) -> None:
    pair, teams = _all("team-4-radio-0")[0], _teams("obstacles", "team")
    rows = [
        _flights("4.17", pair),
        _scores("4.18", pair),
        _explored("4.19, 4.20", teams),
        _explored("4.20, greedy", teams, greedy=True),
    ]
    _sheet(figure, rows, curve_legend(teams) + _marks(4), 3)


def _teams(*starts: str) -> list[Curve]:
    """Return the trainings of the first seed of the experiments among obstacles whose names start so."""
    found = [pair for pair in pairs() if pair[0].seed == 1 and pair[0].run.experiment.name.startswith(starts)]
    return [Curve(pair, pair[0].run.experiment.title, COLOURS[k][0]) for k, pair in enumerate(found)]
