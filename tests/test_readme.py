"""What the README shows works as it stands there."""

import ast
import importlib
import re
import subprocess
import sys
from itertools import count
from pathlib import Path

import pytest

from indoor_explorers.env import PRESETS, policy_names
from indoor_explorers.evaluation.cli.parser import build_parser

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()
#: Those that need Ray are run in tests/env/interfaces/test_rllib.py, where Ray is started once and with little.
SNIPPETS = [text for text in re.findall(r"```python\n(.*?)```", README, re.DOTALL) if "from ray" not in text]


@pytest.fixture
def one_thread():
    """Train on one thread: small matrices are slower on many, above all beside other processes."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.mark.filterwarnings("default")
@pytest.mark.usefixtures("one_thread")
@pytest.mark.parametrize("snippet", [text for text in SNIPPETS if "compare(" not in text], ids=count())
def test_a_snippet_runs(snippet, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(snippet, "README.md", "exec"), {"__name__": "__main__"})


@pytest.mark.parametrize("snippet", [text for text in SNIPPETS if "compare(" in text], ids=count())
def test_a_comparison_runs_as_a_script_without_a_main_guard(snippet, tmp_path):
    (tmp_path / "snippet.py").write_text(snippet)
    done = subprocess.run([sys.executable, "snippet.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def test_every_policy_and_scenario_is_in_its_table():
    families = {
        r"rewards-[123]-stuck-[012]": "rewards-R-stuck-S",
        r"team-[24]-radio-([013]|unlimited)": "team-N-radio-X",
    }
    for name in (*policy_names(), *(name for name in PRESETS if name != "thesis-team-4")):
        for numbers, letters in families.items():
            name = re.sub(numbers, letters, name)
        assert f"`{name}`" in README


def test_every_command_line_is_understood():
    lines = re.findall(r"^    indoor-explorers (.*)$", README, re.MULTILINE)
    assert len(lines) >= 3
    for line in lines:
        build_parser().parse_args(line.replace("'", "").split())


def test_documents_import_public_names_alone():
    public = re.findall(
        r"`(indoor_explorers\.[\w.]+)`", README.partition("## Public names")[2].partition("- The entry")[0]
    )
    for document in ("README.md", "CONTRIBUTING.md", "evaluation/CLUSTER.md"):
        for block in re.findall(r"```python\n(.*?)```", (ROOT / document).read_text(), re.DOTALL):
            for node in ast.walk(ast.parse(block)):
                if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("indoor_explorers"):
                    assert node.module in public, (document, node.module)
                    names = importlib.import_module(node.module).__all__
                    assert {alias.name for alias in node.names} <= set(names), (document, node.module)


def test_links_lead_somewhere():
    for target, anchor in re.findall(r"\]\((?!http)([^)#]+)#?([^)]*)\)", README):
        assert (ROOT / target).exists(), target
        headings = re.findall(r"^#+ (.+)$", (ROOT / target).read_text(), re.MULTILINE) if anchor else [""]
        assert anchor in [heading.lower().replace(" ", "-") for heading in headings], (target, anchor)


@pytest.mark.slow  # guarded by the imports above
def test_the_scripts_behind_the_costs_of_a_cluster_run(tmp_path):
    costs, driver = re.findall(r"```python\n(.*?)```", (ROOT / "evaluation" / "CLUSTER.md").read_text(), re.DOTALL)
    costs = changed(costs, '("thesis-obstacles", 40), ("office", 10)', '("thesis-open", 2),')
    driver = changed(driver, '("thesis-obstacles", 2000), ("office", 60)', '("thesis-open", 2),')
    scripts = {"costs": changed(costs, "in POLICIES", "in POLICIES[:2]"), "driver": changed(driver, '"ray"', '"local"')}
    for (name, script), lines in zip(scripts.items(), (2, 1), strict=True):
        (tmp_path / f"{name}.py").write_text(script)
        done = subprocess.run([sys.executable, f"{name}.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert (done.returncode, len(done.stdout.splitlines())) == (0, lines), done.stderr


def changed(script, old, new):
    assert old in script
    return script.replace(old, new)
