from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.planners.sampling.rrt_nbv import best_branch
from indoor_explorers.planners.sampling.trees import Tree


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
