"""The state of a batch of worlds (episodes in parallel) as arrays, for checkpoints of trainings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.simulation.world import World

#: Names in checkpoints of arrays of the state that have been renamed since; old checkpoints stay readable.
STORED_NAMES = {
    "discovery_log": "journal",
    "merged_up_to": "read",
    "last_received_step": "heard_step",
    "last_received_cell": "heard_cell",
    "last_received": "heard",
    "last_received_size": "heard_size",
}


def world_tensors(world: World) -> dict[str, NDArray[Any]]:
    """Return the state and the episodes' seeds of a batch of worlds, by name; the arrays are views, not copies."""
    state = {_stored(name): array for name, array in _arrays(world).items()}
    return state | {"world/seeds": np.array([[seed >> 32, seed & 0xFFFFFFFF] for seed in world.seeds], np.int64)}


def begin(world: World, episode: int, seed: int) -> None:
    """Begin an episode of a batch; in scenarios with several map files the seed selects the map."""
    world.begin(episode, seed, index=seed % world.scenario.map.count)


def restore_world(tensors: Mapping[str, NDArray[Any]], world: World) -> None:
    """Restore a batch of worlds from the arrays of :func:`world_tensors`."""
    for episode, (high, low) in enumerate(tensors["world/seeds"].tolist()):
        begin(world, episode, (high << 32) | low)
    for name, array in _arrays(world).items():
        array[...] = tensors[_stored(name)]


def _arrays(world: World) -> dict[str, NDArray[Any]]:
    """Return the arrays of a batch of worlds by name; where poses are certain the believed cells are the true ones."""
    arrays: dict[str, NDArray[Any]] = world.state._asdict()
    if world.slam is None:
        del arrays["believed_cell"]
        return arrays
    return arrays | {f"slam/{name}": array for name, array in world.slam._asdict().items()}


def _stored(name: str) -> str:
    """Return the name of an array of the state in checkpoints."""
    return f"world/{STORED_NAMES.get(name, name)}"
