"""Tours on a prior map: as good as it is, complete whatever it says, and `frontier` without one."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import Policy, World, make_policy, scenario
from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.harness.episodes.runner import fly as fly_tasks
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.planners.reference.plan import SearchBudget, plan
from indoor_explorers.planners.reference.prior_tour import PriorTour, PriorTourPilot
from tests.env.conformance.policies import passed_checks
from tests.marks import spread
from tests.planners.flights import Flight, fly, maze, rooms
from tests.planners.reference.test_reference import EFFORT, task_of

#: Quick, and good enough on small maps.
QUICK = PriorTour(restarts=1, changes=2000, work=5_000_000)
Wrong = Callable[[Belief], Belief]


def noisy(truth: Belief) -> Belief:
    return np.where(np.random.default_rng(3).random(truth.shape) < 0.5, FREE, OCCUPIED).astype(np.uint8)


def shifted(truth: Belief) -> Belief:
    return np.roll(truth, (1, 1), (0, 1))


#: Priors that mislead.
WRONG: dict[str, Wrong] = {
    "all free": lambda truth: np.full_like(truth, FREE),
    "all solid": lambda truth: np.full_like(truth, OCCUPIED),
    "inverted": lambda truth: (3 - truth).astype(np.uint8),
    "noise": noisy,
    "mirrored": lambda truth: np.ascontiguousarray(truth[:, ::-1]),
    "shifted": shifted,
}


def with_prior(
    monkeypatch: pytest.MonkeyPatch, wrong: Wrong | None, policy: PriorTour, free: Mask, **how: Any
) -> Flight:
    """Fly with a prior that is made of the true map; None for the right one."""
    monkeypatch.setattr(World, "prior", lambda self, b: (wrong or np.copy)(self.state.truth[b]))
    return fly(policy, free, **how)


def tracks_on(policy: Policy, settings: dict[str, Any], seed: int = 3, name: str = "small-offices") -> np.ndarray:
    world = World(scenario(name).for_evaluation().with_settings(settings))
    world.reset([seed])
    pilots = make_pilots(policy, world)
    cells = [world.state.cell[0].copy()]
    for _ in rollout(world, ask_pilots(policy, pilots, world)):
        cells.append(world.state.cell[0].copy())
    assert world.team_coverage[0] == 1.0
    return np.array(cells)


@pytest.mark.parametrize("team", [1, 3])
def test_without_a_prior_it_is_frontier(team: int) -> None:
    settings = {"team": team}
    assert np.array_equal(tracks_on(QUICK, settings), tracks_on(make_policy("frontier"), settings))


@pytest.mark.slow  # sixteen seconds; that it is complete with any prior is tested above
def test_the_better_the_prior_the_sooner_most_is_seen() -> None:
    def mean_t99(policy: str | PriorTour, kind: str) -> float:
        task = scenario("small-offices").for_evaluation().with_settings({"prior.kind": kind})
        made = make_policy(policy) if isinstance(policy, str) else policy
        records = fly_tasks(made, "tour", task, [Task(task.name, 0, seed) for seed in (1, 2, 3)])
        return float(np.mean([record.metrics["t99"] for record in records]))

    right, outdated, none = (mean_t99(PriorTour(), kind) for kind in ("right", "outdated", "none"))
    assert right < outdated < none
    assert right < 1.1 * mean_t99("reference", "none")


@pytest.mark.parametrize(("wrong", "radio"), spread([*WRONG], [("none", 0.0), ("disc", 5.0), ("unlimited", 0.0)]))
def test_every_reachable_cell_becomes_known_whatever_the_prior_says(
    wrong: str, radio: tuple[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    alone = [(maze(6, 7, 1), 1)] * (radio[0] == "none")
    for free, team in (*alone, (maze(6, 7, 2), 3), (rooms(3, 4, 1), 2)):
        for distrust in (0.25, 10.0):
            policy = PriorTour(restarts=1, changes=300, work=1_000_000, distrust=distrust)
            flight = with_prior(monkeypatch, WRONG[wrong], policy, free, team=team, radio=radio, budget=2500)
            assert flight.complete
            assert flight.longest_dither <= 8


def test_a_prior_that_is_mostly_wrong_is_not_flown_on(monkeypatch: pytest.MonkeyPatch) -> None:
    free = rooms(3, 4, 1)
    flight = with_prior(monkeypatch, WRONG["inverted"], QUICK, free)
    (pilot,) = flight.pilots
    assert pilot.tally() == {"plans": 0.0, "explored_steps": float(flight.steps)}


def test_a_right_prior_is_flown_on_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = with_prior(monkeypatch, None, QUICK, rooms(3, 4, 1))
    (pilot,) = flight.pilots
    assert pilot.tally() == {"plans": 1.0, "explored_steps": 0.0}


def test_rooms_behind_doors_that_the_prior_does_not_have_are_explored(monkeypatch: pytest.MonkeyPatch) -> None:
    free = np.zeros((9, 21), np.bool_)
    free[1:8, 1:10] = free[1:8, 11:20] = free[4, 10] = True

    def shut(truth: Belief) -> Belief:
        prior = truth.copy()
        prior[4, 10] = OCCUPIED
        return prior

    flight = with_prior(monkeypatch, shut, QUICK, free, spawns=[(1, 1)])
    assert flight.complete
    assert flight.pilots[0].tally()["plans"] >= 2
    walled = free.copy()
    walled[4, 10] = False
    opened = with_prior(monkeypatch, lambda truth: np.where(free, FREE, truth), QUICK, walled, spawns=[(1, 1)])
    assert opened.complete


@pytest.mark.parametrize("radio", [("none", 0.0), ("disc", 4.0), ("unlimited", 0.0)])
def test_what_a_lost_uav_would_have_seen_is_seen_by_the_others(
    radio: tuple[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    spawns = [(1, 1), (1, 2), (2, 1)]
    flight = with_prior(
        monkeypatch, None, QUICK, rooms(3, 4, 2), team=3, radio=radio, spawns=spawns, ends={0: 12}, budget=1500
    )
    assert flight.complete


def test_linked_uavs_work_out_the_same_routes() -> None:
    world = World(
        scenario("small-floors").for_evaluation().with_settings({"prior.kind": "outdated", "radio.model": "unlimited"})
    )
    world.reset([4])
    pilots = make_pilots(QUICK, world)
    one, other = pilots[0, 0], pilots[0, 1]
    assert isinstance(one, PriorTourPilot)
    assert isinstance(other, PriorTourPilot)
    for _ in islice(rollout(world, ask_pilots(QUICK, pilots, world)), 150):
        assert one._routes == other._routes
    assert one.plans == other.plans > 2


def test_what_is_known_and_what_others_will_see_is_not_planned_for() -> None:
    free = rooms(3, 4, 2)
    request = task_of(free, ((1, 1),))
    whole = plan(request, EFFORT)
    known = np.zeros(free.shape, np.bool_)
    assert plan(request._replace(known=known.tobytes()), EFFORT) == whole
    assert plan(request._replace(known=np.ones_like(known).tobytes()), EFFORT) == (((1, 1),),)
    known[:, 12:] = True
    (half,) = plan(request._replace(known=known.tobytes()), EFFORT)
    assert max(col for _, col in half) < 18
    assert len(half) < 0.7 * len(whole[0])
    assert plan(request._replace(others=whole[0]), SearchBudget(1, 100, 10**6)) == (((1, 1),),)
    (rest,) = plan(request._replace(others=half), EFFORT)
    assert len(rest) < len(whole[0])


@pytest.mark.slow
def test_it_knows_nothing_but_its_prior() -> None:
    passed_checks(QUICK)
