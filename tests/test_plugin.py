"""The planner of its guide, in a folder that the command makes, installed and found through its entry point."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from indoor_explorers.evaluation.cli.parser import main

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"<!-- plugin: (\S+) -->\n```\w+\n(.*?)```", re.DOTALL)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The plug-in, built and installed as the guide says; returns the environment to run in."""
    source, site = tmp_path_factory.mktemp("source") / "wall-follower", tmp_path_factory.mktemp("site")
    assert main(["new", "planner", "wall-follower", "--out", str(source)]) == 0
    ((name, text),) = BLOCK.findall((ROOT / "evaluation/site/pages/guides/planner.md").read_text())
    assert len([line for line in text.splitlines() if line.strip()]) <= 40
    assert (source / name).exists()
    (source / name).write_text(text)
    install = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([sys.executable, *install, "--target", site, source], check=True, capture_output=True, text=True)
    return {**os.environ, "PYTHONPATH": str(site)}


#: Spares a comparison the figures for print, which would take most of its time.
NO_FIGURES = "from indoor_explorers.evaluation import exports; exports.write_figures = lambda *_: []\n"


#: Runs the command lines given as JSON one after the other; prints the status and the output of each as JSON.
COMMANDS = """
import contextlib, io, json, sys
from indoor_explorers.evaluation.cli.parser import main
outcomes = []
for words in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        outcomes.append((main(words), printed.getvalue()))
print(json.dumps(outcomes))
"""


@pytest.fixture(scope="module")
def outcomes(installed, tmp_path_factory):
    """Status and output of the commands ``policies``, ``check`` and ``compare``, and the folder that they ran in."""
    folder = tmp_path_factory.mktemp("folder")
    flown = ["--policies", "wall-follower,random", "--scenario", "thesis-open", "--episodes", "2", "--workers", "1"]
    lines = [["policies"], ["check", "wall-follower"], ["compare", *flown, "--out", "out"]]
    words = [sys.executable, "-c", NO_FIGURES + COMMANDS, json.dumps(lines)]
    done = subprocess.run(words, env=installed, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return *json.loads(done.stdout), folder


def test_it_is_listed_with_its_owner(outcomes):
    (status, printed), *_ = outcomes
    assert status == 0
    (line,) = [line for line in printed.splitlines() if "wall-follower" in line and "Follow" in line]
    assert re.search(r"Follow the wall on the right\.\s+wall-follower", line)


def test_it_passes_the_conformance_suite(outcomes):
    _, (status, printed), *_ = outcomes
    assert status == 0
    assert "no hidden knowledge" in printed


def test_it_is_compared_in_a_worker_process(outcomes):
    *_, (status, printed), folder = outcomes
    assert status == 0
    assert "wall-follower" in printed
    assert "wall-follower,thesis-open" in (folder / "out" / "summary.csv").read_text()
