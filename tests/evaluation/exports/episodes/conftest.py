"""Results to export from."""

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.evaluation import Results, compare, exports
from tests.evaluation.exports.episodes.reading import POLICIES, RESOLUTION, SHAPE

#: A team that is in contact now and then.
SETTINGS = {"radio.model": "disc", "radio.range": 6.0, "radio.loss": 0.2, "lidar.range": 4.0, "spawn": "clustered"}


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Results of two policies, two seeds and two maps, of which one says how large its cells are."""
    here = tmp_path_factory.mktemp("episodes")
    free = np.full(SHAPE, 254, np.uint8)
    free[[0, -1]] = free[:, [0, -1]] = free[4:14, 8] = free[11, 8:20] = free[6:8, 22:24] = 0
    Image.fromarray(free).save(here / "hall.png")
    (here / "hall.yaml").write_text(
        f"image: hall.png\nresolution: {RESOLUTION}\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    Image.fromarray(free[:, :15]).save(here / "room.png")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exports, "write_figures", lambda *_: [])
        maps = [here / "hall.yaml", here / "room.png"]
        options = {"policies": POLICIES, "maps": maps, "team": 3, "episodes": 2, "workers": 0, "settings": SETTINGS}
        compare(here / "results", **options)
    return here / "results"


@pytest.fixture(scope="session")
def results(folder):
    return Results.load(folder)
