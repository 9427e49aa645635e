"""Benchmarks of the start of a process, with an empty and with a filled compile cache."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

from indoor_explorers.evaluation.studies.bench.figure import median_of, seconds_of

FIRST_STEP = (
    "from indoor_explorers.env import World, scenario; import numpy as np;"
    "w = World(scenario('thesis-team-4')); w.reset([0]); w.step(np.zeros((1, 4), int))"
)
FIRST_EPISODE = (
    "from indoor_explorers.env import make_policy, scenario;"
    "from indoor_explorers.evaluation.harness.episodes.runner import fly;"
    "from indoor_explorers.evaluation.harness.experiment.experiment import Task;"
    "task = scenario('thesis-obstacles').for_evaluation();"
    "list(fly(make_policy('frontier-nearest'), 'frontier-nearest', task, [Task(task.name, 0, 0)]))"
)
#: Environment variable with the folder of the compile cache.
CACHE = "NUMBA_CACHE_DIR"


def first_compile() -> float:
    """Return the seconds from an empty compile cache to the first flown episode, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        return _seconds(FIRST_EPISODE, {CACHE: folder})


def first_step() -> float:
    """Return the seconds from the start of a process to the first step of a world when everything is compiled."""
    return median_of(lambda: _seconds(FIRST_STEP, {}))


def _seconds(program: str, variables: dict[str, str]) -> float:
    """Return the seconds that a new process takes for a program, including its start."""
    command, variables = [sys.executable, "-P", "-c", program], os.environ | variables
    return seconds_of(lambda: subprocess.run(command, check=True, env=variables, capture_output=True))
