from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.planners.sampling.rrt_nbv import best_branch
from indoor_explorers.planners.sampling.segments import BLOCKED, trace
from indoor_explorers.planners.sampling.trees import Tree, grow_tree


def some_belief() -> Belief:
    belief = np.ones((30, 40), np.uint8)
    belief[np.random.default_rng(1).random(belief.shape) < 0.1] = 2
    belief[0, 0] = 1
    return belief


def some_tree(seed: int = 0, *, optimal: bool = False) -> Tree:
    samples = np.random.default_rng(seed).random((200, 2)) * (30, 40)
    return grow_tree(some_belief(), (0.5, 0.5), samples, 4.0, optimal=optimal)


def test_a_process_that_exits_in_flight_says_nothing() -> None:
    script = """
import functools, sys
import numpy as np
from indoor_explorers.env import World, make_policy, scenario
world = World(scenario("thesis-obstacles"))
world.reset([0])
policy = make_policy("rrt-frontier")
pilots = [policy.pilot(world.briefing(0, 0))]
for _ in range(15):
    world.step(np.array([policy.act(pilots, [world.view(0, 0)])]))
keep = functools.lru_cache(lambda number: pilots)
keep(0)
sys.exit(0)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


@pytest.mark.parametrize("optimal", [False, True])
def test_edges_are_short_and_clear(optimal: bool) -> None:
    belief, tree = some_belief(), some_tree(optimal=optimal)
    assert tree.parents[0] == -1
    assert tree.vertices[0].tolist() == [0.5, 0.5]
    assert len(tree.vertices) > 50
    for vertex, parent in zip(tree.vertices[1:], tree.parents[1:].tolist(), strict=True):
        assert np.hypot(*(vertex - tree.vertices[parent])) <= 4.0 + 1e-9
        assert trace(belief, *tree.vertices[parent], *vertex) != BLOCKED


@pytest.mark.parametrize("optimal", [False, True])
def test_parents_come_first(optimal: bool) -> None:
    tree = some_tree(optimal=optimal)
    assert (tree.parents < np.arange(len(tree.parents))).all()


def test_a_star_reaches_the_same_points_by_shorter_ways() -> None:
    plain, star = some_tree(), some_tree(optimal=True)
    assert {*map(tuple, plain.vertices.tolist())} == {*map(tuple, star.vertices.tolist())}
    length = dict(zip(map(tuple, plain.vertices.tolist()), plain.lengths().tolist(), strict=True))
    ways = list(zip(map(tuple, star.vertices.tolist()), star.lengths().tolist(), strict=True))
    assert all(way <= length[vertex] + 1e-9 for vertex, way in ways)
    assert sum(way for _, way in ways) < 0.95 * sum(length.values())


def test_a_tree_can_keep_to_known_cells() -> None:
    belief = some_belief()
    belief[:, 15:18] = 0
    samples = np.random.default_rng(3).random((300, 2)) * (30, 40)
    known = grow_tree(belief, (0.5, 0.5), samples, 4.0, into_unknown=False)
    assert known.vertices[:, 1].max() < 15
    assert grow_tree(belief, (0.5, 0.5), samples, 4.0).vertices[:, 1].max() > 18


def test_other_samples_make_another_tree() -> None:
    assert not np.array_equal(some_tree(0).vertices, some_tree(1).vertices)


@pytest.mark.parametrize("count", [0, 1])
def test_few_samples(count: int) -> None:
    tree = grow_tree(np.ones((5, 5), np.uint8), (0.5, 0.5), np.full((count, 2), 3.0), 10.0)
    assert tree.vertices.tolist() == [[0.5, 0.5], [3.0, 3.0]][: count + 1]


def test_a_walled_in_root_grows_nothing() -> None:
    belief = np.full((3, 3), 2, np.uint8)
    belief[1, 1] = 1
    tree = grow_tree(belief, (1.5, 1.5), np.array([[0.5, 0.5], [2.5, 1.5]]), 5.0)
    assert tree.vertices.tolist() == [[1.5, 1.5]]


def random_tree(seed: int) -> tuple[Tree, np.ndarray]:
    rng = np.random.default_rng(seed)
    parents = np.array([-1, *(int(rng.integers(k)) for k in range(1, 30))])
    return Tree(rng.random((30, 2)), parents), rng.random(30) * (rng.random(30) < 0.5)


@pytest.mark.parametrize("seed", range(8))
def test_no_branch_is_worth_more_than_the_best(seed: int) -> None:
    tree, values = random_tree(seed)
    branch = best_branch(tree, values).tolist()
    assert branch[0] == 0
    assert [tree.parents[vertex] for vertex in branch[1:]] == branch[:-1]

    def worth(vertex: int) -> float:
        return float(values[vertex]) + (worth(int(tree.parents[vertex])) if vertex else 0.0)

    assert sum(values[branch]) == pytest.approx(max(worth(vertex) for vertex in range(30)))


def test_a_tree_that_gains_nothing_has_the_root_as_its_branch() -> None:
    tree, values = random_tree(0)
    assert best_branch(tree, 0.0 * values).tolist() == [0]


def test_lengths_add_up_along_the_tree() -> None:
    tree = Tree(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0], [0.0, 2.0]]), np.array([-1, 0, 1, 0]))
    assert tree.lengths().tolist() == [0.0, 5.0, 6.0, 2.0]
