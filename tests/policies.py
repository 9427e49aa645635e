"""The policies that this project registers, now or later."""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
#: By name; those of other installed packages are none of ours.
REGISTERED = tuple(PROJECT["entry-points"]["indoor_explorers.policies"])
