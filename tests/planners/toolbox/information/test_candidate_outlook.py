from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Distances
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.levels import coordinates
from indoor_explorers.env.policies.view import View
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.information.candidate_outlook import CandidateOutlook, nearest_clusters
from indoor_explorers.planners.toolbox.pockets.estimates import PocketEstimates, PocketEstimator
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS
from tests.planners.flights import world_on


def corridor() -> tuple[View, Distances, CandidateOutlook]:
    """A UAV in the middle of a corridor of 41 cells, of which it knows the inner 21: a cluster at either end."""
    world = world_on(np.ones((1, 41), np.bool_), [(0, 20)], goal=1.0, lidar__range=10.0)
    view = world.view(0, 0)
    assert np.flatnonzero(view.belief == FREE).tolist() == list(range(10, 31))
    return view, distance_field(view.belief, view.cell), CandidateOutlook(world.briefing(0, 0))


def told(monkeypatch: pytest.MonkeyPatch, sizes: list[float], chances: list[float]) -> None:
    """Have these sizes and chances estimated of the clusters, and no chance of more than one cell."""
    tails = np.zeros((len(sizes), len(THRESHOLDS)))
    tails[:, 0] = chances
    estimates = PocketEstimates(tails, np.array(sizes), np.zeros(len(sizes)))
    monkeypatch.setattr(PocketEstimator, "estimate", lambda *_: estimates)


def test_places_lead_to_what_the_nearest_cluster_does(monkeypatch: pytest.MonkeyPatch) -> None:
    view, field, prospects = corridor()
    told(monkeypatch, [40.0, 60.0], [0.75, 0.5])
    assert prospects.chances(view, np.array([11, 14, 28], np.int32), field).tolist() == [0.75, 0.75, 0.5]


def test_places_of_deferred_clusters_lead_nowhere_while_there_are_others(monkeypatch: pytest.MonkeyPatch) -> None:
    view, field, prospects = corridor()
    told(monkeypatch, [0.01, 60.0], [0.01, 0.5])
    assert prospects.chances(view, np.array([11, 28], np.int32), field).tolist() == [0.0, 0.5]
    assert prospects.chances(view, np.array([11], np.int32), field).tolist() == [0.01]


def test_without_clusters_all_places_are_alike() -> None:
    view, field, prospects = corridor()
    known = view._replace(belief=np.full_like(view.belief, FREE))
    assert prospects.chances(known, np.array([11, 28], np.int32), field).tolist() == [1.0, 1.0]


@pytest.mark.parametrize("rise", [0, 11])
def test_nearest_clusters_are_those_of_a_slow_search(rise: int) -> None:
    """On a plain map and in a volume of three levels."""
    belief = np.random.default_rng(3).choice([UNKNOWN, FREE, OCCUPIED], (32, 30), p=[0.3, 0.6, 0.1]).astype(np.uint8)
    belief[10::11] = OCCUPIED
    clusters = frontier_clusters(belief, 10.0, rise)
    cells = np.flatnonzero(belief.ravel() == FREE).astype(np.int32)
    members = coordinates(clusters.cells, 30, rise)
    owner = np.searchsorted(clusters.ends, np.arange(len(clusters.cells)), side="right") - 1
    found = nearest_clusters(cells, *clusters, 30, rise)
    for at, number in zip(coordinates(cells, 30, rise), found.tolist(), strict=True):
        away = ((members - at) ** 2).sum(axis=1)
        assert away[owner == number].min() == away.min()
