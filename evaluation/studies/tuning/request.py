"""The options of ``tune``."""

from __future__ import annotations

from argparse import ArgumentTypeError
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from indoor_explorers.evaluation.harness.experiment.request import (
    DATA_FOLDERS,
    NO_SETTINGS,
    SCENARIO,
    SEED,
    TEAM,
    Option,
    Request,
    Settings,
    read_count,
    read_hours,
    read_natural,
    read_setting,
)

#: What is tuned for: T99, T90 and AUC.
TunedMetric = Literal["t99", "t90", "auc"]
#: The parts of a suite that may be tuned on.
TunedPart = Literal["validation", "train"]
COUNT = Option(metavar="N", read=read_count)


def read_range(text: str) -> tuple[str, Any]:
    """Read ``name=low:high``, ``name=low:high:log`` or ``name=a,b,c`` as a name and what a field would declare.

    Raises ``ArgumentTypeError`` for anything else.
    """
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise ArgumentTypeError(f"expected name=low:high, name=low:high:log or name=a,b,c, got {text!r}")
    if ":" not in value:
        found = read_setting(text)[1]
        return name, found if isinstance(found, list) else [found]
    ends = [read_setting(f"{name}={each}")[1] for each in value.split(":")]
    return name, tuple(ends)


class TuneRequest(Request):
    """The options of ``tune``."""

    policy: Annotated[str, Option(metavar="POLICY", positional=True)]
    """The policy; parameters in parentheses stay as they are: 'frontier(goal_bonus=0.5)'."""
    scenario: Annotated[tuple[str, ...] | None, SCENARIO] = None
    """One or more to tune for, separated by commas: presets or files; with --suite, some of its scenarios."""
    suite: Annotated[str | None, Option(metavar="NAME")] = None
    """Tune on a part of a suite instead, never on its test part."""
    part: Annotated[TunedPart, Option(choices=get_args(TunedPart))] = "validation"
    """Which part of the suite. Where its maps are files, the gain is flown on the other one."""
    data: DATA_FOLDERS = ()
    """Where the suite's map files are: clones of their repositories, or folders that have the clones in them."""
    team: Annotated[int | None, TEAM] = None
    """Number of UAVs."""
    settings: Settings = NO_SETTINGS
    """Scenario settings such as radio.range=3."""
    ranges: Annotated[
        tuple[tuple[str, Any], ...],
        Option(metavar="name=low:high", read=read_range, several=True, flag="--range"),
    ] = ()
    """Tune these parameters within these ranges: name=low:high, name=low:high:log or name=a,b,c; parameters that are
    not named keep the ranges that the policy declares."""
    metric: Annotated[TunedMetric, Option(choices=get_args(TunedMetric))] = "t99"
    """What is tuned for; a time that is never reached counts as the budget."""
    trials: Annotated[int | None, COUNT] = None
    """Number of trials besides the default parameters (default 40)."""
    hours: Annotated[float | None, Option(metavar="H", read=read_hours)] = None
    """Begin trials until they have taken this many hours together, instead of a number of trials."""
    episodes: Annotated[int | None, COUNT] = None
    """Number of tuning seeds flown on each map (default 32, or all of the suite's part)."""
    fresh_episodes: Annotated[int | None, COUNT] = None
    """Number of fresh seeds on each map for the gain (default 100, or all of the other part of a suite of files)."""
    seed: Annotated[int, SEED] = 1
    """Random seed of the search."""
    workers: Annotated[int | None, Option(metavar="N", read=read_natural)] = None
    """Number of worker processes (default: one for each core). 0 flies in this process."""
    out: Annotated[Path, Option(metavar="DIR")]
    """Folder for the trials, the page and tuned.toml; an existing one is resumed."""
