"""How tests are handed to pytest's processes, and the maps that many of them use."""

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.learners.sessions.process import one_thread as on_one_thread
from tests import long_tests

HERE = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads the marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep the tests of a file in one process, so that fixtures are set up and machine code is loaded once.

    Where tests of a file have nothing in common, or those of several files do, a mark ``xdist_group`` says so. The
    files of this folder come first: they hold the longest tests, and no process is to wait for another one at the end.

    Tests that are listed as long and not marked as slow are marked so.
    """
    items.sort(key=lambda item: item.path.parent != HERE)
    listed = long_tests.read()
    for item in items:
        if item.get_closest_marker("slow") is None and long_tests.is_long(item.nodeid, listed):
            item.add_marker(pytest.mark.long)
        if item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.nodeid.partition("::")[0]))


def pytest_collection_finish(session: pytest.Session) -> None:
    """End the run if pytest-xdist does not keep tests together: fixtures would be set up in every process."""
    if getattr(session.config.option, "loadgroup", False) and not all("@" in item.nodeid for item in session.items):
        raise pytest.UsageError("pytest-xdist ignores the groups of tests; install the versions in constraints.txt")


@pytest.fixture(params=range(6))
def belief(request: pytest.FixtureRequest) -> Belief:
    """A random half-known map."""
    rng = np.random.default_rng(request.param)
    shape = (int(rng.integers(1, 25)), int(rng.integers(2, 25)))
    blocks = rng.random((-(-shape[0] // 3), -(-shape[1] // 3))) < 0.3
    unknown = np.kron(blocks, np.ones((3, 3), np.bool_))[: shape[0], : shape[1]].astype(np.bool_)
    cells = np.where(rng.random(shape) < 0.25, OCCUPIED, FREE)
    return np.where(unknown, UNKNOWN, cells).astype(np.uint8)


@pytest.fixture
def start(belief: Belief) -> Cell:
    """A free cell of that map."""
    row, col = np.argwhere(belief == FREE)[0].tolist()
    return row, col


@pytest.fixture
def one_thread() -> Iterator[None]:
    """Run torch on one thread: small matrices are slower on many, above all beside other processes."""
    with on_one_thread():
        yield


@pytest.fixture(scope="session")
def cluster() -> Iterator[Any]:
    """One Ray cluster for all tests that need one: a head without CPUs and two nodes of one CPU, on this machine."""
    from ray.cluster_utils import Cluster

    memory = 100 * 2**20
    found = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "object_store_memory": memory})
    for _ in range(2):
        found.add_node(num_cpus=1, object_store_memory=memory)
    yield found
    found.shutdown()


@pytest.fixture(scope="module")
def connected(cluster: Any) -> Iterator[Any]:
    """Stay connected to the cluster from one test to the next, which spares each the start of its workers."""
    import ray

    ray.init(cluster.address, log_to_driver=False, logging_level=logging.ERROR)
    yield cluster
    ray.shutdown()
