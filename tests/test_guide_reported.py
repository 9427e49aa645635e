"""The example of the guide to reported rows works as it stands there."""

import re
from pathlib import Path

import pytest

from indoor_explorers.evaluation import exports
from indoor_explorers.evaluation.cli.parser import main

GUIDE = (Path(__file__).resolve().parent.parent / "evaluation/site/pages/guides/reported.md").read_text("utf-8")
COMMANDS = re.findall(r"^    indoor-explorers (.*)$", GUIDE, re.MULTILINE)


def write_example(folder):
    """Write the files of the guide: ``peers.csv`` and ``peers.toml``."""
    for kind in ("csv", "toml"):
        (text,) = re.findall(rf"```{kind}\n(.*?)```", GUIDE, re.DOTALL)
        (folder / f"peers.{kind}").write_text(text)


@pytest.mark.filterwarnings("default")
def test_the_example_is_imported_and_shown(tmp_path, monkeypatch, capsys):
    write_example(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(exports, "write_figures", lambda *_: [])  # test_reported.py draws them
    for words in COMMANDS:
        assert main(words.replace("--episodes 5", "--episodes 3 --workers 0").split()) == 0, capsys.readouterr().err
    printed = " ".join(capsys.readouterr().out.split())
    assert "their-planner ¶, shared tasks" in printed
    assert "3 tasks shared with flown policies" in printed
    assert "their-planner ¶" in (tmp_path / "results" / "peers.html").read_text("utf-8")
    assert main(["report", "results/peers", "--out", "alone.html"]) == 0
    assert "Nothing was flown on this scenario." in capsys.readouterr().out
    assert not Path("alone.html").exists()
    assert main(["report", "results/open", "--against", "results/peers", "--out", "against.html"]) == 0
    assert "their-planner ¶, all" in capsys.readouterr().out
