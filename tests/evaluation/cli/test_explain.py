"""The explain command, and what pilots tell of their choices."""

import re

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, Explanation, World, make_policy
from indoor_explorers.env.policies.explanation import MOST, of_moves, ranked
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.cli.parser import main

#: Policies that fly to the candidate of the highest score.
TO_THE_BEST = (
    *("frontier-latency", "frontier-predictive", "frontier-joint", "frontier-minpos", "frontier-tour"),
    *("rrt", "rrt-predictive", "cover-tour", "prm-tour", "dddqn", "tours"),
)


def told_by(policy_name, name, steps=40, **settings):
    """Return what the pilots of an episode told after each step, by (step, agent)."""
    world = World(PRESETS[name].with_settings(settings).for_evaluation())
    world.begin(0, 5)
    policy = make_policy(policy_name)
    pilots = make_pilots(policy, world)
    for pilot in pilots.values():
        pilot.explaining = True
    told = {}
    for _ in rollout(world, ask_pilots(policy, pilots, world)):
        step = int(world.state.step[0])
        told |= {(step, agent): pilot.explain() for (_, agent), pilot in pilots.items()}
        if step == steps:
            break
    return told


@pytest.mark.parametrize("policy", TO_THE_BEST)
def test_the_goal_is_the_candidate_of_the_highest_score(policy):
    told = told_by(policy, "small-floors", team=1)
    compared = [each for each in told.values() if each.candidates and not each.note]
    assert len(compared) > 20
    best = [each.candidates[0].score for each in compared]
    assert [each.candidates[0].cell for each in compared if each.goal is None] == []
    chosen = [next((one.score for one in each.candidates if one.cell == each.goal), None) for each in compared]
    assert np.mean([mine == top for mine, top in zip(chosen, best, strict=True)]) > 0.9


def test_ants_and_fields_tell_what_they_compare():
    for policy, share, parts in (("aco", 0.8, {"worth", "pheromone", "steps"}), ("hedac", 0.95, {"steps"})):
        compared = [each for each in told_by(policy, "small-floors", team=1).values() if each.candidates]
        compared = [each for each in compared if not each.note]
        assert len(compared) > 20, policy
        assert {name for each in compared for name in each.candidates[0].parts} == parts
        best = [each.candidates[0].cell == each.goal for each in compared]
        assert np.mean(best) >= share, policy
        among = [each.goal in [one.cell for one in each.candidates] for each in compared]
        assert np.mean(among) > 0.95, policy


def test_particles_and_wall_followers_tell_what_they_do():
    told = list(told_by("pso-robots", "thesis-team-4", steps=60).values())
    drifting = [each for each in told if each.note.startswith("drifts")]
    assert len(drifting) > 20
    assert all(each.goal is None and each.path == () for each in drifting)
    assert np.mean([len(each.candidates) > 0 for each in drifting]) > 0.9
    told = list(told_by("sgba", "thesis-obstacles", steps=60).values())
    assert {"along its bearing", "along a wall"} <= {each.note for each in told}
    assert all((each.goal is None) == each.note.startswith("along") for each in told)


def test_a_choice_is_kept_with_its_step_its_way_and_the_teammates_goals():
    told = told_by("frontier", "small-floors", team=2)
    goals = {agent: told[40, agent].goal for agent in (0, 1)}
    for agent in (0, 1):
        mine = told[40, agent]
        assert 0 <= mine.step <= 40
        assert mine.path[-1] == mine.goal
        assert all(abs(a - c) + abs(b - d) == 1 for (a, b), (c, d) in zip(mine.path, mine.path[1:], strict=False))
        scores = [each.score for each in mine.candidates]
        assert scores == sorted(scores, reverse=True)
    assert set(told[40, 0].mates) <= {1}
    assert None not in goals.values()


def test_nothing_is_kept_where_nobody_asks():
    world = World(PRESETS["small-floors"].with_settings({"team": 1}).for_evaluation())
    world.begin(0, 5)
    policy = make_policy("frontier-nearest")
    pilots = make_pilots(policy, world)
    next(iter(rollout(world, ask_pilots(policy, pilots, world))))
    assert pilots[0, 0].explain().candidates == ()


def test_the_best_finite_candidates_are_kept_in_order():
    cells = np.arange(20)
    scores = np.where(cells == 7, np.inf, -np.abs(cells - 9.0))
    found = ranked(cells, 5, scores, {"steps": cells, "weight": 2.0})
    assert len(found) == MOST
    assert [found[0].cell, found[1].cell] == [(1, 4), (1, 3)]
    assert found[0].parts == {"steps": 9.0, "weight": 2.0}
    assert (1, 2) not in [each.cell for each in found]


def test_moves_lead_to_cells_and_a_note_tells_where_another_was_made():
    world = World(PRESETS["thesis-open"].for_evaluation())
    world.begin(0, 3)
    view = world.view(0, 0)
    legal = np.flatnonzero(view.legal[:4])
    values = np.zeros(4)
    values[legal[0]] = 1.0
    best, other = (of_moves(view, int(action), values, "value", {}) for action in legal[:2])
    assert best.candidates[0].cell == best.goal
    assert (best.note, other.note) == ("", "not the move of the highest score")
    assert len(best.candidates) == len(legal)


@pytest.mark.parametrize("cell", [(0, 5), (15, 15)])
def test_a_uav_stays_where_its_move_is_illegal(cell):
    world = World(PRESETS["thesis-open"].for_evaluation())
    world.begin(0, 3)
    view = world.view(0, 0)
    for action in range(4):
        illegal = view._replace(cell=cell, legal=np.arange(5) != action)
        told = of_moves(illegal, action, np.arange(4.0), "value", {})
        assert told.goal == cell
        assert told.path == (cell, cell)
        assert told.note == "an illegal move: the UAV stays"


def test_the_command_prints_a_table_for_each_uav(capsys):
    words = ["--policy", "frontier", "--scenario", "small-floors", "--team", "2", "--seed", "3", "--step", "30"]
    assert main(["explain", *words]) == 0
    printed = capsys.readouterr().out
    assert [line.split(",")[0] for line in printed.splitlines() if line.startswith("UAV")] == ["UAV 0", "UAV 1"]
    assert "flies to (" in printed
    assert "score" in printed
    assert ">  (" in printed
    assert main(["explain", *words, "--agent", "1"]) == 0
    assert "UAV 0, step" not in capsys.readouterr().out


def test_a_policy_that_does_not_explain_says_so(capsys):
    assert main(["explain", "--policy", "random", "--scenario", "thesis-open", "--step", "2"]) == 0
    assert "this policy does not explain its actions" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--policy", "frontier", "--agent", "1"], "expected --agent from 0 to 0, got 1"),
        (["--policy", "frontier,pso"], "unknown policy 'frontier,pso'"),
        (["--policy", "frontier", "--set", "team=[1,2]"], "give one of each"),
        (["--policy", "frontier", "--step", "0"], "a whole number of at least 1"),
    ],
)
def test_bad_words_are_told_in_one_line(words, said, capsys):
    assert main(["explain", *words]) == 2
    line = capsys.readouterr().err
    assert said in line
    assert line.count("\n") == 1


def test_explanations_are_values():
    assert Explanation(step=1, goal=None) == Explanation(step=1, goal=None)


def test_cells_of_levels_are_level_row_and_column(capsys):
    flags = ["--policy", "frontier-nearest", "--scenario", "small-storeys", "--step", "20"]
    assert main(["explain", *flags]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"UAV 1, step 20, in \(\d, \d+, \d+\): flies to \(\d, \d+, \d+\), ", shown)
    assert re.search(r"\n> +\(\d, \d+, \d+\) ", shown)
    assert not re.search(r"\(\d+, \d+\)", shown)
