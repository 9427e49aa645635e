"""The page on tabular learning says of further trainings what they give."""

import random
import re
from statistics import mean

import pytest

from indoor_explorers.evaluation.site.pictures.tabular import PAGE, SEEDS, page_functions, training

TEXT = " ".join(PAGE.read_text("utf-8").split())


def in_test_rooms(obstacles, state, table):
    """The steps of a trained table in the rooms of the tests, and the states of the last ten of each."""
    names, lasts = page_functions(), []
    env, visited = names["room"](obstacles), []

    def recorded(planes, legal):
        visited.append(names[state](planes, legal))
        return visited[-1]

    steps = []
    for seed in names["TESTS"]:
        steps.append(names["fly"](env, recorded, table, seed, random))
        lasts.append(set(visited[-10:]))
    return steps, lasts


@pytest.mark.slow
def test_a_fixed_table_can_repeat_two_states():
    table, steps = training(0, "near", "Q-learning", 3)
    tests, lasts = in_test_rooms(0, "near", table)
    assert set(tests) == {page_functions()["BUDGET"]}
    assert {len(states) for states in lasts} == {2}
    assert f"takes {mean(steps[-100:]):.1f} steps on average in its last 100 episodes" in TEXT


@pytest.mark.slow  # guarded by the other trainings
@pytest.mark.parametrize("learner", ["Q-learning", "Sarsa"])
def test_trainings_differ(learner):
    tables = [training(0, "place", learner, seed)[0] for seed in SEEDS]
    found = [f"{mean(in_test_rooms(0, 'place', table)[0]):.1f}" for table in tables]
    assert re.search(rf"{found[0]}, {found[1]} and {found[2]} (steps )?by {learner}", TEXT)


@pytest.mark.slow
def test_the_training_on_all_that_is_known_made_the_steps_that_the_page_counts():
    table, steps = training(2, "whole", "Q-learning", 1)
    assert f"made {sum(steps):,} steps and saw {len(table):,} states" in TEXT
