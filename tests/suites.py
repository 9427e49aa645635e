"""A small suite for tests: map files of two made-up repositories, written into folders as clones of them are."""

import hashlib
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.scenarios.suites import catalogue

#: Name, part and building of each map.
MAPS = (("a1", "test", "A"), ("a2", "test", "A"), ("b", "test", "B"), ("c", "validation", "C"), ("d", "train", "D"))
HEAD = """
name = "tiny"
version = 3
about = "maps of a test"
split = "by building"
starts = 2
resolution = 1.0
teams = [1, 2]
settings = { "lidar.range" = 4.0 }
radios = { none = { model = "none" }, disc = { model = "disc", range = 6.0 } }
"""


def write_clones(folder: Path) -> Path:
    """Write the maps of two repositories; the files of the second one are in a folder of it."""
    for name, _, _ in MAPS:
        rng = np.random.default_rng(sum(map(ord, name)))
        cells = (rng.random((9, 11)) < 0.1).astype(np.int8)
        file = folder / (f"plans/deep/{name}.npy" if name > "b" else f"floors/{name}.npy")
        file.parent.mkdir(parents=True, exist_ok=True)
        np.save(file, cells)
    return folder


def repository(name: str, inside: str, maps: list[tuple[str, str, str]], clones: Path) -> str:
    """Return a repository's table of a manifest."""
    rows = []
    for stem, part, building in maps:
        file = clones / name / inside / f"{stem}.npy"
        sha, plan = hashlib.sha256(file.read_bytes()).hexdigest(), read_map(file, 1.0)
        rows.append(
            f'{{ part = "{part}", building = "{building}", cells = 9, digest = "{plan.digest}", '
            f'layout = "{plan.layout}", files = {{ "{stem}.npy" = "{sha}" }} }}'
        )
    return (
        f'[[repositories]]\nurl = "https://example.org/us/{name}"\ncommit = "{name[0] * 40}"\nlicence = "MIT"\n'
        f'folder = "{inside}"\nmaps = [{", ".join(rows)}]\n'
    )


@pytest.fixture(scope="session")
def tiny_clones(tmp_path_factory):
    """A folder with the clones that the suite tiny needs."""
    return write_clones(tmp_path_factory.mktemp("clones"))


@pytest.fixture
def tiny(tiny_clones, tmp_path, monkeypatch):
    """Have the suite tiny, and no other; returns the folder of its clones."""
    folder = tmp_path / "suites"
    folder.mkdir()
    first = repository("floors", "", [each for each in MAPS if each[0] <= "b"], tiny_clones)
    second = repository("plans", "deep/", [each for each in MAPS if each[0] > "b"], tiny_clones)
    (folder / "tiny-3.toml").write_text(HEAD + first + second)
    monkeypatch.setattr(catalogue, "FOLDER", folder)
    forget()
    yield tiny_clones
    forget()


def forget() -> None:
    """Have the suites read again."""
    catalogue.all_suites.cache_clear()
    catalogue.buildings.cache_clear()
