"""The picture of the architecture shows today's imports, and no package imports one above it."""

import ast

import networkx as nx
import pytest

from indoor_explorers.evaluation.site.pictures.architecture import (
    TOP_LEVEL,
    _imports,
    architecture_pictures,
    import_graph,
    package_of,
)


@pytest.fixture(scope="module")
def graph():
    return import_graph()


@pytest.mark.parametrize("folder", TOP_LEVEL)
def test_no_package_imports_one_that_imports_it(folder, graph):
    packages = graph.subgraph([package for package in graph if package.startswith(f"{folder}/")])
    assert len(packages) > 5
    assert not list(nx.simple_cycles(packages))


def test_the_picture_names_every_package(graph):
    (drawn,) = architecture_pictures().values()
    assert drawn.count(b"<!-- ") >= len(graph)
    for package in ("simulation", "navigation", "dddqn", "harness"):
        assert f"<!-- {package} -->".encode() in drawn


def test_imports_for_types_alone_and_within_a_package_do_not_count(graph):
    code = """
from indoor_explorers.env.grid.cells import FREE
if TYPE_CHECKING:
    from indoor_explorers.env.maps.floorplan import Floorplan
def late():
    from indoor_explorers.planners.toolbox.navigation.paths import Paths
"""
    names = list(_imports(ast.parse(code)))
    assert [package_of(name.split(".")[1:]) for name in names] == ["env/grid", "planners/toolbox/navigation"]
    assert package_of(("planners", "toolbox", "__init__")) is None
    assert not any(one == other for one, other in graph.edges)
