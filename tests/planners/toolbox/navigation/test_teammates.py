from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import Mate, View, World, scenario
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.planners.toolbox.navigation.teammates import CLAIM_STEPS, MEMORY, claims, ranks, remembered
from tests.planners.flights import view_of


def with_mate(mate: Mate) -> View:
    return view_of(np.ones((40, 40), np.uint8), (20, 20), (mate,))


@pytest.mark.parametrize(
    ("model", "mate", "expected"),
    [
        ("disc", Mate(1, (20, 22), 0, None), True),
        ("disc", Mate(1, (20, 22), 2, None), False),  # within 4 of here for certain, yet silent: it has ended
        ("disc", Mate(1, (20, 22), 4, None), True),  # may have left the range of 5
        ("disc", Mate(1, (24, 24), 0, None), True),
        ("disc", Mate(1, (23, 23), 1, None), True),  # 4.2 + 1 > 5
        ("square", Mate(1, (23, 23), 1, None), False),  # 3 + 1 <= 5
        ("unlimited", Mate(1, (0, 0), 1, None), False),
        ("line-of-sight", Mate(1, (20, 22), 2, None), True),  # a wall may be between
        ("path-loss", Mate(1, (20, 22), 2, None), True),
        ("none", Mate(1, (20, 22), 2, None), True),
        ("disc", Mate(1, (0, 0), MEMORY, None), True),
        ("disc", Mate(1, (0, 0), MEMORY + 1, None), False),
    ],
)
def test_who_is_remembered(model: str, mate: Mate, expected: bool) -> None:
    task = scenario("thesis-team-2").with_settings({"radio.model": model, "radio.range": 5.0})
    world = World(task)
    world.reset([0])
    assert bool(remembered(with_mate(mate), world.briefing(0, 0))) is expected


def test_silence_proves_nothing_where_contacts_are_lost() -> None:
    settings = {"radio.model": "disc", "radio.range": 5.0, "radio.loss": 0.1}
    world = World(scenario("thesis-team-2").with_settings(settings))
    world.reset([0])
    assert remembered(with_mate(Mate(1, (20, 22), 2, None)), world.briefing(0, 0))


def test_claims_expire() -> None:
    world = World(scenario("thesis-team-2"))
    world.reset([0])
    fresh, stale = Mate(1, (0, 0), CLAIM_STEPS, (3.0, 4.0)), Mate(1, (0, 0), CLAIM_STEPS + 1, (5.0, 6.0))
    briefing = world.briefing(0, 0)
    assert claims(with_mate(fresh), briefing).tolist() == [[3.0, 4.0]]
    assert claims(with_mate(stale), briefing).shape == (0, 2)
    assert claims(with_mate(Mate(1, (0, 0), 0, None)), briefing).shape == (0, 2)


def test_ranks_count_the_nearer_ones() -> None:
    own = np.array([5, 5, 5, UNREACHABLE], np.int32)
    others = [np.array([4, 5, 6, 1], np.int32), np.array([4, 5, 6, 1], np.int32)]
    assert ranks(own, others, [True, False])[:3].tolist() == [2, 1, 0]
    assert ranks(own, others, [True, False])[3] >= 3
