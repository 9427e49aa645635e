"""What make does before it begins."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from indoor_explorers.evaluation.site.studies.report_tour import BROWSERS

ROOT = Path(__file__).resolve().parents[1]


def make(folder, *words):
    return subprocess.run(["make", "-C", folder, *words], capture_output=True, text=True, timeout=60)


@pytest.mark.skipif(not Path(sys.prefix, "bin", "indoor-explorers").exists(), reason="not in a virtual environment")
def test_the_environment_of_another_clone_is_refused(tmp_path):
    assert make(ROOT, "own-venv", f"VENV={sys.prefix}").returncode == 0
    shutil.copy(ROOT / "Makefile", tmp_path)
    refused = make(tmp_path, "own-venv", f"VENV={sys.prefix}")
    assert refused.returncode == 2
    assert f"{sys.prefix} belongs to the clone in {ROOT}, expected one of this folder" in refused.stdout


def test_the_site_flies_few_episodes_unless_asked(tmp_path):
    for words, count in (([], 2), (["EPISODES=30"], 30)):
        printed = make(ROOT, "-n", "docs", f"VENV={sys.prefix}", *words).stdout
        assert f'INDOOR_EXPLORERS_SITE_EPISODES="{count}"' in printed


def test_it_looks_for_the_browsers_that_the_tests_look_for():
    assert f"\nBROWSERS = {' '.join(BROWSERS)}\n" in (ROOT / "Makefile").read_text()
