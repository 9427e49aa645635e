from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import World
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.swarm.gso import GlowwormPilot, Gso, adapted, brightened, brighter, drawn
from tests.planners.flights import world_on


def corridor(spawn: int, length: int = 40) -> tuple[World, View]:
    world = world_on(np.ones((1, length), np.bool_), [(0, spawn)])
    return world, world.view(0, 0)


def test_luciferin_follows_the_fitness() -> None:
    light = np.array([0.0, 10.0])
    assert brightened(light, np.array([5.0, 0.0]), 0.4, 0.6) == pytest.approx([3.0, 6.0])
    for _ in range(60):
        light = brightened(light, np.array([5.0, 2.0]), 0.4, 0.6)
    assert light == pytest.approx(np.array([5.0, 2.0]) * 0.6 / 0.4)


def test_neighbours_are_in_range_and_brighter() -> None:
    light, steps = np.array([3.0, 1.0, 5.0, 4.0]), np.array([2, 1, 9, 4], np.int32)
    assert brighter(light, 2.0, steps, 4.0).tolist() == [0, 3]
    assert brighter(light, 9.0, steps, 4.0).tolist() == []


@pytest.mark.parametrize(("neighbours", "expected"), [(5, 3.0), (2, 4.5), (7, 2.0), (20, 0.0), (0, 5.0)], ids=str)
def test_the_range_adapts_to_the_neighbours(neighbours: int, expected: float) -> None:
    assert adapted(3.0, neighbours, 5, 0.5, 5.0) == expected


def test_draws_are_in_proportion_to_the_weights() -> None:
    rng = np.random.default_rng(1)
    counts = np.bincount([drawn(np.array([1.0, 0.0, 3.0]), rng) for _ in range(4000)], minlength=3)
    assert counts[1] == 0
    assert counts[2] / 4000 == pytest.approx(0.75, abs=0.03)


def test_it_draws_a_glowworm_in_range_and_widens_the_range_for_others() -> None:
    world, view = corridor(5)
    pilot = GlowwormPilot(world.briefing(0, 0), Gso(start=0.0, adaption=0.1))
    pilot.act(view)
    assert pilot.goal in {(0, 2), (0, 8)}
    assert pilot._reach == pytest.approx(2.7)  # 3.0 for the draw, then narrowed for two neighbours


def test_glowworms_keep_their_light_and_new_ones_start_at_rest() -> None:
    world, _ = corridor(5)
    pilot = GlowwormPilot(world.briefing(0, 0), Gso())
    pilot._cells, pilot._luciferin = np.array([3, 20], np.int32), np.array([7.0, 8.0])
    assert pilot._before(np.array([4, 30, 19], np.int32), np.array([1.0, 2.0, 3.0])).tolist() == [7.0, 2.0, 8.0]


def test_goals_of_linked_teammates_are_dimmed() -> None:
    world = world_on(np.ones((1, 40), np.bool_), [(0, 19), (0, 20)], team=2, radio__model="unlimited")
    world.post(0, 1, (0.0, 23.0))
    world.step(np.array([[4, 4]]))
    pilot = GlowwormPilot(world.briefing(0, 0), Gso(dimming=0.75))
    pilot.act(world.view(0, 0))
    light = dict(zip(pilot._cells.tolist(), pilot._luciferin.tolist(), strict=True))
    assert light[23] == pytest.approx(0.25 * light[16])
