"""What asv is told exists, and its benchmarks are those of ``bench``."""

import importlib.util
import inspect
import json
import sys

import pytest

from indoor_explorers.evaluation.studies import bench
from indoor_explorers.evaluation.studies.bench.speed_history import figures
from tests.documents import ROOT

CONF = json.loads((ROOT / "asv.conf.json").read_text())
GROUPS = [
    kind for name, kind in inspect.getmembers(figures, inspect.isclass) if hasattr(kind, "params") and name[0] != "_"
]


def only_benchmark(kind):
    ((name, method),) = inspect.getmembers(kind, lambda each: getattr(each, "__name__", "").startswith("track_"))
    return name, method


def test_the_configuration_names_files_that_exist_and_writes_below_what_git_ignores():
    assert (ROOT / CONF["benchmark_dir"] / "__init__.py").is_file()
    assert (ROOT / CONF["benchmark_dir"]) / "figures.py" == ROOT / "evaluation/studies/bench/speed_history/figures.py"
    assert (ROOT / "constraints.txt").is_file()
    assert "/results/" in (ROOT / ".gitignore").read_text().split()
    assert all(CONF[name].startswith("results/") for name in ("env_dir", "results_dir", "html_dir"))
    known = ("build_dir", "build_cache_dir", "env_dir", "wheel_file")
    for command in (*CONF["build_command"], *CONF["install_command"]):
        command.format(**dict.fromkeys(known, "x"))


def test_every_figure_is_one_of_bench_in_the_same_unit_or_its_inverse():
    units = {each.name: each.unit for each in bench.measures()}
    assert len(GROUPS) == 5
    for kind in GROUPS:
        assert kind.params
        assert only_benchmark(kind)
        for name in kind.params:
            assert units[name] == ("agent-steps/s" if kind is figures.AgentStep else kind.unit)


def test_a_benchmark_returns_what_bench_measures_when_it_is_loaded_as_asv_loads_it(monkeypatch):
    folder = ROOT / CONF["benchmark_dir"]
    spec = importlib.util.spec_from_file_location("speed_history.figures", folder / "figures.py")
    loaded = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, loaded)
    spec.loader.exec_module(loaded)
    (take,) = (each.take for each in bench.measures() if each.name == "memory-16x16-lidar3-team4")
    memory = loaded.Memory()
    memory.setup("memory-16x16-lidar3-team4")
    assert only_benchmark(loaded.Memory)[1](memory, "memory-16x16-lidar3-team4") == take() > 0


def test_speeds_become_times_and_figures_that_a_commit_lacks_are_left_out():
    step = figures.AgentStep()
    step.take = lambda: 2e6
    assert step.track_time("") == 0.5
    with pytest.raises(NotImplementedError):
        step.setup("world-of-tomorrow")
