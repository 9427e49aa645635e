"""Another version of a plug-in is another policy: its sources and files are hashed, and old flights are not reused."""

import re
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from indoor_explorers.env import InputError, Pilot, Policy, make_policy
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.harness.experiment.sources import MOST_FILES, changed_files, outside_files
from indoor_explorers.evaluation.harness.results.results import Results

PLUGIN = """
from indoor_explorers.env import Pilot, Policy
from {name}_moves import MOVE

class P(Policy):
    def __init__(self, weights: str = ""):
        self.weights = weights

    def pilot(self, briefing):
        return Mine()

class Mine(Pilot):
    def act(self, view):
        return MOVE
"""


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    """Write a plug-in of two modules to a folder of its own; calling it with a move (re)writes and forgets both."""
    folder, name = tmp_path / "plugin", f"versioned_{tmp_path.name}".replace("-", "_")
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))

    def write(move):
        (folder / f"{name}.py").write_text(PLUGIN.format(name=name))
        (folder / f"{name}_moves.py").write_text(f"MOVE = {move}\n")
        for module in (name, f"{name}_moves"):
            sys.modules.pop(module, None)
        return f"{name}:P"

    sys.dont_write_bytecode, before = True, sys.dont_write_bytecode
    yield write
    sys.dont_write_bytecode = before


def fly(use, out, **options):
    options = {"scenario": "thesis-open", "episodes": 2, "workers": 0, "settings": {"budget": 20}} | options
    compare(out, policies=use, **options)
    return Results.load(out)


def first_actions(results):
    return {int(record.actions[0, 0]) for record in results.records}


@pytest.mark.slow
def test_an_edited_plug_in_is_not_taken_for_the_one_that_flew(plugin, tmp_path):
    assert first_actions(fly(plugin(0), tmp_path / "out")) == {0}
    use = plugin(2)
    with pytest.raises(InputError, match=r"another version of a policy; .*_moves.py; fly them again with --refly"):
        fly(use, tmp_path / "out")
    assert first_actions(fly(use, tmp_path / "out", refly=True)) == {2}
    assert first_actions(fly(use, tmp_path / "out")) == {2}  # nothing is left to fly


def test_other_policies_keep_their_flights(plugin, tmp_path):
    fly((plugin(0), "random"), tmp_path / "out")
    again = fly((plugin(1), "random"), tmp_path / "out", refly=True)
    runs = {record.policy: record for record in again.records}
    assert len(again.runs) == 2
    assert set(runs) == {"random", *(name for name in runs if name != "random")}
    assert len(again.records) == 4


def test_a_fresh_start_forgets_everything(plugin, tmp_path):
    fly((plugin(0), "random"), tmp_path / "out")
    anew = fly("random", tmp_path / "out", seed=7, fresh=True)
    assert list(anew.policies) == ["random"]
    assert {record.task.seed for record in anew.records} == {7, 8}


def test_files_and_folders_that_parameters_name_count(plugin, tmp_path):
    weights = tmp_path / "weights.bin"
    weights.write_bytes(b"one")
    use = plugin(0)
    before = outside_files(make_policy(use, weights=str(weights)), use)
    weights.write_bytes(b"two")
    after = outside_files(make_policy(use, weights=str(weights)), use)
    assert changed_files(before, after) == ["weights: weights.bin"]
    (tmp_path / "net" / "deep").mkdir(parents=True)
    (tmp_path / "net" / "deep" / "a.pt").write_bytes(b"")
    assert "weights: net/deep/a.pt" in outside_files(make_policy(use, weights=str(tmp_path / "net")), use)
    missing = outside_files(make_policy(use, weights="no/such/file.pt"), use)
    assert set(missing) == {Path(f"{module}.py").name for module in (use[:-2], f"{use[:-2]}_moves")}


@dataclass(frozen=True)
class Holder(Policy):
    """Flies as another policy does."""

    inside: Policy

    def pilot(self, briefing):
        return self.inside.pilot(briefing)


def test_a_policy_inside_a_policy_counts(plugin):
    use = plugin(0)
    assert f"{use[:-2]}_moves.py" in outside_files(Holder(make_policy(use)))


def test_the_project_s_own_policies_and_libraries_do_not_count():
    assert outside_files(make_policy("frontier"), "frontier") == {}
    assert outside_files(make_policy("dddqn"), "dddqn") == {}


def test_a_package_counts_with_all_its_modules(tmp_path, monkeypatch):
    package = tmp_path / f"pack_{tmp_path.name}".replace("-", "_")
    (package / "inside").mkdir(parents=True)
    (package / "__init__.py").write_text("from .policy import P\n")
    (package / "policy.py").write_text(PLUGIN.replace("from {name}_moves import MOVE", "MOVE = 0").format())
    (package / "inside" / "late.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    use = f"{package.name}:P"
    names = {name.partition("/")[2] for name in outside_files(make_policy(use), use)}
    assert names == {"__init__.py", "policy.py", "inside/late.py"}


def test_many_files_are_not_all_read(tmp_path, plugin):
    many = tmp_path / "many"
    many.mkdir()
    for number in range(MOST_FILES + 10):
        (many / f"{number}").touch()
    use = plugin(0)
    assert len(outside_files(make_policy(use, weights=str(many)), use)) == MOST_FILES + 2


def test_stores_without_sources_are_taken_as_they_are():
    assert changed_files(None, {"a.py": "1"}) == []
    assert changed_files({"a.py": "1", "b.py": "2"}, {"a.py": "1", "c.py": "2"}) == ["b.py", "c.py"]


class Broken(Policy):
    """Raises."""

    def pilot(self, briefing):
        return _Broken()


class _Broken(Pilot):
    def act(self, view):
        return self._looked_up("nothing")

    def _looked_up(self, name):
        return self._deeper()[name]

    def _deeper(self):
        return np.linalg.inv(np.zeros((2, 2)))


def test_failures_tell_file_and_line_and_who_called(tmp_path, capfd, monkeypatch):
    [record] = fly(f"{__name__}:Broken", tmp_path / "out", episodes=1).records
    place = r"test_sources\.py:\d+"
    assert re.fullmatch(rf"LinAlgError: Singular matrix \({place} in _deeper, from {place} in act\)", record.reason)
    assert "Traceback" not in capfd.readouterr().err
    monkeypatch.setenv("INDOOR_EXPLORERS_DEBUG", "1")
    fly(f"{__name__}:Broken", tmp_path / "again", episodes=1)
    traceback = capfd.readouterr().err
    assert traceback.startswith("Traceback (most recent call last):\n")
    assert "in _looked_up\n" in traceback


def test_a_policy_of_a_notebook_has_no_files(monkeypatch):
    """Its module, ``__main__``, is of no file, and has no attribute for one."""
    cell = ModuleType("cell_of_a_notebook")
    exec("from indoor_explorers.env import Policy\nclass P(Policy):\n    def pilot(self, briefing): ...", vars(cell))
    monkeypatch.setitem(sys.modules, cell.__name__, cell)
    assert not hasattr(cell, "__file__")
    assert outside_files(cell.P(), "cell_of_a_notebook:P") == {}
