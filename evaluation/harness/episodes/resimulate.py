"""Simulate a recorded episode again, step by step, from its map, seed and actions."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np

from indoor_explorers.env import InputError, Scenario, World
from indoor_explorers.env.maps.generators.storeys import StoreysMaps
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.stored_names import MODELS, refusal


def recorded_scenario(settings: Mapping[str, Any], plugins: Collection[str] = ()) -> Scenario:
    """Return a stored scenario; its map source is left out, since records bring their own maps.

    Raises:
        InputError: it is no scenario, or has a lidar or radio from outside this package that is not in ``plugins``.

    """
    if why := refusal(settings, plugins, MODELS):
        raise InputError(f"stored scenario {settings.get('name')!r}: {why}")
    kept = {key: value for key, value in settings.items() if key not in ("fingerprint", "map")}
    return validated(Scenario, kept, f"stored scenario {kept.get('name')!r}")


def on_levels(scenario: Scenario, levels: int) -> Scenario:
    """Return a scenario whose maps have a number of levels; recorded ones do not say how many."""
    if scenario.map.level_count == levels:
        return scenario
    return scenario.model_copy(update={"map": StoreysMaps(storeys=1, storey_height=levels)})


def resimulate(record: Record, scenario: Scenario) -> Iterator[World]:
    """Yield a world with the recorded episode in place 0, at its start and after each of its S steps.

    Positions, beliefs, radio contacts and coverage are those of the recorded episode; messages of pilots are not
    stored. Every step yields the same world object: read it before asking for the next.
    """
    world = World(on_levels(scenario, record.floorplan.level_count))
    world.begin(0, record.task.seed, floorplan=record.floorplan)
    yield world
    for actions in record.actions:
        world.step(actions[None])
        yield world


def ended_as_recorded(record: Record, world: World) -> bool:
    """Tell whether the simulated episode in place 0 ended as recorded; in another version of the world it may not."""
    state = world.state
    return np.array_equal(state.cell[0], record.cells[-1]) and bool(state.team_covered[0] == record.seen[-1])
