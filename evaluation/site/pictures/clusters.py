"""The pictures of choices among frontier clusters, and of what is estimated behind them."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from indoor_explorers.env import FREE, UNKNOWN, World, make_policy, scenario
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.maps.sources import FloorsMaps
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.evaluation.site.pictures.drawing import MARKED, PLATE, cells, fly_steps
from indoor_explorers.learners.places import network
from indoor_explorers.learners.places.policy import DddqnPlaces
from indoor_explorers.learners.places.scene import Observer
from indoor_explorers.learners.pockets.examples import examples_of
from indoor_explorers.learners.pockets.validation import JUDGED, LIDAR_RANGE
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, frontier_clusters
from indoor_explorers.planners.toolbox.pockets.estimates import (
    SHIPPED,
    PocketEstimator,
    estimates_from,
    load_weights,
)
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS, outputs

#: The seeds and steps of the views that are shown; at the first one the two policies choose other places.
CHOICE, BELIEF = (14, 56), (100, 200)
#: Largest value and largest cost that have a colour and a label.
MOST = (1.5, 4.0)
#: The generated floors that estimates are compared with the truth on, and bins of probabilities.
FLOORS = FloorsMaps(height=96, width=120, area=(300.0, 1000.0))
SEEDS, BINS = range(100, 120), 5
#: Colours and markers of the thresholds; the colour of a chosen place.
CURVES = (("#0072b2", "o"), ("#d55e00", "s"), ("#008f68", "D"))
CHOSEN = "#d55e00"


class Choice(NamedTuple):
    """One view, and how two policies value its candidates."""

    belief: NDArray[np.uint8]
    cell: Cell
    clusters: list[NDArray[np.int32]]
    """(K,) the flat cells of the cluster of each place."""
    behind: NDArray[np.float32]
    """(K,) by how much a place's value is below the best one's."""
    costs: NDArray[np.float32]
    """(K,) by how much its cost for ``frontier-predictive`` is above the least, in lidar ranges."""
    goals: tuple[Cell, Cell]
    """The places that ``dddqn-places`` and ``frontier-predictive`` choose, both asked for the first time."""


@cache
def choice() -> Choice:
    """Return the view of ``CHOICE`` in ``small-floors``, flown by ``dddqn-places`` alone."""
    world = World(scenario("small-floors").with_settings({"team": 1}))
    world.reset([CHOICE[0]])
    fly_steps(world, make_policy("dddqn-places"), CHOICE[1])
    view, briefing, policy = world.view(0, 0), world.briefing(0, 0), DddqnPlaces()
    pilot: Any = policy.pilot(briefing)
    other: Any = make_policy("frontier-predictive").pilot(briefing)
    pilot.navigator.observe(view)
    scene: Any = Observer(pilot).observe(view)
    values = network.values(scene, network.load_weights(policy.path))
    other.act(view)
    found = frontier_clusters(view.belief, briefing.lidar_range)
    goals = divmod(int(scene.cells[values.argmax()]), briefing.shape[1]), other.goal
    clusters = [_cells_of(found, owner) for owner in scene.owner]
    return Choice(np.array(view.belief), view.cell, clusters, values.max() - values, scene.costs, goals)


def places(figure: Figure) -> None:
    """Draw the places of one view by their values, and by the costs for ``frontier-predictive``."""
    found = choice()
    figure.set_size_inches(7.0, 2.9)
    axes = figure.subplots(1, 2)
    titles = ("dddqn-places", "frontier-predictive")
    labels = ("value below that of the best place", "cost above that of the best place [lidar ranges]")
    shown = (found.behind, found.costs)
    for each, title, label, numbers, most, goal in zip(axes, titles, labels, shown, MOST, found.goals, strict=True):
        cells(each, found.belief, title, [found.cell])
        look = {
            "marker": "s",
            "cmap": "viridis",
            "norm": Normalize(0, most),
            "edgecolors": "#444444",
            "linewidths": 0.4,
        }
        for cluster, number in zip(found.clusters, numbers.tolist(), strict=True):
            rows, cols = np.divmod(cluster, found.belief.shape[1])
            points = each.scatter(cols, rows, 12, [number] * len(rows), **look)
            if number <= most:
                _label(each, rows.mean() - 1.5, cols.mean() + 1.5, f"{number:.1f}")
        each.plot(*goal[::-1], "o", markersize=12, markerfacecolor="none", markeredgecolor=CHOSEN, markeredgewidth=2.0)
        _crop(each, found.belief != UNKNOWN)
        figure.colorbar(points, ax=each, label=label, location="bottom", extend="max", aspect=30)


def _label(axes: Any, row: float, col: float, text: str) -> None:
    axes.text(col, row, text, fontsize=7.5, ha="center", va="center", bbox=PLATE)


def _cells_of(clusters: Clusters, number: int) -> NDArray[np.int32]:
    return clusters.cells[clusters.ends[number] : clusters.ends[number + 1]]


def _crop(axes: Any, shown: NDArray[np.bool_]) -> None:
    """Show some cells, and a margin around them."""
    rows, cols = np.nonzero(shown)
    axes.set(xlim=(cols.min() - 3, cols.max() + 3), ylim=(rows.max() + 3, rows.min() - 3))


def pockets(figure: Figure) -> None:
    """Draw what is estimated behind the clusters of one view and what is there, and how often estimates are right."""
    seed, steps = BELIEF
    world = World(scenario("floors").with_settings({"team": 1}))
    world.begin(0, seed, floorplan=FLOORS.floorplan(0, seed))
    fly_steps(world, make_policy("frontier-predictive"), steps)
    view, truth, reach = world.view(0, 0), world.state.truth[0], world.scenario.lidar.range
    belief = np.array(view.belief)
    clusters = frontier_clusters(belief, reach)
    sizes = PocketEstimator(reach).estimate(belief, clusters).sizes
    hidden = true_pockets(belief, truth, distance_field(belief, view.cell), clusters).sizes
    figure.set_size_inches(7.0, 3.3)
    left, right = figure.subplots(1, 2)
    unseen = (belief == UNKNOWN) & (truth == FREE)
    cells(left, np.where(unseen, MARKED, belief), "free cells behind clusters: estimated / true", [view.cell])
    for k in range(clusters.size):
        rows, cols = np.divmod(_cells_of(clusters, k), belief.shape[1])
        left.plot(cols, rows, "s", color=CHOSEN, markersize=2.5)
        _label(left, rows.mean() - 3, cols.mean(), f"{sizes[k]:.0f} / {hidden[k]:.0f}")
    _crop(left, unseen | (belief != UNKNOWN))
    _reliability(right)


def _reliability(axes: Any) -> None:
    """Draw the shares of clusters that hide more than some cells against the probabilities that were estimated."""
    flights = [examples_of(FLOORS.floorplan(0, seed), seed, LIDAR_RANGE) for seed in SEEDS]
    fine, coarse, numbers, sizes = (
        np.concatenate([flight[name] for flight in flights]) for name in ("fine", "coarse", "numbers", "sizes")
    )
    tails = estimates_from(outputs(fine, coarse, numbers, load_weights(SHIPPED))).tails
    axes.plot([0, 1], [0, 1], color="#888888", linewidth=0.8)
    for limit, (colour, marker) in zip(JUDGED, CURVES, strict=True):
        chance = tails[:, THRESHOLDS.index(limit)]
        bins = np.minimum((chance * BINS).astype(int), BINS - 1)
        there = [bins == k for k in range(BINS) if (bins == k).any()]
        points = [(chance[some].mean(), (sizes[some] > limit).mean()) for some in there]
        axes.plot(*np.transpose(points), color=colour, marker=marker, markersize=4.5, label=f"more than {limit} cells")
    axes.set(xlabel="estimated probability", ylabel="share of the clusters", aspect="equal")
    axes.set_title(f"{len(sizes):,} clusters, {len(flights)} generated floors")
    axes.legend()
