"""What views and briefings tell."""

import gc
import types
import weakref

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, World
from indoor_explorers.env.scenarios.presets import on_files


@pytest.mark.parametrize("name", ["thesis-obstacles", "small-rooms", "office"])
def test_a_briefing_tells_the_settings_of_a_generator_and_nothing_of_files(name):
    task = PRESETS[name]
    world = World(task)
    world.reset([0])
    assert world.briefing(0, 0).generator == (None if name == "office" else task.map)


def test_a_briefing_names_no_map_files_unless_it_tells_the_map(tmp_path):
    paths = [str(tmp_path / f"{name}.npy") for name in ("one", "two")]
    for path in paths:
        np.save(path, np.zeros((9, 12), np.uint8))
    world = World(on_files(paths, None))
    world.reset([0])
    told = world.briefing(0, 0).scenario.map
    assert told.count == 2
    assert not any(path in told.model_dump_json() for path in paths)
    with pytest.raises(InputError):
        told.floorplan(0, 0)
    assert world.briefing(0, 0, privileged=True).scenario.map.paths == tuple(paths)


def reachable(root):
    """All arrays that Python finds from an object: through attributes, bases, buffers and callbacks."""
    found, waiting, seen = [], [root], {}
    while waiting:
        thing = waiting.pop()
        if id(thing) in seen or isinstance(thing, (types.ModuleType, types.FunctionType, type)):
            continue
        seen[id(thing)] = thing
        waiting += gc.get_referents(thing)
        waiting += [call.__callback__ for call in weakref.getweakrefs(thing)] if hasattr(thing, "__weakref__") else []
        if isinstance(thing, weakref.finalize):
            waiting.append(thing.peek())
        if isinstance(thing, np.ndarray):
            found.append(thing)
            waiting += [thing.base, memoryview(thing).obj]
        waiting.append(getattr(thing, "__array_interface__", None))
    return found, list(seen.values())


def test_nothing_leads_from_a_view_or_briefing_to_another_map():
    world = World(PRESETS["thesis-team-4"], 2)
    world.reset([5, 6])
    state = world.state
    for episode, agent in np.ndindex(state.end.shape):
        arrays, things = reachable((world.view(episode, agent), world.briefing(episode, agent)))
        own = [array[episode, agent] for array in (state.belief, state.legal, state.visited)]
        assert len(arrays) >= len(own)
        assert all(thing is not world for thing in things)
        for array in arrays:
            assert array.size <= own[0].size
            assert not np.may_share_memory(array, state.truth)
            for lent, mine in zip((state.belief, state.legal, state.visited), own, strict=True):
                assert not np.shares_memory(array, lent) or np.may_share_memory(array, mine)
        windows = [thing for thing in things if isinstance(thing, dict) and "typestr" in thing]
        assert max(np.prod(window["shape"]) for window in windows) <= own[0].size
