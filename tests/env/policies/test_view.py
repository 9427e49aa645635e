"""What a briefing tells."""

import pytest

from indoor_explorers.env import PRESETS, World


@pytest.mark.parametrize("name", ["thesis-obstacles", "small-rooms", "office"])
def test_a_briefing_tells_the_settings_of_a_generator_and_nothing_of_files(name):
    task = PRESETS[name]
    world = World(task)
    world.reset([0])
    assert world.briefing(0, 0).generator == (None if name == "office" else task.map)
