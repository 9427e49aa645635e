"""``export``: write a recorded episode for other programs: MCAP, a ROS 2 bag, or CSV."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import (
    PLUGIN_NAMES,
    SEED,
    Option,
    Request,
    read_seconds,
    read_speed,
)


class ExportOptions(Request):
    """The options of ``export``."""

    folder: Annotated[Path, Option(metavar="DIR", positional=True)]
    """A folder written by compare."""
    policy: Annotated[str, Option(metavar="NAME")]
    """The policy, by its name in the results."""
    scenario: Annotated[str | None, Option(metavar="NAME")] = None
    """The scenario, where the results have several."""
    seed: Annotated[int | None, SEED] = None
    """Seed of the episode, where there are several."""
    map: Annotated[str | None, Option(metavar="NAME")] = None
    """Name of the map, where there are several."""
    format: Annotated[Literal["mcap", "rosbag2", "csv"], Option(choices=("mcap", "rosbag2", "csv"))] = "mcap"
    """mcap: one file for Foxglove and ROS 2; rosbag2: a folder for ros2 bag play; csv: steps.csv and meta.json."""
    step_seconds: Annotated[float | None, Option(metavar="SECONDS", read=read_seconds)] = None
    """Duration of a step in the file (default 1 s)."""
    speed: Annotated[float | None, Option(metavar="METRES/SECOND", read=read_speed)] = None
    """Speed of the UAVs instead: a step lasts as long as they need for one cell."""
    explanations: Annotated[bool, Option()] = False
    """Also write why each UAV flies where it does, as markers: its policy flies the episode again."""
    plugins: Annotated[tuple[str, ...], PLUGIN_NAMES] = ()
    """Lidar and radio models from outside this package that the results name and that may be imported, and policies to
    explain."""
    out: Annotated[Path, Option(metavar="PATH")]
    """FILE.mcap, or the folder of the other formats; what an export wrote there before is replaced."""


def run_export(options: ExportOptions, typed: str) -> int:
    """Write the episode."""
    from indoor_explorers.evaluation.exports.episodes.export import export_episode

    given = options.model_dump()
    target = export_episode(given.pop("folder"), given.pop("out"), **given)
    print_line(make_console(), f"Episode: {target}")
    return 0


EXPORT = Command(ExportOptions, run_export, "nothing was written")
