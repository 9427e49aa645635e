"""The vectorised Gymnasium interface: many single UAVs, each in its own episode, in one batched world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Discrete
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, create_empty_array
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.interfaces.common import (
    RENDER_FPS,
    VECTOR_RENDER_MODES,
    base_age,
    begin_encoder,
    draw_seed,
    find_render_mode,
    find_scenario,
    legal_actions,
    new_lone_world,
)
from indoor_explorers.env.observations import Observation, Views
from indoor_explorers.env.observations.base import Arrays, copy_of, row_of
from indoor_explorers.env.observations.factories import BatchedEncoder
from indoor_explorers.env.observations.incremental import LivePlanes
from indoor_explorers.env.observations.planes import ChannelsEncoder
from indoor_explorers.env.policies.policy import integers
from indoor_explorers.env.rendering.renderer import Renderer
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.preparation import Prepared
from indoor_explorers.env.simulation.state import End

Seeds = int | Sequence[int | None] | None


class IndoorExplorersVectorEnv(VectorEnv[Arrays, NDArray[np.integer[Any]], NDArray[Any]]):
    """Explore in ``num_envs`` episodes at once.

    Each episode equals one of :class:`~indoor_explorers.env.interfaces.gymnasium_env.IndoorExplorersEnv`.

    Autoreset is one of Gymnasium's modes. ``NEXT_STEP``: the step after an episode's last one ignores its action, has
    reward 0 and returns the first observation of its next episode. ``SAME_STEP``: the last step returns that
    observation, and infos hold the last one and its info as ``final_obs`` and ``final_info``. ``DISABLED``: the caller
    resets the episodes that ended, with ``options["reset_mask"]``.

    An integer seed ``s`` seeds the episodes with ``s``, ``s + 1`` and so on; a sequence seeds each; ``first_seed`` is
    added to all. Each environment draws its later episodes from its own generator, as the single environment does.
    Infos are arrays (B, ...), each with the mask ``_key`` of Gymnasium.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (declared so by the base class)
        "render_modes": list(VECTOR_RENDER_MODES),
        "render_fps": RENDER_FPS,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        scenario: Scenario | str = "thesis-obstacles",
        observation: Observation = "channels",
        render_mode: str | None = None,
        settings: Mapping[str, Any] | None = None,
        index: int = 0,
        copy: bool = True,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        threads: int = 1,
        first_seed: int = 0,
    ) -> None:
        """Prepare ``num_envs`` episodes, divided among ``threads``; the others are as in the single environment."""
        if num_envs < 1:
            raise InputError(f"expected num_envs to be at least 1, got {num_envs}")
        self.num_envs = num_envs
        self.render_mode = find_render_mode(render_mode, VECTOR_RENDER_MODES)
        self.world = new_lone_world(find_scenario(scenario, settings), num_envs, index, threads)
        self._renderer = Renderer(self.world, self.render_mode, RENDER_FPS)
        self.autoreset_mode = _find_mode(autoreset_mode)
        self.metadata = self.metadata | {"autoreset_mode": self.autoreset_mode}
        self._encoder = BatchedEncoder(observation, self.world.briefing(0, 0), num_envs)
        self._index = index
        self._first_seed = first_seed
        self._copy = copy
        self._generators: list[np.random.Generator | None] = [None] * num_envs
        self._begun = np.zeros(num_envs, np.bool_)
        self._over = np.zeros(num_envs, np.bool_)
        self._refused: InputError | None = None
        self.single_observation_space = self._encoder.space
        self.single_action_space = Discrete(self.world.scenario.actions)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        shared = self._encoder.shared
        self._live = LivePlanes(self.world, shared.planes) if isinstance(shared, ChannelsEncoder) else None
        self._observed: Any = None
        if self._live is None:
            self._observed = create_empty_array(self.single_observation_space, num_envs)

    def reset(self, *, seed: Seeds = None, options: dict[str, Any] | None = None) -> tuple[Arrays, dict[str, Any]]:
        """Start all episodes, or those of the (B,) bool array ``options["reset_mask"]``; observations are (B, ...)."""
        seeds = self._spread(seed)
        chosen = self._chosen(options)
        self._start(self._prepare(np.flatnonzero(chosen).tolist(), seeds))
        self._begun |= chosen
        self._over &= ~chosen
        self._refused = None
        self._observe(chosen)
        return self._given(), self._infos(chosen)

    def step(self, actions: NDArray[np.integer[Any]]) -> tuple[Arrays, NDArray[np.float64], Mask, Mask, dict[str, Any]]:
        """Fly one step in every episode, or start the next one, depending on the autoreset mode.

        Takes (B,) actions; returns observations (B, ...), rewards, terminated and truncated (B,), and infos.

        Raises:
            InputError: the next episode cannot be started; nothing was flown. In mode ``SAME_STEP`` the step after the
                end of the last episode raises it.

        """
        if self._refused is not None:
            refused, self._refused = self._refused, None
            raise refused
        if not self._begun.all():
            raise ResetNeeded("expected episodes to step in, got a new environment; call reset first")
        mode = self.autoreset_mode
        if mode is AutoresetMode.DISABLED and self._over.any():
            raise ResetNeeded("expected episodes that go on, got some that have ended; reset them with reset_mask")
        chosen = self.world.checked_actions(integers(actions, self.world.scenario.actions)[..., None])
        prepared = self._prepare(np.flatnonzero(self._over).tolist(), [None] * self.num_envs)
        self.world.step(chosen)  # nothing happens in an episode that is over
        self._renderer.stepped()
        self._start(prepared)
        end = self.world.state.end[:, 0].copy()
        reward = self.world.state.reward[:, 0].copy()
        self._over = over = end != End.FLYING
        everywhere = np.ones(self.num_envs, np.bool_)
        self._observe(everywhere)
        last = self._start_anew(over) if mode is AutoresetMode.SAME_STEP and over.any() else {}
        truncated = end == End.BUDGET
        return self._given(), reward, over & ~truncated, truncated, last | self._infos(everywhere)

    def action_masks(self) -> Mask:
        """Return the (B, A) bool mask of legal actions."""
        return legal_actions(self.world)[:, 0].copy()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:  # type: ignore[override]  # base: a free type variable
        """Return one picture (h, w, 3) uint8 for each episode, as the single environment renders it."""
        if self.render_mode is None:
            return None
        if not self._begun.all():
            raise ResetNeeded("expected episodes to render, got a new environment; call reset first")
        return tuple(self._renderer.picture(b) for b in range(self.num_envs))

    def __getstate__(self) -> dict[str, Any]:
        live = self._live is not None
        return self.__dict__ | ({"_observed": None} if live else {})  # a copy sets it to its own planes

    def _spread(self, seed: Seeds) -> Sequence[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [self._first_seed + int(seed) + b for b in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise InputError(f"expected one seed for each of {self.num_envs} environments, got {len(seed)}")
        return [None if one is None else self._first_seed + int(one) for one in seed]

    def _chosen(self, options: dict[str, Any] | None) -> Mask:
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, np.bool_)))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise InputError(f"expected a bool reset_mask of shape {(self.num_envs,)}, got {mask.dtype} {mask.shape}")
        return mask

    def _prepare(self, episodes: Sequence[int], seeds: Sequence[int | None]) -> Prepared:
        """Draw the next episodes, seeding their environments first where a seed is given; start none yet."""
        generators = [self._generator(b, seeds[b]) for b in episodes]
        drawn = [
            self._first_seed + draw_seed(rng) if (seed := seeds[b]) is None else seed
            for b, rng in zip(episodes, generators, strict=True)
        ]
        prepared = self.world.prepare(episodes, drawn, index=self._index)
        for b, rng in zip(episodes, generators, strict=True):
            self._generators[b] = rng
        return prepared

    def _generator(self, b: int, seed: int | None) -> np.random.Generator:
        """Return the generator of an environment's later seeds."""
        rng = self._generators[b]
        if rng is None or seed is not None:
            rng = np_random(draw_seed(self.np_random) if seed is None else seed)[0]
        return rng

    def _start(self, prepared: Prepared) -> None:
        """Start the drawn episodes."""
        self.world.start(prepared)
        for b in prepared.episodes.tolist():
            self._renderer.begun(b)
            if (encoder := self._encoder.of(b)) is not None:
                begin_encoder(encoder, self.world, b, 0)

    def _start_anew(self, over: Mask) -> dict[str, Any]:
        """Start the next episode where one is over; return the infos that tell how the last one ended."""
        final_obs, final_info = np.full(self.num_envs, None, object), self._infos(over)
        episodes = np.flatnonzero(over).tolist()
        for b in episodes:
            final_obs[b] = copy_of(row_of(self._observed, b))
        try:
            self._start(self._prepare(episodes, [None] * self.num_envs))
            self._observe(over)
            self._over = np.zeros(self.num_envs, np.bool_)
        except InputError as error:  # raised by the next step, so that this one's results are not lost
            self._refused = error
        return {"final_obs": final_obs, "_final_obs": over, "final_info": final_info, "_final_info": over.copy()}

    def _observe(self, chosen: Mask) -> None:
        """Encode the views of the chosen episodes."""
        if self._live is not None:
            self._live.update()
            if self._observed is None:
                self._observed = self._live.planes[:, 0]
        elif chosen.all():
            self._encoder.encode(self._views(), self._observed)
        else:
            views = self._views()
            for b in np.flatnonzero(chosen).tolist():
                self._encoder.encode_one(b, views, self._observed)

    def _views(self) -> Views:
        state = self.world.state
        arrays = state.belief, state.believed_cell, state.legal, state.visited
        belief, cell, legal, visited = (_read_only(array[:, 0]) for array in arrays)
        age = base_age(state)[:, 0] if self.world.scenario.base.exists else None
        views = Views(belief, cell, legal, state.step, state.budget, visited, age)
        slam = self.world.slam
        if slam is None:
            return views
        now = np.arange(self.num_envs), 0, state.step
        return views._replace(
            log_odds=_read_only(slam.log_odds[:, 0]),
            pose_std=np.sqrt(slam.variance[now]),
            heading=slam.heading[now] if self.world.scenario.turns else None,
        )

    def _given(self) -> Arrays:
        observed: Arrays = copy_of(self._observed) if self._copy else self._observed
        return observed

    def _infos(self, present: Mask) -> dict[str, Any]:
        """Return the infos of the episodes that ``present`` marks, zeros for the others."""
        state = self.world.state
        infos: dict[str, Any] = {
            "action_mask": legal_actions(self.world)[:, 0].astype(np.int8),
            "coverage": state.covered[:, 0] / np.maximum(state.total, 1),
            "step": state.step.copy(),
            "end": state.end[:, 0].astype(np.int64),
        }
        if self.world.scenario.base.exists:
            infos["base_age"] = base_age(state)[:, 0]
            infos["base_coverage"] = state.base_covered / np.maximum(state.total, 1)
        if not present.all():
            for array in infos.values():
                array[~present] = 0
        return infos | {f"_{key}": present.copy() for key in infos}


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    array.setflags(write=False)  # the flag of this slice, not of the state's array
    return array


def _find_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """Return an autoreset mode, found by its name or value."""
    if isinstance(mode, AutoresetMode):
        return mode
    names = AutoresetMode.__members__ | {member.value: member for member in AutoresetMode}
    if mode not in names:
        raise InputError(f"unknown autoreset mode {mode!r}{did_you_mean(str(mode), AutoresetMode.__members__)}")
    return names[mode]
