"""The PettingZoo interface: a team of UAVs that choose at the same time. Needs the extra ``marl``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box, Discrete, Space
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray
from pettingzoo import ParallelEnv
from pettingzoo.utils import BaseWrapper

from indoor_explorers.env.errors import InputError, shown
from indoor_explorers.env.grid.cells import FREE, UNKNOWN, Action
from indoor_explorers.env.interfaces.common import (
    RENDER_FPS,
    RENDER_MODES,
    begin_encoder,
    draw_seed,
    find_render_mode,
    find_scenario,
    info_of,
    is_terminated,
    new_world,
    one_action,
)
from indoor_explorers.env.observations import Observation, make_encoder
from indoor_explorers.env.observations.base import Arrays
from indoor_explorers.env.rendering.renderer import Renderer
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End


class TeamEnv(ParallelEnv):  # type: ignore[misc]  # PettingZoo carries no types
    """Explore with a team; :func:`indoor_explorers.env.parallel_env` documents the arguments."""

    metadata: dict[str, Any] = {  # noqa: RUF012 (declared so by the base class)
        "name": "indoor_explorers_v0",
        "render_modes": list(RENDER_MODES),
        "render_fps": RENDER_FPS,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        scenario: Scenario | str,
        observation: Observation,
        render_mode: str | None,
        settings: Mapping[str, Any] | None,
        index: int,
        first_seed: int = 0,
    ) -> None:
        self.render_mode = find_render_mode(render_mode)
        self.world = new_world(find_scenario(scenario, settings), 1, index)
        self._renderer = Renderer(self.world, self.render_mode, RENDER_FPS)
        self._index = index
        self._first_seed = first_seed
        self._rng: np.random.Generator | None = None
        self._begun = False
        self.possible_agents = [f"uav_{n}" for n in range(self.world.scenario.team)]
        self.agents: list[str] = []
        self._numbers = {agent: n for n, agent in enumerate(self.possible_agents)}
        self._encoders = [make_encoder(observation, self.world.briefing(0, n)) for n in self._numbers.values()]
        team, height, width = self.world.state.belief.shape[1:]
        self.state_space = Box(0, 1, (2 + 2 * team, height, width), np.uint8)
        self._action_spaces: list[Discrete[np.int64]] = [
            Discrete(self.world.scenario.actions) for _ in self.possible_agents
        ]

    def observation_space(self, agent: str) -> Space[Any]:
        """Return the space of one agent's observations, the same object each time."""
        return self._encoders[self._numbers[agent]].space

    def action_space(self, agent: str) -> Discrete[np.int64]:
        """Return the space of one agent's actions, the same object each time."""
        return self._action_spaces[self._numbers[agent]]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Arrays], dict[str, dict[str, Any]]]:
        """Start an episode, seed ``seed`` as ``World.reset([seed])`` does; no options are read."""
        given = None if seed is None else self._first_seed + seed
        if self._rng is None or given is not None:
            self._rng = np_random(given)[0]
        drawn = self._first_seed + draw_seed(self._rng) if given is None else given
        self.world.begin(0, drawn, index=self._index)
        self._begun = True
        self._renderer.begun(0)
        for n, encoder in enumerate(self._encoders):
            begin_encoder(encoder, self.world, 0, n)
        self.agents = list(self.possible_agents)
        return self._observations(), self._infos()

    def step(
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Arrays], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Fly one step with an action for each of ``agents``; agents that end leave ``agents``.

        Returns observations, rewards, terminated, truncated and infos by agent.
        """
        if not self._begun:
            raise ResetNeeded("expected an episode to step in, got a new environment; call reset first")
        if not isinstance(actions, Mapping) or actions.keys() != set(self.agents):
            given = f"them for {list(actions)}" if isinstance(actions, Mapping) else shown(actions)
            raise InputError(f"expected a dict with one action for each of {self.agents}, got {given}")
        chosen = np.full((1, len(self.possible_agents)), int(Action.STAY))
        for agent, action in actions.items():
            number = isinstance(action, np.signedinteger)  # nearly always; all else takes longer
            chosen[0, self._numbers[agent]] = action if number else one_action(action, self.world.scenario.actions)
        self.world.step(chosen)
        self._renderer.stepped()
        pay = self.world.state.reward[0].tolist()
        ends = {agent: int(self.world.state.end[0, self._numbers[agent]]) for agent in self.agents}
        result = (
            self._observations(),
            {agent: pay[self._numbers[agent]] for agent in self.agents},
            {agent: is_terminated(end) for agent, end in ends.items()},
            {agent: end == End.BUDGET for agent, end in ends.items()},
            self._infos(),
        )
        self.agents = [agent for agent, end in ends.items() if end == End.FLYING]
        return result

    def state(self) -> NDArray[np.uint8]:
        """Return the global state for a central critic or mixer, hidden from UAVs: (2 + 2 N, H, W) uint8 of 0 and 1.

        The planes are the free cells of the true map, the cells that the team knows, the cells that each of the N UAVs
        knows, and the cell of each flying UAV.
        """
        if not self._begun:
            raise ResetNeeded("expected an episode with a state, got a new environment; call reset first")
        state = self.world.state
        team = len(self.possible_agents)
        planes = np.zeros(self.state_space.shape, np.uint8)
        planes[0] = state.truth[0] == FREE
        planes[1] = state.union[0] != UNKNOWN
        planes[2 : 2 + team] = state.belief[0] != UNKNOWN
        for n in np.flatnonzero(self.world.flying[0]):
            planes[(2 + team + n, *state.cell[0, n])] = 1
        return planes

    def render(self) -> NDArray[np.uint8] | None:
        """Return an (h, w, 3) uint8 picture of the episode, of the same size for every step, or show it."""
        return self._renderer.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._renderer.close()

    def _observations(self) -> dict[str, Arrays]:
        numbers = ((agent, self._numbers[agent]) for agent in self.agents)
        return {agent: self._encoders[n].observation(self.world.view(0, n)) for agent, n in numbers}

    def _infos(self) -> dict[str, dict[str, Any]]:
        return {agent: info_of(self.world, 0, self._numbers[agent]) for agent in self.agents}


class CheckedActions(BaseWrapper):  # type: ignore[misc]  # PettingZoo carries no types
    """Raise :class:`InputError` for an invalid action, where PettingZoo's own wrapper asserts."""

    def step(self, action: Any) -> None:
        """Take an agent's action; None for an agent that has ended."""
        agent = self.agent_selection
        if not (self.terminations[agent] or self.truncations[agent]):
            action = one_action(action, self.action_space(agent).n)
        super().step(action)
