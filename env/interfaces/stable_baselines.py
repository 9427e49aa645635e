"""The Stable-Baselines3 ``VecEnv`` on top of the vectorised Gymnasium environment. Needs the extra ``sb3``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.interfaces.vector import IndoorExplorersVectorEnv
from indoor_explorers.env.observations.base import Arrays

try:
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise InputError("Stable-Baselines3 is not installed; pip install 'indoor-explorers[sb3]'") from error

Indices = int | Iterable[int] | None


class StableBaselinesVecEnv(VecEnv):
    """Fly ``num_envs`` single UAVs in one batched world, for Stable-Baselines3 and sb3-contrib.

    Its observations equal those of SB3's ``DummyVecEnv`` of ``num_envs`` single environments, without the overhead per
    environment. Infos hold what those of the single environment do, ``TimeLimit.truncated`` and, where an episode
    ended, ``terminal_observation``; ``env_method("action_masks")`` is used by MaskablePPO.
    """

    def __init__(self, num_envs: int = 16, **settings: Any) -> None:
        """Prepare ``num_envs`` episodes; ``settings`` are those of :class:`IndoorExplorersVectorEnv`."""
        if fixed := {"autoreset_mode", "copy"} & settings.keys():
            raise InputError(f"expected no {' or '.join(sorted(fixed))}, got one; Stable-Baselines3 decides it")
        self.envs = IndoorExplorersVectorEnv(num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **settings)
        super().__init__(num_envs, self.envs.single_observation_space, self.envs.single_action_space)

    def reset(self) -> Arrays:
        """Start all episodes, with the seeds of :meth:`seed`; return observations (B, ...)."""
        observations, infos = self.envs.reset(seed=self._seeds)
        self.reset_infos = _rows(infos, self.num_envs)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[np.integer[Any]]) -> None:
        """Take the (B,) actions of the next step."""
        self._actions = actions

    def step_wait(self) -> tuple[Arrays, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Fly the step; return observations (B, ...), rewards and ends (B,), and infos.

        Where an episode ended, the observation is the first of its next one.
        """
        observations, rewards, terminated, truncated, infos = self.envs.step(self._actions)
        over = terminated | truncated
        rows = _rows(infos, self.num_envs)
        if over.any():
            lasts = _rows(infos["final_info"], self.num_envs)
            for b in np.flatnonzero(over).tolist():
                self.reset_infos[b] = rows[b]
                rows[b] = lasts[b] | {"terminal_observation": infos["final_obs"][b]}
        for row, cut in zip(rows, truncated.tolist(), strict=True):
            row["TimeLimit.truncated"] = cut
        return observations, rewards.astype(np.float32), over, rows

    def close(self) -> None:
        """Close the world."""
        self.envs.close()

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """Return a picture (h, w, 3) uint8 of each episode."""
        return self.envs.render() or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute of the world's vectorised environment once for each environment."""
        return [getattr(self.envs, attr_name)] * len(self._numbers(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Refuse: the environments share one world."""
        raise InputError(
            f"expected a setting at the start, got {attr_name!r} later; these environments share one world"
        )

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Return the results of ``action_masks``, one for each environment; refuse other methods."""
        if method_name != "action_masks":
            raise InputError(f"expected method action_masks, got {method_name!r}; these environments share one world")
        masks = self.envs.action_masks()
        return [masks[b] for b in self._numbers(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:
        """Return False for each environment; wrap this one instead, for instance in SB3's ``VecMonitor``."""
        return [False] * len(self._numbers(indices))

    def _numbers(self, indices: Indices) -> list[int]:
        return list(self._get_indices(indices))


def _rows(infos: dict[str, Any], count: int) -> list[dict[str, Any]]:
    """Return one dict for each environment."""
    names = [name for name in ("coverage", "step", "end", "base_age", "base_coverage") if name in infos]
    columns = [infos[name].tolist() for name in names]
    return [
        dict(zip((*names, "action_mask"), row, strict=True)) for row in zip(*columns, infos["action_mask"], strict=True)
    ][:count]
