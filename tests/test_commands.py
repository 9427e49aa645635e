"""The command lines of the documents run as they stand there, on fewer episodes and for fewer steps."""

import json
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.evaluation.cli.parser import main
from tests.documents import BOUNDS, PAGES, PLANNERS, ROOT
from tests.test_guide_reported import write_example
from tests.test_plugin import BLOCK

DOCUMENTS = (*PAGES, PLANNERS, BOUNDS, *sorted((ROOT / "learners").rglob("*.md")))
#: Words of commands that stand for something of the reader's, or that take days or have tests of their own.
PLACEHOLDERS = re.compile(
    r"\b(LEARNER|DIR|FILE|MODULE|my_planner)\b|^(bench|ablate|scale|check|robot)\b|results/thesis\b|--engine ray|\*"
    r"|sb3:sb3-|places:"
)
#: Commands that need map files or code of others.
DATA = re.compile(r"--data|data=|DungeonMaps|g4s_y2|\.building\.yaml|hotel\.bt|--clone|ir2-hybrid|ir2\.toml")
#: What makes a command short.
SHORTER = {
    "compare": ["--episodes", "1", "--workers", "1"],
    "watch": ["--steps", "12"],
    "thesis": ["--episodes", "3", "--only", "rewards-1-stuck-0", "--set", "evaluation_episodes=2"],
    "train": ["--set", "total_steps=600"],
    "tune": ["--trials", "1", "--episodes", "1", "--fresh-episodes", "1", "--workers", "1"],
}


def commands(path: Path) -> list[list[str]]:
    """The commands of a document that can be typed anywhere."""
    lines = re.findall(r"^ {4,8}indoor-explorers ((?:[^\n]*\\\n)*[^\n]*)$", path.read_text("utf-8"), re.MULTILINE)
    joined = [re.sub(r"\\\n\s*", "", line).partition("   #")[0] for line in lines]
    return [shlex.split(line) for line in joined if not PLACEHOLDERS.search(line) and not DATA.search(line)]


def shortened(words: list[str]) -> list[str]:
    more = SHORTER.get(words[0], [])
    if words[0] == "train" and "dddqn-thesis" in words:
        more = ["--set", "episodes=3", "evaluation_episodes=2"]
    if words[0] == "train" and {"dddqn-places", "dddqn-reports", "pockets"} & {*words}:
        more = ["--set", "flights=3", "epochs=1" if "pockets" in words else "rounds=1"]
    if words[0] == "watch" and not {"--save", "--rerun"} & {*words}:
        more = [*more, "--save", "last.png"]
    return [*words, *more]


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A folder with what the commands name: two floors, a plug-in and four results."""
    folder = tmp_path_factory.mktemp("typed")
    free = np.full((40, 60), 254, np.uint8)
    free[[0, -1]] = free[:, [0, -1]] = free[20, 5:40] = 0
    Image.fromarray(free).save(folder / "floor.png")
    np.save(folder / "hall.npy", np.zeros((3, 6, 8), np.uint8))
    (folder / "floor.yaml").write_text(
        "image: floor.png\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    house = {"id": "house", "verts": [[0, 0], [8, 0], [8, 6], [0, 6]], "bbox": {"min": [0, 0], "max": [8, 6]}}
    (folder / "house.json").write_text(json.dumps(house))
    ((name, text),) = BLOCK.findall((ROOT / "evaluation/site/pages/guides/plugins.md").read_text())
    (folder / name).write_text(text)
    write_example(folder)
    for place, policies in {"a": "random", "b": "frontier-nearest", "new": "pso", "old": "pso"}.items():
        words = f"compare --policies {policies} --scenario thesis-open --episodes 5 --workers 1 --out"
        assert main([*words.split(), str(folder / "results" / place)]) == 0
    return folder


TYPED = [path for path in DOCUMENTS if commands(path)]


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("path", TYPED, ids=lambda path: path.stem)
def test_every_command_runs(path, prepared, tmp_path, capsys, monkeypatch):
    """The commands of a document, in its order and in a folder of its own."""
    shutil.copytree(prepared, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    for words in commands(path):
        for taken in (k + 1 for k, word in enumerate(words) if word == "--out" and words[0] == "compare"):
            shutil.rmtree(words[taken], ignore_errors=True)  # two examples may name one folder
        status = main(shortened(words))
        assert status == 0, (shlex.join(words), capsys.readouterr().err)


def test_most_commands_of_the_pages_are_typed():
    assert len(TYPED) >= 8
    assert sum(len(commands(path)) for path in TYPED) >= 30
