"""The plug-ins of the guide, written to a file as they stand there, in one comparison and one report."""

import re
import sys
from pathlib import Path

import pytest

from indoor_explorers.evaluation import driver, exports
from indoor_explorers.evaluation.cli.parser import main
from tests.test_plugin import BLOCK

GUIDE = Path(__file__).resolve().parent.parent / "evaluation" / "site" / "pages" / "guides" / "plugins.md"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with the file of the guide in it; its module is forgotten afterwards."""
    ((name, text),) = BLOCK.findall(GUIDE.read_text())
    (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(exports, "write_figures", lambda *_: [])  # test_commands.py draws them
    monkeypatch.setattr(driver, "found_in_flights", lambda *_: {})  # test_plugin_checks.py has them
    monkeypatch.setattr(driver, "with_failed_checks", lambda experiment, about, stored, loader: dict(about))
    yield tmp_path
    sys.modules.pop(Path(name).stem, None)


def typed(start):
    """Type the command line of the guide that begins so, with fewer episodes."""
    (line,) = re.findall(rf"^    indoor-explorers ({start}.*)$", GUIDE.read_text(), re.MULTILINE)
    return main(line.replace("--episodes 10", "--episodes 5 --workers 0").split())


def test_its_maps_can_be_looked_at(folder, capsys):
    status = typed("maps")
    printed, errors = capsys.readouterr()
    assert status == 0, errors
    assert "halls:Pillars: 64 x 64 cells" in printed


@pytest.mark.slow
def test_all_of_them_are_flown_and_shown(folder, capsys):
    assert typed("compare") == 0, capsys.readouterr().err
    assert ",TURNS," in (folder / "results" / "halls" / "summary.csv").read_text()
    page = (folder / "results" / "halls" / "report.html").read_text()
    assert "<h2>Free cells of the maps</h2>" in page
    assert re.search(r"<p>5 maps, 9\d% of their cells free.</p>", page)
    assert "changes of direction of all UAVs together; lower is better" in page
