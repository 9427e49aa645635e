"""The vectorised Gymnasium face: many lone UAVs, each in its own episode, in one batched world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Discrete
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Mask
from indoor_explorers.env.encoders import BatchEncoder, Observation, make_encoder
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.faces import (
    RENDER_FPS,
    VECTOR_RENDER_MODES,
    draw_seed,
    find_render_mode,
    find_scenario,
    new_lone_world,
)
from indoor_explorers.env.rendering.camera import Camera
from indoor_explorers.env.scenario import Scenario
from indoor_explorers.env.state import End

Seeds = int | Sequence[int | None] | None


class IndoorExplorersVectorEnv(VectorEnv[NDArray[Any], NDArray[np.integer[Any]], NDArray[Any]]):
    """Explore in ``num_envs`` episodes at once, each just as :class:`indoor_explorers.env.gym.IndoorExplorersEnv` does.

    Autoreset is ``NEXT_STEP``: the step after an episode's last one ignores its action, pays nothing and
    returns the first observation of its next episode. An integer seed ``s`` seeds the episodes with ``s``,
    ``s + 1`` and so on; a sequence seeds each; every environment then draws its later episodes from a
    generator of its own, as the single environment does. Infos hold arrays (B, ...) of what the single
    environment's hold, each with the mask ``_key`` that Gymnasium asks for.
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
    ) -> None:
        """Prepare ``num_envs`` episodes; the rest as for the single environment."""
        if num_envs < 1:
            raise InputError(f"expected num_envs to be at least 1, got {num_envs}")
        self.num_envs = num_envs
        self.render_mode = find_render_mode(render_mode, VECTOR_RENDER_MODES)
        self.world = new_lone_world(find_scenario(scenario, settings), num_envs, index)
        self._camera = Camera(self.world, self.render_mode, RENDER_FPS)
        self._encoder = make_encoder(observation, self.world.briefing(0, 0))
        self._index = index
        self._generators: list[np.random.Generator | None] = [None] * num_envs
        self._begun = np.zeros(num_envs, np.bool_)
        self._over = np.zeros(num_envs, np.bool_)
        self.single_observation_space = self._encoder.space
        self.single_action_space = Discrete(5)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Start all episodes, or those of the (B,) bool array ``options["reset_mask"]``."""
        seeds = self._spread(seed)
        chosen = self._chosen(options)
        for b in np.flatnonzero(chosen).tolist():
            self._begin(b, seeds[b])
        self._begun |= chosen
        self._over &= ~chosen
        return self._observations(), self._infos(chosen)

    def step(
        self, actions: NDArray[np.integer[Any]]
    ) -> tuple[NDArray[Any], NDArray[np.float64], Mask, Mask, dict[str, Any]]:
        """Fly one step in every episode, or start the next one where the last step ended it."""
        if not self._begun.all():
            raise ResetNeeded("expected episodes to step in, got a new environment; call reset first")
        self.world.step(np.asarray(actions)[..., None])  # nothing happens in an episode that is over
        self._camera.stepped()
        for b in np.flatnonzero(self._over).tolist():
            self._begin(b, None)
        end = self.world.state.end[:, 0]
        truncated = end == End.BUDGET
        self._over = end != End.FLYING
        return (
            self._observations(),
            self.world.state.reward[:, 0].copy(),
            self._over & ~truncated,
            truncated,
            self._infos(np.ones(self.num_envs, np.bool_)),
        )

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:  # type: ignore[override]  # base: a free type variable
        """Return one picture for each episode, as the single environment renders it."""
        if self.render_mode is None:
            return None
        if not self._begun.all():
            raise ResetNeeded("expected episodes to render, got a new environment; call reset first")
        return tuple(self._camera.picture(b) for b in range(self.num_envs))

    def _spread(self, seed: Seeds) -> Sequence[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [int(seed) + b for b in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise InputError(f"expected one seed for each of {self.num_envs} environments, got {len(seed)}")
        return [None if one is None else int(one) for one in seed]

    def _chosen(self, options: dict[str, Any] | None) -> Mask:
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, np.bool_)))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise InputError(f"expected a bool reset_mask of shape {(self.num_envs,)}, got {mask.dtype} {mask.shape}")
        return mask

    def _begin(self, b: int, seed: int | None) -> None:
        """Start an episode, seeding its environment first when a seed is given."""
        rng = self._generators[b]
        if rng is None or seed is not None:
            rng = self._generators[b] = np_random(draw_seed(self.np_random) if seed is None else seed)[0]
        self.world.begin(b, draw_seed(rng) if seed is None else seed, index=self._index)
        self._camera.begun(b)

    def _observations(self) -> NDArray[Any]:
        out = np.empty((self.num_envs, *self._encoder.space.shape), self._encoder.space.dtype)
        if isinstance(self._encoder, BatchEncoder):
            self._encoder.encode_batch(self.world.state.belief[:, 0], self.world.state.cell[:, 0], out)
        else:
            for b in range(self.num_envs):
                self._encoder.encode(self.world.view(b, 0), out[b])
        return out

    def _infos(self, present: Mask) -> dict[str, Any]:
        state = self.world.state
        infos: dict[str, Any] = {
            "action_mask": state.legal[:, 0].astype(np.int8),
            "coverage": state.covered[:, 0] / np.maximum(state.total, 1),
            "step": state.step.copy(),
            "end": state.end[:, 0].astype(np.int64),
        }
        return infos | {f"_{key}": present.copy() for key in infos}
