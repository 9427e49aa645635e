"""The policies that this project registers, now or later."""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
#: By name; those of other installed packages are none of ours.
REGISTERED = tuple(PROJECT["entry-points"]["indoor_explorers.policies"])
#: Those that need not get anywhere: chance, and the thesis's learner as it was.
AIMLESS = ("random", "dddqn-thesis")
#: Those that see all of every map they are given.
PLANNERS = tuple(name for name in REGISTERED if name not in AIMLESS)
