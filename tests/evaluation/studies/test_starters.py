"""Folders that plug-ins start from: each kind works as it is made, and what cannot be made leaves nothing behind."""

import errno
import importlib
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from indoor_explorers.env import InputError
from indoor_explorers.evaluation import ComparisonRequest, plan
from indoor_explorers.evaluation.cli.commands.new import KINDS
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.studies.starters import folder

ROOT = Path(__file__).resolve().parents[3]
#: The module and the class of each kind, other than those that the guides have.
NAMES = {"planner": "Made.planner", "learner": "made-learner", "map-reader": "made_map--reader2"}


@pytest.fixture(params=KINDS)
def made(request, tmp_path, monkeypatch):
    """A folder of each kind, whose module can be imported; returns its kind, its module and itself."""
    name = NAMES[request.param]
    monkeypatch.chdir(tmp_path)
    assert main(["new", request.param, name]) == 0
    module = re.sub("[-_.]+", "_", name.lower())
    monkeypatch.syspath_prepend(tmp_path / name)
    monkeypatch.chdir(tmp_path / name)
    yield request.param, module, tmp_path / name
    sys.modules.pop(module, None)


def test_it_passes_its_own_tests_with_the_conformance_suite_among_them(made, tmp_path, monkeypatch):
    kind, module, place = made
    monkeypatch.syspath_prepend(place / "tests")
    tests = importlib.import_module(f"test_{module}")
    assert hasattr(tests, "check_policy") == (kind != "map-reader")
    found = [test for name, test in vars(tests).items() if name.startswith("test_")]
    assert found
    for test in found:
        test(**({"tmp_path": tmp_path} if "tmp_path" in test.__annotations__ else {}))


def test_its_files_fit_together(made):
    kind, module, place = made
    project = tomllib.loads((place / "pyproject.toml").read_text())["project"]
    groups = {
        f"indoor_explorers.{each}"
        for each in {"learner": ("policies", "learners"), "map-reader": ("maps",)}.get(kind, ("policies",))
    }
    assert project["entry-points"].keys() == groups
    for declared in project["entry-points"].values():
        ((name, target),) = declared.items()
        assert name == project["name"] == place.name
        top, _, attribute = target.partition(":")
        assert top == module
        wanted = [attribute] if attribute else ["TrainingConfig", "train", "DEFAULT_SCENARIO"]
        assert all(hasattr(importlib.import_module(top), each) for each in wanted)
    flow = yaml.safe_load((place / ".github" / "workflows" / "test.yml").read_text())
    assert flow["jobs"]["test"]["steps"][1]["with"]["repository"] == "${{ vars.INDOOR_EXPLORERS }}"
    texts = {path: path.read_text() for path in place.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    assert len(texts) == (8 if kind == "map-reader" else 7)
    for path, text in texts.items():
        assert text.endswith("\n"), path
        assert not re.search(r"\{\{(?! vars)|\{%|https?:|\n\n\n\n", text), path


def test_its_comparison_can_be_planned(made):
    kind, module, place = made
    experiment = plan(ComparisonRequest(experiment=place / "comparison.toml"))
    assert experiment.episodes == 20
    flown = {"planner": {place.name}, "learner": {"untrained"}, "map-reader": {"frontier"}}[kind]
    assert {policy.name for policy in experiment.policies} == {"frontier-nearest"} | flown
    if kind == "map-reader":
        (task,) = experiment.scenarios
        assert (task.map.source, task.map.count) == (f"{module}:MadeMapReader2", 1)
        assert task.map.without_files().paths == ("(not told)",)


def test_it_is_written_in_the_style_of_this_project(tmp_path):
    for kind in KINDS:
        folder.make_folder(kind, f"an-inventive-{kind}", tmp_path / kind)
    for words in ["check", "--ignore", "D103"], ["format", "--check"]:
        ruff = [sys.executable, "-m", "ruff", *words, "--quiet", "--config", ROOT / "pyproject.toml", tmp_path]
        done = subprocess.run(ruff, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("", "names have letters, digits"),
        ("-planner", "names have letters, digits"),
        ("planner-", "names have letters, digits"),
        ("my planner", "names have letters, digits"),
        ("plänner", "names have letters, digits"),
        ("../planner", "names have letters, digits"),
        ("my-planner\n", "names have letters, digits"),
        ("2-planners", "Python allows no module 2_planners with a class 2Planners"),
        ("class", "Python allows no module class"),
        ("None", "Python allows no module none with a class None"),
        ("indoor-explorers", "its module indoor_explorers would hide another, or be hidden"),
        ("Indoor.Explorers", "its module indoor_explorers would hide another"),
        ("numpy", "its module numpy would hide another"),
        ("json", "its module json would hide another"),
        ("setup", "its module setup would hide another"),
        ("rrt", "an installed policy, learner or source of maps has it"),
        ("RLlib", "an installed policy, learner or source of maps has it"),
        ("sb3-ppo", "an installed policy, learner or source of maps has it"),
        ("office", "an installed policy, learner or source of maps has it"),
        ("policy", "its module uses another class Policy"),
        ("training-config", "its module uses another class TrainingConfig"),
    ],
)
def test_a_bad_name_is_refused_in_one_line(name, why, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "learner", "--", name] if name.startswith("-") else ["new", "learner", name]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("indoor-explorers: expected a new name, such as my-learner, got ")
    assert why in line
    assert line.endswith("; choose another")
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_kind_is_refused_with_the_likely_one(capsys):
    assert main(["new", "lerner", "my-learner"]) == 2
    assert "invalid choice: 'lerner'; did you mean 'learner'?" in capsys.readouterr().err


@pytest.mark.parametrize("out", ["there", "file", "link", "missing/new", "file/new", "n" * 300])
def test_a_place_that_cannot_be_used_is_refused_in_one_line(out, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("there").mkdir()
    Path("file").write_text("kept")
    Path("link").symlink_to("nowhere")
    assert main(["new", "planner", "my-planner", "--out", out]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"indoor-explorers: expected a .*folder.*, got .*; give another --out", line)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "link", "there"]


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), KeyboardInterrupt()])
def test_nothing_half_written_is_left(error, tmp_path, monkeypatch):
    written = []

    def write(path, text, encoding):
        written.append(path)
        if len(written) == 3:
            raise error
        path.write_bytes(text.encode(encoding))

    monkeypatch.setattr(Path, "write_text", write)
    with pytest.raises((InputError, KeyboardInterrupt)):
        folder.make_folder("planner", "my-planner", tmp_path / "new")
    assert len(written) == 3
    assert list(tmp_path.iterdir()) == []


#: What makes a command of a README short.
SHORTER = {
    "compare": "--episodes 1 --workers 1",
    "train": "--scenario thesis-open --set generations=1 population=4 episodes=1",
}


@pytest.mark.slow
def test_it_is_installed_and_the_commands_of_its_readme_run(made, tmp_path):
    kind, _, place = made
    install = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([sys.executable, *install, "--target", tmp_path / "site", place], check=True)
    path = os.pathsep.join(filter(None, (str(tmp_path / "site"), os.environ.get("PYTHONPATH"))))
    lines = re.findall(r"^    (.+)$", (place / "README.md").read_text(), re.MULTILINE)
    assert lines[-1] == "pytest"
    lines[0] = lines[0].removeprefix("pip install -e . && ")
    if kind == "learner":
        listed = (place / "comparison.toml").read_text()
        (place / "comparison.toml").write_text(listed.replace("# { use", "{ use"))
        lines.append("indoor-explorers check made-learner")
    for line in lines:
        program, *words = shlex.split(line)
        module_of = {"pytest": "pytest", "indoor-explorers": "indoor_explorers.evaluation.cli"}[program]
        more = SHORTER.get(words[0], "").split() if words else []
        done = subprocess.run(
            [sys.executable, "-m", module_of, *words, *more],
            cwd=place,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, (line, done.stdout, done.stderr)


@pytest.mark.slow
def test_its_types_are_complete(tmp_path):
    for kind in KINDS:
        folder.make_folder(kind, f"typed-{kind}", tmp_path / kind)
    words = ["--strict", "--config-file=", *sorted(map(str, tmp_path.glob("*/*.py")))]
    done = subprocess.run([sys.executable, "-m", "mypy", *words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
