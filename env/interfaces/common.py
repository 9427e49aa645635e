"""Shared parts of the Gymnasium and PettingZoo interfaces of the world."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError, did_you_mean, shown
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.observations.base import Encoder
from indoor_explorers.env.policies.policy import checked_action, integers
from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End, State
from indoor_explorers.env.simulation.world import World

#: How interfaces render: in a window, or as an (h, w, 3) uint8 image.
RENDER_MODES = ("human", "rgb_array")
#: How an interface with many episodes renders: one image for each.
VECTOR_RENDER_MODES = ("rgb_array",)
#: Frames per second of a window and of a recording.
RENDER_FPS = 8
#: Exclusive upper bound of the seeds that a reset without a seed draws.
SEED_LIMIT = 2**31


def find_scenario(scenario: Scenario | str, settings: Mapping[str, Any] | None = None) -> Scenario:
    """Return a scenario, preset or .toml file with dotted ``settings`` replaced.

    Raises:
        InputError: there is no such scenario or setting, or a value is invalid.

    """
    if isinstance(scenario, str):
        scenario = named_scenario(scenario)
    if not isinstance(scenario, Scenario):
        raise InputError(f"expected a scenario, the name of a preset or a .toml file, got {shown(scenario)}")
    if not isinstance(settings or {}, Mapping):
        raise InputError(f"expected settings by name such as {{'lidar.range': 5}}, got {shown(settings)}")
    return scenario.with_settings(settings) if settings else scenario


def find_render_mode(render_mode: str | None, modes: Collection[str] = RENDER_MODES) -> str | None:
    """Return the render mode, refusing unknown ones."""
    if render_mode is not None and render_mode not in modes:
        raise InputError(f"unknown render mode {render_mode!r}{did_you_mean(render_mode, modes)}")
    return render_mode


def new_world(scenario: Scenario, batch: int, index: int, threads: int = 1) -> World:
    """Return a world in which episode 0 has begun on map ``index``, so that shapes and briefings are known."""
    world = World(scenario, batch, threads=threads)
    world.begin(0, 0, index=index)
    return world


def new_lone_world(scenario: Scenario, batch: int, index: int, threads: int = 1) -> World:
    """Return a world like :func:`new_world`; raise :class:`InputError` for a scenario with several UAVs."""
    if scenario.team > 1:
        raise InputError(
            f"expected a scenario with one UAV, got {scenario.name!r} with a team of {scenario.team}; "
            "use indoor_explorers.env.parallel_env, or settings={'team': 1}"
        )
    return new_world(scenario, batch, index, threads)


def one_action(action: Any, count: int) -> int:
    """Return the action of an integer or a zero-dimensional array; raise :class:`InputError` for no action."""
    if isinstance(action, (int, np.integer)):
        return checked_action(action, count)
    array = integers(action, count)
    return checked_action(action if array.ndim else array.item(), count)


def draw_seed(rng: np.random.Generator) -> int:
    """Draw the seed of the next episode."""
    return int(rng.integers(SEED_LIMIT))


def begin_encoder(encoder: Encoder, world: World, episode: int, agent: int) -> None:
    """Prepare an encoder for an episode that has begun; with a home base or a prior map, it gets a new briefing."""
    if world.scenario.base.exists or world.scenario.prior.kind != "none":
        encoder.begin(world.briefing(episode, agent))
    else:
        encoder.reset()


def is_terminated(end: int) -> bool:
    """Tell whether an :class:`End` is a termination: goal, collision, out of bounds, stuck or stopped."""
    return end not in (End.FLYING, End.BUDGET)


def legal_actions(world: World) -> Mask:
    """Return (B, N, A) actions that end neither in a wall nor off the map; a turn is always legal."""
    legal = world.state.legal
    return legal if not world.scenario.turns else np.concatenate((legal, np.ones_like(legal[..., :1])), axis=-1)


def info_of(world: World, episode: int, agent: int) -> dict[str, Any]:
    """Return the info dict of an observation.

    ``action_mask`` (A,) int8: 1 for actions that end neither in a wall nor off the map; ``coverage``: the share of the
    denominator that the UAV knows; ``step``: steps flown; ``end``: an :class:`End`. With a home base also ``base_age``:
    steps since the UAV's last contact with it, -1 for never; and ``base_coverage``: the share of the denominator that
    the base knows, which a UAV out of contact cannot observe: for rewards and logs only.
    """
    state = world.state
    info = {
        "action_mask": legal_actions(world)[episode, agent].astype(np.int8),
        "coverage": float(state.covered[episode, agent] / state.total[episode]),
        "step": int(state.step[episode]),
        "end": int(state.end[episode, agent]),
    }
    if world.scenario.base.exists:
        info["base_age"] = int(base_age(state)[episode, agent])
        info["base_coverage"] = float(state.base_covered[episode] / state.total[episode])
    return info


def base_age(state: State) -> NDArray[np.int64]:
    """Return (B, N) the steps since each agent's last contact with the home base, -1 for never."""
    return np.where(state.base_step < 0, -1, state.step[:, None] - state.base_step)
