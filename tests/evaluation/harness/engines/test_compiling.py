"""Workers compile different parts of the world's code at the same time."""

import subprocess
import sys

from filelock import FileLock

from indoor_explorers.evaluation.harness.engines import compiling

FLOWN_AFTER = """
from indoor_explorers.env import make_policy, scenario
from indoor_explorers.env.simulation.reset import start_episodes
from indoor_explorers.env.simulation.step import advance
from indoor_explorers.evaluation.harness.engines import compiling
from indoor_explorers.evaluation.harness.episodes import flow_bound, lower_bounds, mst_bound
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task

compiled = {
    name: function
    for module in (flow_bound, lower_bounds, mst_bound)
    for name, function in vars(module).items()
    if hasattr(function, "signatures")
} | {"advance": advance, "start_episodes": start_episodes}
compiling.not_compiled = lambda: {"advance-0"}
compiling.compile_world()
before = {name: len(function.signatures) for name, function in compiled.items()}
task, scene = Task("thesis-team-4", 0, 0), scenario("thesis-team-4").with_settings({"budget": 20}).for_evaluation()
[record] = fly(make_policy("frontier-nearest"), "frontier-nearest", scene, [task])
assert before["advance"] == before["start_episodes"] == 1
print({name for name, function in compiled.items() if len(function.signatures) != before[name]})
"""


def test_a_flight_finds_what_was_compiled():
    ran = subprocess.run([sys.executable, "-P", "-c", FLOWN_AFTER], capture_output=True, text=True, check=True)
    assert ran.stdout == "set()\n"


def test_what_another_process_compiles_is_left_to_it(tmp_path, monkeypatch):
    done = []
    for name in ("_start", "_bound", "_step"):
        monkeypatch.setattr(
            compiling, name, type("Part", (), {"__name__": name, "__call__": lambda p: done.append(p)})()
        )
    monkeypatch.setattr(compiling, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(compiling, "not_compiled", lambda: {"advance-0", "another-1"})
    with FileLock(tmp_path / "_bound.lock"):
        compiling.compile_world()
    assert [part.__name__ for part in done] == ["_start", "_step"]


def test_without_a_folder_for_code_nothing_is_compiled_ahead(monkeypatch):
    monkeypatch.setattr(compiling, "cache_folder", lambda: None)
    monkeypatch.setattr(compiling, "_start", lambda: 1 / 0)
    compiling.compile_world()


def test_where_steps_are_compiled_nothing_is(tmp_path, monkeypatch):
    monkeypatch.setattr(compiling, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(compiling, "not_compiled", lambda: {"another-1"})
    monkeypatch.setattr(compiling, "_start", lambda: 1 / 0)
    compiling.compile_world()
