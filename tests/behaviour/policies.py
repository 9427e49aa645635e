"""The policies that this project registers, now or later."""

import tomllib
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import pytest

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
#: The class of each policy by name; those of other installed packages are left out.
CLASSES: dict[str, str] = PROJECT["entry-points"]["indoor_explorers.policies"]
#: Short names of the best of a family, and the names that they stand for.
ALIASES = {"frontier": "frontier-joint", "rrt": "rrt-aep"}
#: Every class once.
POLICIES = tuple(name for name in CLASSES if name not in ALIASES)
#: Those that need not explore a whole map: chance, and the thesis's learner as it was.
UNRELIABLE = ("random", "dddqn-thesis")
#: Those that explore all of every map they are given.
EXPLORERS = tuple(name for name in POLICIES if name not in UNRELIABLE)
#: An exhaustive search, which has tests of its own, and flies as `reference` does.
EXHAUSTIVE = ("optimum",)
#: Policies that fly as `frontier` where there is no base, no prior map or no drift, which their own tests compare.
AS_FRONTIER = ("return-to-base", "prior-tour", "loop-closing")
#: Policies that fly as others do, by the estimates of `frontier-predictive`.
BY_ESTIMATES = ("pso-predictive", "rrt-predictive", "dddqn-reports", "camera-paths")
#: Policies that share all but a score or an order with another one.
SIBLINGS = (
    *("frontier-mrtsp", "frontier-octree", "frontier-hungarian", "frontier-advantage", "frontier-tour"),
    *("frontier-minpos", "frontier-utility", "gso", "prm-tour", "cover-tour", "level-by-level"),
)
#: Policies of which `make test` flies the golden episodes and their own tests; `make test-all` flies all.
ALIKE = (*AS_FRONTIER, *BY_ESTIMATES, *SIBLINGS)


def parametrized(names: Sequence[str], slow: Sequence[str] = ()) -> pytest.MarkDecorator:
    """Return a mark that runs a test for each ``name``, all tests of a policy in one process; for some it is slow."""
    return pytest.mark.parametrize(
        "name", [pytest.param(name, marks=_marks(name, slow=name in slow)) for name in names]
    )


def with_rows(names: Sequence[str], rows: Sequence[dict[str, Any]], slow: Sequence[str]) -> pytest.MarkDecorator:
    """Return a mark that runs a test for each ``name`` and ``row``; each policy is slow with five of six rows.

    Which rows are not slow changes from policy to policy, so that `make test` flies all of both.
    """
    found = []
    for (number, name), (k, row) in product(enumerate(names), enumerate(rows)):
        marks = _marks(name, slow=name in slow or (number + k) % 6 > 0)
        found.append(pytest.param(name, row, marks=marks, id="-".join([*map(str, row.values()), name])))
    return pytest.mark.parametrize(("name", "row"), found)


def _marks(name: str, *, slow: bool) -> list[pytest.MarkDecorator]:
    """Return the marks of a test of a policy; those of an exhaustive search are always slow."""
    return [pytest.mark.xdist_group(name), *[pytest.mark.slow] * (slow or name in EXHAUSTIVE)]
