from __future__ import annotations

from pathlib import Path

import pytest

from tests.behaviour.worlds import write_maps


@pytest.fixture(scope="session")
def map_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the map files that worlds name."""
    folder = tmp_path_factory.mktemp("maps")
    write_maps(folder)
    return folder
