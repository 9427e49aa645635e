"""The Gymnasium interface: one UAV explores alone, id ``IndoorExplorers-v0``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Discrete
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.interfaces.common import (
    RENDER_FPS,
    RENDER_MODES,
    begin_encoder,
    draw_seed,
    find_render_mode,
    find_scenario,
    info_of,
    is_terminated,
    legal_actions,
    new_lone_world,
)
from indoor_explorers.env.observations import Observation, make_encoder
from indoor_explorers.env.observations.base import Arrays, copy_of, empty
from indoor_explorers.env.rendering.renderer import Renderer
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End


class IndoorExplorersEnv(gymnasium.Env[Arrays, np.int64]):
    """Explore with one UAV: actions down, left, up, right and stay, observations from its view alone.

    With a limited lidar field of view, a sixth action turns the UAV.

    ``reset(seed=s)`` starts episode seed ``first_seed + s`` exactly as ``World.reset([first_seed + s])`` does; a reset
    without a seed draws the next episode's seed from ``np_random`` and adds ``first_seed``, too. Goal, collision, out
    of bounds and stuck terminate, the step budget truncates. Infos hold ``action_mask`` (A,) int8, ``coverage``,
    ``step`` and ``end``, and with a home base ``base_age`` and ``base_coverage``, see
    :func:`indoor_explorers.env.interfaces.common.info_of`.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": RENDER_FPS}  # noqa: RUF012 (base's)

    def __init__(
        self,
        scenario: Scenario | str = "thesis-obstacles",
        observation: Observation = "channels",
        render_mode: str | None = None,
        settings: Mapping[str, Any] | None = None,
        index: int = 0,
        copy: bool = True,
        first_seed: int = 0,
    ) -> None:
        """Prepare a scenario, the name of a preset or a .toml file.

        Args:
            scenario: The task; its team is one UAV.
            observation: Name of an encoder, or a factory of one, see :mod:`indoor_explorers.env.observations`.
            render_mode: ``rgb_array``, ``human`` (a window that shows every step; extra ``render``) or None.
            settings: Dotted settings to replace in the scenario, such as ``{"lidar.range": 5}``.
            index: Which map of a scenario with several map files.
            copy: Whether each observation is new; else the next call overwrites it, which is faster.
            first_seed: Added to every seed that ``reset`` is given or draws, which keeps a training's episodes apart
                from those of comparisons: 2**40, for instance.

        Raises:
            InputError: an argument is invalid, or the scenario has a larger team.

        """
        self.render_mode = find_render_mode(render_mode)
        self.world = new_lone_world(find_scenario(scenario, settings), 1, index)
        self._renderer = Renderer(self.world, self.render_mode, RENDER_FPS)
        self._encoder = make_encoder(observation, self.world.briefing(0, 0))
        self._index = index
        self._copy = copy
        self._first_seed = first_seed
        self._begun = False
        self.observation_space = self._encoder.space
        self._observation = empty(self.observation_space)
        self.action_space = Discrete(self.world.scenario.actions)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Arrays, dict[str, Any]]:
        """Start an episode; no options are read."""
        given = None if seed is None else self._first_seed + seed
        super().reset(seed=given)
        drawn = self._first_seed + draw_seed(self.np_random) if given is None else given
        self.world.begin(0, drawn, index=self._index)
        self._begun = True
        self._renderer.begun(0)
        begin_encoder(self._encoder, self.world, 0, 0)
        return self._observe(), info_of(self.world, 0, 0)

    def step(self, action: np.int64 | int) -> tuple[Arrays, float, bool, bool, dict[str, Any]]:
        """Fly one step; return observation, reward, terminated, truncated and info.

        After the end of the episode nothing changes, and rewards are 0.
        """
        if not self._begun:
            raise ResetNeeded("expected an episode to step in, got a new environment; call reset first")
        self.world.step([[action]])  # type: ignore[arg-type]  # numpy's integers are numbers, too
        self._renderer.stepped()
        info = info_of(self.world, 0, 0)
        return (
            self._observe(),
            float(self.world.state.reward[0, 0]),
            is_terminated(info["end"]),
            info["end"] == End.BUDGET,
            info,
        )

    def action_masks(self) -> Mask:
        """Return the (A,) bool mask of legal actions, where sb3-contrib's MaskablePPO looks for it."""
        legal: Mask = legal_actions(self.world)[0, 0].copy()
        return legal

    def render(self) -> NDArray[np.uint8] | None:  # type: ignore[override]  # base: a free type variable
        """Return an (h, w, 3) uint8 picture of the episode, of the same size for every step, or show it."""
        return self._renderer.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._renderer.close()

    def _observe(self) -> Arrays:
        self._encoder.encode(self.world.view(0, 0), self._observation)
        observation: Arrays = copy_of(self._observation) if self._copy else self._observation
        return observation
