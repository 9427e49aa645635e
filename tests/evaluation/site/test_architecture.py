"""The picture of the architecture shows today's imports, and no room imports one above it."""

import ast

import networkx as nx
import pytest

from indoor_explorers.evaluation.site.pictures.architecture import (
    FLOORS,
    _imports,
    architecture_pictures,
    import_graph,
    room_of,
)

GRAPH = import_graph()


@pytest.mark.parametrize("floor", FLOORS)
def test_no_room_imports_one_that_imports_it(floor):
    rooms = GRAPH.subgraph([room for room in GRAPH if room.startswith(f"{floor}/")])
    assert len(rooms) > 5
    assert not list(nx.simple_cycles(rooms))


def test_the_picture_names_every_room():
    (drawn,) = architecture_pictures().values()
    assert drawn.count(b"<!-- ") >= len(GRAPH)
    for room in ("simulation", "navigation", "dddqn", "harness"):
        assert f"<!-- {room} -->".encode() in drawn


def test_imports_for_types_alone_and_within_a_room_do_not_count():
    code = """
from indoor_explorers.env.grid.cells import FREE
if TYPE_CHECKING:
    from indoor_explorers.env.maps.floorplan import Floorplan
def late():
    from indoor_explorers.planners.toolbox.navigation.paths import Paths
"""
    names = list(_imports(ast.parse(code)))
    assert [room_of(name.split(".")[1:]) for name in names] == ["env/grid", "planners/toolbox/navigation"]
    assert room_of(("planners", "toolbox", "__init__")) is None
    assert not any(one == other for one, other in GRAPH.edges)
