"""Pages too large for one file: their scenarios are in files beside them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from urllib.parse import unquote

import pytest

from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report import page as pages
from indoor_explorers.evaluation.report import write_report
from indoor_explorers.evaluation.report.page import render


@pytest.fixture
def split(results: Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(pages, "WHOLE", 0)
    write_report(results, tmp_path / "a #1.html")
    return tmp_path / "a #1.html"


def test_each_scenario_is_in_a_file_beside_a_large_page(results: Results, split: Path) -> None:
    text, whole = split.read_text("utf-8"), render(results)
    assert 'id="replay-data-' not in text
    assert "script-src 'unsafe-inline' 'self' file:;" in text
    names = [unquote(name) for name in re.findall(r'data-part="(.*?)"', text)]
    assert sorted(split.parent / name for name in names) == sorted(split.parent.glob("a #1_files/*"))
    for number, name in enumerate(names, 1):
        told = (split.parent / name).read_text("utf-8").removeprefix("Parts.receive(").removesuffix(");\n")
        section, body = json.loads(f"[{told}]")
        assert section == f"s{number}"
        assert body in whole


@pytest.mark.slow
def test_files_of_an_earlier_page_do_not_stay(results: Results, split: Path) -> None:
    write_report(results, split, replays=0)
    assert len(list(split.parent.glob("a #1_files/*"))) == len(results.scenarios)
    kept = split.parent / "a #1_files" / "notes.txt"
    kept.touch()
    write_report(results, split, whole=True)
    assert list(split.parent.glob("a #1_files/*")) == [kept]
    assert split.read_text("utf-8") == render(results)
