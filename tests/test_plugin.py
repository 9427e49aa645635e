"""The planner of its guide, installed as a package of its own and found through its entry point."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"<!-- plugin: (\S+) -->\n```\w+\n(.*?)```", re.DOTALL)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The plug-in, built and installed from the text of the guide; returns the environment to run in."""
    source, site = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("site")
    files = dict(BLOCK.findall((ROOT / "evaluation/site/pages/guides/planner.md").read_text()))
    assert set(files) == {"wall_follower.py", "pyproject.toml"}
    code = [line for line in files["wall_follower.py"].splitlines() if line.strip()]
    assert len(code) <= 40
    for name, text in files.items():
        (source / name).write_text(text)
    install = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([sys.executable, *install, "--target", site, source], check=True, capture_output=True, text=True)
    return {**os.environ, "PYTHONPATH": str(site)}


#: Spares a comparison the figures for print, which would take most of its time.
NO_FIGURES = "from indoor_explorers.evaluation import exports; exports.write_figures = lambda results, folder: []\n"


def command(env, *words, cwd, first=""):
    code = f"{first}import sys; from indoor_explorers.evaluation.cli.parser import main; sys.exit(main())"
    return subprocess.run(
        [sys.executable, "-c", code, *words], env=env, cwd=cwd, capture_output=True, text=True, timeout=300
    )


def test_it_is_listed_with_its_owner(installed, tmp_path):
    done = command(installed, "policies", cwd=tmp_path)
    (line,) = [line for line in done.stdout.splitlines() if "wall-follower" in line and "Follow" in line]
    assert re.search(r"Follow the wall on the right\.\s+wall-follower", line)


def test_it_passes_the_conformance_suite(installed, tmp_path):
    done = command(installed, "check", "wall-follower", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "no hidden knowledge" in done.stdout


def test_it_is_compared_in_a_worker_process(installed, tmp_path):
    words = ["compare", "--policies", "wall-follower,random", "--scenario", "thesis-open", "--episodes", "2"]
    done = command(installed, *words, "--workers", "1", "--out", "out", cwd=tmp_path, first=NO_FIGURES)
    assert done.returncode == 0, done.stderr
    assert "wall-follower" in done.stdout
    assert "wall-follower,thesis-open" in (tmp_path / "out" / "summary.csv").read_text()
