"""The benchmark names its figures as agreed, and measures what it says; the figures themselves are never tested."""

import json
from itertools import count

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, World, make_policy, policy_names
from indoor_explorers.env.grid.randomness import shuffled
from indoor_explorers.env.simulation.state import End
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.studies import bench
from indoor_explorers.evaluation.studies.bench import deciding, exploring, growth, interfaces, worlds
from indoor_explorers.evaluation.studies.bench.ancestor import ancestor_speed, of_world
from indoor_explorers.evaluation.studies.bench.figure import Benchmark, Figure, human, line_of
from tests.behaviour.policies import ALIKE, parametrized

PACED = "indoor_explorers.evaluation.studies.bench.harness:Paced"

UNITS = {
    "world-16x16-lidar3-team1": "agent-steps/s",
    "world-16x16-lidar3-team4": "agent-steps/s",
    "world-64x64-lidar10-team4": "agent-steps/s",
    "world-250x250-lidar35-team2": "agent-steps/s",
    "world-250x250-lidar35-team2-exploring-core": "agent-steps/s",
    "world-64x64x6-lidar10-team4-exploring-core": "agent-steps/s",
    "ancestor-16x16-team1": "agent-steps/s",
    "ratio-to-ancestor-team4": "x",
    "memory-64x64-lidar10-team4": "bytes",
    "gym-step": "us",
    "pettingzoo-step-team4": "us",
    "vector-channels-256": "env-steps/s",
    "lidar-range35": "us",
    "reset-250x250": "us",
    "first-compile": "s",
    "first-step": "s",
    "harness-1000-episodes": "s",
    **{f"isolation-16x16-team{team}": "us" for team in (1, 4)},
    **{f"harness-overhead-{policy}": "%" for policy in policy_names()},
    **{
        f"decide-{policy}-{size}{tail}": "us"
        for policy in policy_names()
        for size in ("16x16", "250x250", "250x250-team4")
        for tail in ("", "-p99", "-planning")
    },
}


@pytest.fixture
def instant(monkeypatch):
    """Measures that take no time."""
    found = [
        Benchmark(group, name, "x", lambda: 1.5) for group, name in (("Tall", "a-1"), ("Tall", "a-2"), ("Wide", "b"))
    ]
    grown = [Benchmark("Growth", name, "agent-steps/s", lambda: 2.5e6) for name in growth.growth()]
    grown += [Benchmark("Growth", name, "us", lambda: 40.0) for name in deciding.growth()]
    monkeypatch.setattr(bench, "measures", lambda everything, growing: found + grown * (everything or growing))
    return found


def test_paced_decisions_are_those_of_frontier_nearest():
    task = PRESETS["thesis-team-2"].for_evaluation().with_settings({"budget": 20})
    flights = [fly(make_policy(name), "p", task, [Task(task.name, 0, 0)]) for name in ("frontier-nearest", PACED)]
    one, other = (record for records in flights for record in records)
    np.testing.assert_array_equal(one.actions, other.actions)


def test_the_agreed_names_have_the_agreed_units():
    units = {measure.name: measure.unit for measure in bench.measures()}
    assert units | UNITS == units


def test_everything_holds_every_name_once_and_growth_and_what_takes_minutes():
    plain, names = ([measure.name for measure in bench.measures(everything=all_)] for all_ in (False, True))
    assert len(set(names)) == len(names)
    assert {
        "growth-area-1024x1024",
        "growth-lidar-50",
        "growth-team-64",
        "growth-batch-4096",
        "growth-decide-area-512x512-pso",
        "growth-decide-team-16-pso",
    } <= set(names)
    assert {"harness-10000-episodes", "train-10000-episodes", "isolation-16x16-team4-1ms"} <= set(names)
    assert set(names) > {measure.name for measure in bench.measures(growing=True)} > set(plain)


def test_it_prints_and_writes_every_figure(instant, capsys, tmp_path):
    assert main(["bench", "--json", str(tmp_path / "bench.json")]) == 0
    written = json.loads((tmp_path / "bench.json").read_text())
    assert written == [{"name": measure.name, "value": 1.5, "unit": "x"} for measure in instant]
    printed = capsys.readouterr().out
    assert [line.split()[0] for line in printed.splitlines()[:5]] == ["Tall", "a-1", "a-2", "Wide", "b"]
    assert "medians of 5 repetitions" in printed
    assert [path.name for path in tmp_path.iterdir()] == ["bench.json"]


def test_only_takes_patterns_and_refuses_those_that_name_nothing(instant, capsys):
    assert main(["bench", "--only", "a-*,growth-area-6*"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("a-1", "a-2", "growth-area-64x64"))
    assert "growth-team-1" not in printed
    assert "Wide" not in printed
    assert main(["bench", "--only", "c*"]) == 2
    assert "a-*, b-*" in capsys.readouterr().err


@pytest.mark.slow
def test_growth_is_drawn(instant, tmp_path):
    assert main(["bench", "--only", "a-1", "--figures", str(tmp_path / "drawn")]) == 0
    assert (tmp_path / "drawn" / "growth.png").read_bytes().startswith(b"\x89PNG")
    assert "agent-steps" in (tmp_path / "drawn" / "growth.svg").read_text()
    drawn = (tmp_path / "drawn" / "decisions.svg").read_text()
    contestants = [name for name in policy_names() if not make_policy(name).privileged]
    assert all(f"<!-- {policy} -->" in drawn for policy in contestants)
    assert "<!-- reference -->" not in drawn
    (tmp_path / "file").touch()
    assert main(["bench", "--only", "a-1", "--figures", str(tmp_path / "file")]) == 2


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (5_321_000.0, "agent-steps/s", "5.32 M agent-steps/s"),
        (63_940.0, "env-steps/s", "63.9 k env-steps/s"),
        (2_627.4, "agent-steps/s", "2,627 agent-steps/s"),
        (12.34, "us", "12.3 us"),
        (1_716.0, "us", "1.72 ms"),
        (3_031.0, "bytes", "2.96 KiB"),
        (0.523, "s", "0.52 s"),
        (1_361.0, "x", "1,361 x"),
    ],
)
def test_numbers_are_printed_in_units_that_suit_them(value, unit, text):
    assert " ".join(human(value, unit)) == text
    assert line_of(Figure("name", value, unit)).endswith(text)


def test_its_worlds_are_what_their_names_say():
    for name, (task, _) in worlds.WORLDS.items():
        assert name == f"world-{task.name}-lidar{task.lidar.range:g}-team{task.team}"


def test_measuring_measures():
    task = PRESETS["thesis-team-2"].with_settings({"budget": 5, "on_collision": "block"})
    moves = exploring.exploring_moves(task, 3, 12)
    for resets in (True, False):
        assert worlds.world_speed(task, 3, 12, threads=2, moves=moves, resets=resets) > 0
    assert worlds.reset_time(task, 2) > 0
    assert ancestor_speed(task, 2) > 0
    assert interfaces.gymnasium_step(20) > 0
    assert interfaces.pettingzoo_step(20) > 0
    assert interfaces.vector_speed(2, 5) > 0
    assert worlds.scan_time(3.0, 5) > 0


@parametrized(policy_names(), slow=ALIKE)
def test_every_policys_decisions_are_timed(name: str) -> None:
    found = deciding.decisions(name, 16, 3.0, 2, 3, 1)
    assert len(found.seconds) == 6
    assert (found.seconds > 0).all()


def test_decisions_over_levels_are_timed_with_estimates_and_without():
    figures = deciding.figures()
    for name, policy in {"frontier-predictive": "frontier-predictive", **deciding.WITH_ESTIMATES}.items():
        found = deciding.decisions(policy, 12, 4.0, 2, 3, 1, 4)
        assert len(found.seconds) == 6
        assert {f"decide-{name}-64x64x6-team4{end}" for end in ("", "-p99", "-planning")} <= figures.keys()


def test_decisions_that_make_a_plan_are_told_apart():
    found = deciding.decisions("frontier-nearest", 16, 3.0, 2, 30, 2)
    assert len(found.seconds) == len(found.planned) == 2 * 2 * 30
    assert 4 <= found.planned.sum() < len(found.planned)
    assert 0 < found.median() <= found.slowest()
    planned = found.seconds[found.planned]
    assert planned.min() * 1e6 <= found.planning() <= planned.max() * 1e6
    assert deciding.decisions("random", 16, 3.0, 2, 5, 1).planned.all()
    assert deciding.planning("random", 32, 2) > 0


@pytest.mark.parametrize("team", [1, 3])
def test_growth_is_measured_on_maps_known_but_for_squares(team):
    world = World(worlds.square(40, deciding.GROWTH_LIDAR, team))
    world.reset([1])
    deciding._reveal(world)
    known = world.state.belief[0] > 0
    assert 0.74 < known.mean() < 0.95
    assert known[:, :10].all()
    assert not known[:, 10:20, 10:20].all()
    assert (world.state.belief[0][known] == np.broadcast_to(world.state.truth[0], known.shape)[known]).all()


def test_memory_is_all_that_an_episode_adds_to_the_state():
    task, sizes = worlds.square(16, 3.0, 4), []
    for batch in (1, 5):
        world = World(task, batch)
        world.reset(range(batch))
        sizes.append(sum(array.nbytes for array in world.state))
    assert worlds.memory(task) == sizes[0] == (sizes[1] - sizes[0]) / 4


@pytest.mark.parametrize(("side", "team", "lidar_range"), [(16, 1, 3.0), (16, 4, 1.0), (24, 3, 5.0)])
def test_exploring_moves_are_legal_and_cover_map_after_map(side, team, lidar_range):
    task, batch, steps = worlds.square(side, lidar_range, team), 5, 400
    moves = exploring.exploring_moves(task, batch, steps)
    world = World(task, batch)
    seeds = worlds.first_episodes(world)
    covered = 0
    for actions in moves:
        assert np.take_along_axis(world.state.legal, actions[..., None], axis=2)[world.flying].all()
        world.step(actions)
        assert not world.state.collisions.any()
        assert not world.state.blocked.all()
        covered += int((world.state.end == End.GOAL).all(axis=1).sum())
        worlds.next_episodes(world, seeds)
    assert covered >= batch
    assert next(seeds) == batch + covered  # none ended but by covering all


@pytest.mark.parametrize("obstacles", [0, 5])
@pytest.mark.parametrize(("team", "radio"), [(1, "none"), (4, "none"), (4, "square")])
def test_the_restated_ancestor_agrees_with_the_world(obstacles, team, radio):
    task = PRESETS["thesis-obstacles"].with_settings(
        {
            "team": team,
            "map.obstacles": obstacles,
            "lidar.model": "marsexplorer",
            "radio": {"model": radio, "range": 3.0 if radio == "square" else 0.0},
            "on_collision": "block",
            "stuck.rule": "off",
        }
    )
    world = World(task)
    world.reset([obstacles + team])
    ancestor, order = of_world(world), np.empty(team, np.int64)
    for actions in worlds.random_moves(1, team, 200):
        shuffled(world.state.order_key[0], world.state.step[0], order)
        world.step(actions)
        observations, rewards, over = ancestor.step(actions[0].tolist(), order.tolist())
        assert ancestor.cells == [tuple(cell) for cell in world.state.cell[0].tolist()]
        for agent in range(team):
            assert ancestor.coverage(agent) == world.coverage[0, agent]
            np.testing.assert_array_equal(ancestor.explored[agent] > 0, world.state.belief[0, agent] > 0)
            assert observations[agent][ancestor.cells[agent]] == agent + 1
        assert rewards == (world.state.reward[0] + world.state.received[0]).tolist()
        assert over == (~world.flying[0]).tolist()
        if any(over):  # the world's UAV is gone now, the ancestor's is not
            break
    assert world.state.step[0] == 200 or world.coverage.max() >= 0.9


def test_a_pattern_is_matched_with_case():
    some = [Benchmark("Group", name, "s", count().__next__) for name in ("one", "Two")]
    assert [measure.name for measure in bench.chosen(some, ["T*"])] == ["Two"]
    with pytest.raises(InputError, match="one-"):
        bench.chosen(some, ["t*"])
