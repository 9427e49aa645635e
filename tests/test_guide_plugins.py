"""The plug-ins of the guide, written to a file as they stand there, in one comparison and one report."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_plugin import BLOCK

GUIDE = Path(__file__).resolve().parent.parent / "evaluation" / "site" / "pages" / "guides" / "plugins.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the file of the guide in it."""
    folder = tmp_path_factory.mktemp("guide")
    ((name, text),) = BLOCK.findall(GUIDE.read_text())
    (folder / name).write_text(text)
    return folder


def typed(folder, start):
    """Type the command line of the guide that begins so, with fewer episodes."""
    (line,) = re.findall(rf"^    indoor-explorers ({start}.*)$", GUIDE.read_text(), re.MULTILINE)
    code = "import sys; from indoor_explorers.evaluation.cli.parser import main; sys.exit(main())"
    words = line.replace("--episodes 10", "--episodes 5 --workers 1").split()
    return subprocess.run(
        [sys.executable, "-P", "-c", code, *words],
        env={**os.environ, "COLUMNS": "120"},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
    )


def test_its_maps_can_be_looked_at(folder):
    done = typed(folder, "maps")
    assert done.returncode == 0, done.stderr
    assert "halls:Pillars: 64 x 64 cells" in done.stdout


def test_all_of_them_are_flown_and_shown(folder):
    done = typed(folder, "compare")
    assert done.returncode == 0, done.stderr
    assert ",TURNS," in (folder / "results" / "halls" / "summary.csv").read_text()
    page = (folder / "results" / "halls" / "report.html").read_text()
    assert "<h2>Free cells of the maps</h2>" in page
    assert re.search(r"<p>5 maps, 9\d% of their cells free.</p>", page)
    assert "changes of direction of all UAVs together; lower is better" in page
