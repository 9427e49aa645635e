"""Decision times of the policies: one UAV at a time, on one core.

Most decisions follow a plan. Those that make a plan are recognised by the pilot statistic ``plans``; if a pilot does
not count plans, every decision is assumed to make one.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario, World, make_policy
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.policies.registry import policy_entry_points, with_parameters
from indoor_explorers.env.scenarios.parts import Radio
from indoor_explorers.env.simulation.rollout import Uav, make_pilots, rollout
from indoor_explorers.evaluation.studies.bench.worlds import square, tall

#: What ``decide-NAME-64x64x6-team4`` flies besides the policies as they are: those with estimates over levels, by name.
WITH_ESTIMATES = {
    f"{name}-estimates": f'{name}(level_weights="shipped")' for name in ("frontier-predictive", "dddqn-places")
}
#: Steps of the warm-up episode.
WARM_UP = 10
#: Maps of the growth figures are known except for squares whose side and distance are this many lidar ranges.
POCKET = 2
#: Lidar range in cells, steps and episodes of the growth figures.
GROWTH_LIDAR, GROWTH_STEPS, GROWTH_FLIGHTS = 5.0, 8, 2
#: Sides of the maps with one UAV; sizes of the teams on maps with side ``TEAM_SIDE``.
SIDES, TEAMS, TEAM_SIDE = (16, 32, 64, 128, 256, 512), (1, 2, 4, 8, 16), 128


class Decisions(NamedTuple):
    """Times of D decisions."""

    seconds: NDArray[np.float64]
    """(D,) seconds of each decision."""
    planned: NDArray[np.bool_]
    """(D,) whether it made a plan."""

    def median(self) -> float:
        """Return the median in microseconds."""
        return float(np.median(self.seconds)) * 1e6

    def slowest(self) -> float:
        """Return the 99th percentile in microseconds."""
        return float(np.percentile(self.seconds, 99)) * 1e6

    def planning(self) -> float:
        """Return the median of the decisions that made a plan, in microseconds."""
        return float(np.median(self.seconds[self.planned])) * 1e6


def flown(policy: str, task: Scenario, seeds: Sequence[int], *, pockets: bool = False) -> Decisions:
    """Return the decisions of the episodes with these seeds, after a short warm-up episode.

    With ``pockets``, three quarters of the map are known from the start.
    """
    _flight(policy, task.with_settings({"budget": WARM_UP}), seeds[0], pockets)
    timed = [pair for seed in seeds for pair in _flight(policy, task, seed, pockets)]
    seconds, planned = zip(*timed, strict=True)
    return Decisions(np.array(seconds), np.array(planned))


def _flight(name: str, task: Scenario, seed: int, pockets: bool) -> list[tuple[float, bool]]:
    """Return the seconds of each decision of an episode, and whether it made a plan."""
    plain, parameters = with_parameters(name)
    world, policy = World(task), make_policy(plain, **parameters)
    world.reset([seed])
    if pockets:
        _reveal(world)
    pilots, timed = make_pilots(policy, world), []

    def ask(flying: list[Uav]) -> Iterator[tuple[Uav, int]]:
        for uav in flying:
            view, pilot = world.view(*uav), pilots[uav]
            plans = pilot.tally().get("plans")
            start = time.perf_counter()
            action = policy.act([pilot], [view])[0]
            seconds = time.perf_counter() - start
            timed.append((seconds, plans is None or pilot.tally()["plans"] > plans))
            world.post(*uav, pilot.message)
            yield uav, action

    for _ in rollout(world, ask):
        pass
    return timed


def _reveal(world: World) -> None:
    """Reveal the map to all UAVs, except for some squares."""
    width = int(POCKET * GROWTH_LIDAR)
    rows, cols = np.indices(world.state.truth.shape[1:]) // width
    hidden = (rows % 2 == 1) & (cols % 2 == 1)
    beliefs = world.state.belief
    beliefs[:] = np.where((beliefs == UNKNOWN) & ~hidden, world.state.truth[:, None], beliefs)


@cache
def decisions(
    policy: str, side: int, lidar_range: float, team: int, steps: int, flights: int, levels: int = 1
) -> Decisions:
    """Return the decisions of a team with radio on a square map, or in a storey of some levels."""
    radio = Radio(model="square", range=3 * lidar_range)
    task = tall(side, levels, lidar_range, team, radio) if levels > 1 else square(side, lidar_range, team, radio)
    return flown(policy, task.with_settings({"budget": steps}), range(flights))


def figures() -> dict[str, Callable[[], float]]:
    """Return a function that measures each figure, by name; figures of one policy and map share their episodes."""
    found: dict[str, Callable[[], float]] = {}
    plain = {name: name for name in policy_entry_points()}
    for tail, policies, task in (
        ("16x16", plain, (16, 3.0, 2, 200, 5)),
        ("250x250", plain, (250, 10.0, 2, 200, 5)),
        ("250x250-team4", plain, (250, 10.0, 4, 400, 2)),
        ("64x64x6-team4", plain | WITH_ESTIMATES, (64, 10.0, 4, 200, 1, 6)),
    ):
        for name, policy in policies.items():
            take = partial(decisions, policy, *task)
            for end, of in (("", Decisions.median), ("-p99", Decisions.slowest), ("-planning", Decisions.planning)):
                found[f"decide-{name}-{tail}{end}"] = partial(lambda of, take: of(take()), of, take)
    return found


@cache
def planning(policy: str, side: int, team: int) -> float:
    """Return the microseconds of a decision that makes a plan, on a square map of which three quarters are known."""
    radio = Radio(model="unlimited") if team > 1 else Radio()
    task = square(side, GROWTH_LIDAR, team, radio).with_settings({"budget": GROWTH_STEPS})
    return flown(policy, task, range(GROWTH_FLIGHTS), pockets=True).planning()


def growth() -> dict[str, Callable[[], float]]:
    """Return a function that measures each figure of planning time against map size and team size, by name.

    Policies that know the map are left out: they plan once in an episode, for the whole team.
    """
    found: dict[str, Callable[[], float]] = {}
    for policy in (name for name in policy_entry_points() if not make_policy(name).privileged):
        for side in SIDES:
            found[f"growth-decide-area-{side}x{side}-{policy}"] = partial(planning, policy, side, 1)
        for team in TEAMS:
            found[f"growth-decide-team-{team}-{policy}"] = partial(planning, policy, TEAM_SIDE, team)
    return found
