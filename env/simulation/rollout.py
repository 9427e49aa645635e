"""The loop that flies episodes: ask the pilots, post their messages, step the world, yield."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.policy import Pilot, Policy, checked_action
from indoor_explorers.env.simulation.world import World

#: A UAV of a batch: (episode, agent).
Uav = tuple[int, int]
#: Asks the pilots of the UAVs that fly, posts their messages, and gives the action of each; others stay.
Ask = Callable[[list[Uav]], Iterable[tuple[Uav, int]]]


def rollout(world: World, ask: Ask) -> Iterator[NDArray[np.int64]]:
    """Fly the episodes of a world that have begun to their ends; yield the (B, N) actions after each step."""
    while flying := [(episode, agent) for episode, agent in np.argwhere(world.flying).tolist()]:
        actions = np.full(world.state.end.shape, int(Action.STAY))
        for uav, action in ask(flying):
            actions[uav] = action
        world.step(actions)
        yield actions


def make_pilots(policy: Policy, world: World) -> dict[Uav, Pilot]:
    """Brief a pilot for every UAV of a world whose episodes have begun."""
    return {
        (episode, agent): policy.pilot(world.briefing(episode, agent, privileged=policy.privileged))
        for episode in range(world.batch)
        for agent in range(world.scenario.team)
    }


def ask_pilots(policy: Policy, pilots: Mapping[Uav, Pilot], world: World) -> Ask:
    """Return a function that asks one UAV after the other, or all at once if the policy is ``batched``."""

    def ask(flying: list[Uav]) -> Iterator[tuple[Uav, int]]:
        for group in [flying] if policy.batched else [[uav] for uav in flying]:
            actions = policy.act([pilots[uav] for uav in group], [world.view(*uav) for uav in group])
            for uav, action in zip(group, actions, strict=True):
                checked = checked_action(action, world.scenario.actions)
                world.post(*uav, pilots[uav].message)
                yield uav, checked

    return ask
