"""The options of a comparison, filled by the command line, an experiment file or Python."""

from __future__ import annotations

import csv
import io
import sys
import tomllib
from argparse import ArgumentTypeError
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, field_validator

from indoor_explorers.env.files import expanded
from indoor_explorers.evaluation.harness.experiment.limits import DECISION_TIMEOUT


@dataclass(frozen=True, kw_only=True)
class Option:
    """Marks a field as a command-line option; the field's docstring is its help text."""

    metavar: str | None = None
    """The placeholder for the value in the help text."""
    read: Callable[[str], Any] = str
    """Parses an argument; raises ``ArgumentTypeError`` for invalid ones."""
    several: bool = False
    """Whether it takes several values, and may be given several times."""
    choices: tuple[str, ...] | None = None
    """The allowed values; None for any."""
    flag: str | None = None
    """The flag, such as ``--set``; None: the name of the field, with dashes for underscores."""
    positional: bool = False
    """Whether it is a positional argument."""
    alone: str | None = None
    """What the flag means without a value; None where it needs one."""


def read_setting(text: str) -> tuple[str, Any]:
    """Read ``key=value``; the value is parsed as TOML, and is a string where it is not TOML.

    Values separated by commas make a list, as in ``radio.range=1,3,5``.
    """
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise ArgumentTypeError(f"expected key=value such as goal=0.9, got {text!r}")
    try:
        return key, _toml(value)
    except ValueError:  # not TOML, or an integer of thousands of digits
        return key, _listed(value) if "," in value else value


def _toml(text: str) -> Any:
    (value,) = tomllib.loads(f"value = {text}").values()
    return value


def _listed(text: str) -> list[Any]:
    try:
        return list(_toml(f"[{text}]"))
    except ValueError:
        return [word.strip() for word in text.split(",")]


def read_names(text: str) -> list[str]:
    """Read names separated by commas; one in double quotes may hold commas, as in CSV, and so may its parentheses."""
    kept, depth = "", 0
    for character in text:
        depth += (character == "(") - (character == ")")
        kept += "\0" if character == "," and depth > 0 else character
    rows = csv.reader(io.StringIO(kept, newline=""), skipinitialspace=True)
    names = [name.replace("\0", ",").strip() for row in rows for name in row if name.strip()]
    if not names:
        raise ArgumentTypeError("expected names separated by commas, got none")
    return names


def _number(kind: type, least: float, what: str, below: float = float("inf")) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not least <= value < below:
            raise ArgumentTypeError(f"expected {what}, got {text!r}")
        return value

    return read


read_count = _number(int, 1, "a whole number of at least 1")
read_natural = _number(int, 0, "a whole number of at least 0")
read_metres = _number(float, 1e-6, "a number of metres above 0")
read_seconds = _number(float, 0.01, "a number of seconds of at least 0.01")
read_thinking = _number(float, 0, "a number of seconds of at least 0")
read_hours = _number(float, sys.float_info.min, "a number of hours above 0")
read_gigabytes = _number(float, 0.01, "a number of gigabytes of at least 0.01")
read_speed = _number(float, 0.001, "a number of metres a second of at least 0.001")
read_share = _number(float, 0, "a share below 1 such as 0.05, or 0 for none", below=1)
read_rate = _number(float, 0.1, "a number of frames a second of at least 0.1")


#: Where episodes can be flown, the default first.
ENGINES = ("local", "ray")
#: The parts of a suite.
SuitePart = Literal["test", "validation", "train"]
#: Which policies can be isolated.
Isolated = Literal["plug-ins", "all", "none"]


def _several(value: Any) -> Any:
    """Return a single entry as a tuple of one."""
    one = isinstance(value, (str, Path, Mapping)) or not isinstance(value, Sequence)
    return value if value is None else (value,) if one else tuple(value)


def _paths(value: Any) -> Any:
    return tuple(str(expanded(path)) for path in _several(value) or ())


def _folders(value: Any) -> Any:
    return _several(value) or ()


def _settings(value: Any) -> Any:
    """Return pairs of a key and a value as a mapping."""
    return dict(value or {}) if value is None or isinstance(value, (Mapping, list, tuple)) else value


SCENARIO = Option(metavar="PRESET|FILE.toml", read=read_names)
RESOLUTION = Option(metavar="METRES", read=read_metres)
TEAM = Option(metavar="N", read=read_count)
SEED = Option(metavar="S", read=read_natural)
SETTINGS = Option(metavar="key=value", read=read_setting, several=True, flag="--set")
POLICY_NAMES = Option(metavar="a,b,...", read=read_names)
MARGIN_SHARE = Option(metavar="SHARE", read=read_share)
PLUGIN_NAMES = Option(metavar="a,b,...", read=read_names)
RADIO_NAMES = Option(metavar="a,b,...", read=read_names)
#: Folders of a suite's map files.
DATA_FOLDERS = Annotated[
    tuple[Path, ...],
    BeforeValidator(_folders),
    Option(metavar="DIR", read=Path, several=True, flag="--data"),
]
#: Settings by dotted keys, or pairs of key and value.
Settings = Annotated[Mapping[str, Any], BeforeValidator(_settings), SETTINGS]
NO_SETTINGS: Mapping[str, Any] = {}


class Request(BaseModel):
    """A frozen set of options; their docstrings are the help of the command line."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True, arbitrary_types_allowed=True)

    @field_validator("*")
    @classmethod
    def _at_home(cls, value: Any) -> Any:
        """Put the home folder in place of ``~`` at the beginning of a path, or of several."""
        if isinstance(value, tuple):
            return tuple(expanded(each) if isinstance(each, Path) else each for each in value)
        return expanded(value) if isinstance(value, Path) else value


class ComparisonRequest(Request):
    """The options of a comparison. To add an option, add a field here."""

    experiment: Annotated[Path | None, Option(metavar="FILE.toml|NAME")] = None
    """A file with policies, scenarios, episodes, seed and settings, or the name of an experiment that ships, such as
    families. Options given beside it take precedence."""
    policies: Annotated[tuple[Any, ...] | None, BeforeValidator(_several), POLICY_NAMES] = None
    """The policies: names of policies or of entries of the experiment, NAME:PATH such as sb3:DIR, or module:Class,
    with parameters in parentheses: 'pso(length=1),dddqn(guard=false)'. Put a name that has a comma in double quotes;
    protect all of these from the shell: '"dddqn, no guard",pso'."""
    scenario: Annotated[tuple[Any, ...] | None, BeforeValidator(_several), SCENARIO] = None
    """One or more, separated by commas: presets, files, or names of entries of the experiment."""
    maps: Annotated[tuple[str, ...], BeforeValidator(_paths), Option(metavar="PATH", several=True)] = ()
    """Explore these map files instead; with --suite, these of its maps."""
    resolution: Annotated[float | None, RESOLUTION] = None
    """Metres per cell to resample map files to. Pictures have no scale: a pixel of theirs counts as 1 m."""
    suite: Annotated[str | None, Option(metavar="NAME")] = None
    """Fly the tasks of a suite, which indoor-explorers suites lists. Choose some of them with --team, --radio, --maps,
    which then names maps or buildings ('GHC*'), and fewer --episodes; results say that they are a subset."""
    part: Annotated[SuitePart, Option(choices=get_args(SuitePart))] = "test"
    """Which part of the suite."""
    data: DATA_FOLDERS = ()
    """Where the suite's map files are: clones of their repositories, or folders that have the clones in them."""
    radio: Annotated[tuple[str, ...] | None, BeforeValidator(_several), RADIO_NAMES] = None
    """Fly teams only with these radios of the suite: none, disc, unlimited."""
    team: Annotated[int | None, TEAM] = None
    """Number of UAVs."""
    episodes: Annotated[int | None, Option(metavar="N", read=read_count)] = None
    """Number of seeds flown on each map (default 30)."""
    seed: Annotated[int | None, SEED] = None
    """First seed (default 0)."""
    settings: Settings = NO_SETTINGS
    """Scenario settings such as goal=0.9 or radio.range=3; several values, as in radio.range=1,3,5, make a scenario for
    each, and for each combination with those of other settings."""
    workers: Annotated[int | None, Option(metavar="N", read=read_natural)] = None
    """Number of worker processes (default: one for each core). 0 flies in this process, where policies that hang or
    die are not caught."""
    decision_timeout: Annotated[float | None, Option(metavar="SECONDS", read=read_seconds)] = DECISION_TIMEOUT
    """Fail an episode when a decision takes longer; compiling does not count."""
    memory_limit: Annotated[float | None, Option(metavar="GB", read=read_gigabytes)] = None
    """Fail an episode when its processes use more memory (default: four fifths of the machine's memory / workers)."""
    isolate: Annotated[Isolated, Option(choices=get_args(Isolated))] = "plug-ins"
    """Which policies decide in a process of their own, which is shown what their UAVs know and never has the true map:
    by default those from outside this package. Results say which did."""
    retry_failed: Annotated[bool, Option()] = False
    """Fly failed episodes again; without this they count as finished. Where the process was killed or ran out of
    memory, the new attempt replaces the failed one; any other failure is the policy's, and still counts."""
    refly: Annotated[bool, Option()] = False
    """Fly all episodes of a policy again whose sources, files or parameters are not those of the stored ones; without
    this such a policy is refused."""
    fresh: Annotated[bool, Option()] = False
    """Delete what the folder's results.db holds, and start again."""
    engine: Annotated[str, Option(choices=ENGINES)] = ENGINES[0]
    """Where episodes are flown: in worker processes of this machine, or on a Ray cluster."""
    address: Annotated[str | None, Option(metavar="HOST:PORT")] = None
    """Address of the Ray cluster's head (default: found by Ray)."""
    ratio_to: Annotated[tuple[str, ...] | None, BeforeValidator(_several), POLICY_NAMES] = None
    """Print steps divided by those of these policies on the same tasks, and minus them. Tables and page always have
    ratios; by default to frontier-nearest, or else the first policy, and to policies that know the map."""
    margin: Annotated[float | None, MARGIN_SHARE] = None
    """Call two policies as good where tests show that neither mean time is this share above the other (default 0.05);
    0 for no such statement."""
    metrics: Annotated[tuple[str, ...], BeforeValidator(_several), PLUGIN_NAMES] = ()
    """Metrics of plug-ins to add to tables and page: installed names, or module:NAME."""
    panels: Annotated[tuple[str, ...], BeforeValidator(_several), PLUGIN_NAMES] = ()
    """Panels of plug-ins to add to the page: installed names, or module:function."""

    @classmethod
    def of(cls, **options: Any) -> ComparisonRequest:
        """Return the request with these options.

        Raises:
            InputError: an option is unknown, or its value is invalid.
        """
        # imported here, so that the command line shows its help at once
        from indoor_explorers.env.scenarios.validation import validated

        return validated(cls, options, "comparison")
