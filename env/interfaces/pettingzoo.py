"""PettingZoo's two functions, ``parallel_env`` and ``env``; PettingZoo is imported when they are called."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.observations import Observation
from indoor_explorers.env.scenarios.scenario import Scenario

if TYPE_CHECKING:
    from indoor_explorers.env.interfaces.pettingzoo_env import TeamEnv


def parallel_env(
    scenario: Scenario | str = "thesis-team-4",
    render_mode: str | None = None,
    observation: Observation = "channels",
    settings: Mapping[str, Any] | None = None,
    index: int = 0,
    first_seed: int = 0,
) -> TeamEnv:
    """Return a PettingZoo ``ParallelEnv`` of a scenario's team, agents ``uav_0``, ``uav_1`` and so on.

    Actions, ends and infos are those of :class:`~indoor_explorers.env.interfaces.gymnasium_env.IndoorExplorersEnv`;
    each agent's observation comes from its own view alone, and an agent that ends early leaves ``agents``. ``state()``
    is the global state with the true map, for learners with a central critic.

    Args:
        scenario: A scenario, the name of a preset or a .toml file.
        render_mode: ``rgb_array``, ``human`` (a window that shows every step; extra ``render``) or None.
        observation: Name of an encoder, or a factory of one, see :mod:`indoor_explorers.env.observations`.
        settings: Dotted settings to replace in the scenario, such as ``{"team": 3}``.
        index: Which map of a scenario with several map files.
        first_seed: Added to every seed that ``reset`` is given or draws, as in the Gymnasium environment.

    Raises:
        InputError: PettingZoo is not installed, or an argument is invalid.

    """
    _need_pettingzoo()
    from indoor_explorers.env.interfaces.pettingzoo_env import TeamEnv

    return TeamEnv(scenario, observation, render_mode, settings, index, first_seed)


def env(
    scenario: Scenario | str = "thesis-team-4",
    render_mode: str | None = None,
    observation: Observation = "channels",
    settings: Mapping[str, Any] | None = None,
    index: int = 0,
    first_seed: int = 0,
) -> Any:
    """Return the same environment as a PettingZoo ``AECEnv``: agents choose in turn, then all move at once."""
    raw = parallel_env(scenario, render_mode, observation, settings, index, first_seed)
    from pettingzoo.utils import parallel_to_aec, wrappers

    from indoor_explorers.env.interfaces.pettingzoo_env import CheckedActions

    return wrappers.OrderEnforcingWrapper(CheckedActions(parallel_to_aec(raw)))


def _need_pettingzoo() -> None:
    try:
        import pettingzoo  # noqa: F401
    except ModuleNotFoundError as error:
        raise InputError("PettingZoo is not installed; pip install 'indoor-explorers[marl]'") from error
