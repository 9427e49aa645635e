"""Reported policies: figures that others measured, kept in ``reported.json`` of a results folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES

#: The file of a results folder that holds reported policies.
FILE = "reported.json"
#: How the keys of metrics begin that are shares of 1.
SHARES = ("auc",)
#: A name or a citation.
Line = Annotated[str, Field(min_length=1, max_length=400, pattern=r"^[^\r\n]*\S[^\r\n]*$")]


class Strict(BaseModel):
    """A frozen model that refuses unknown keys and numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Source(Strict):
    """Where reported rows come from."""

    citation: Line
    url: Annotated[str, Field(pattern=r"^https?://[^\s\"<>]+$", max_length=400)]


def value_fault(metric: str, value: float) -> str:
    """Return what is expected of a metric's value instead; empty where it is possible."""
    if metric.startswith(SHARES):
        return "" if 0 <= value <= 1 else "a share from 0 to 1"
    return "" if value >= 0 else "a number of at least 0"


class _Measured(Strict):
    """What rows and means have in common."""

    scenario: Line
    team: int | None = Field(None, ge=1)
    """Number of UAVs; None where the rows do not say."""
    metrics: Mapping[str, float | None]
    """By key, in the units of this package; None for a time that was never reached."""

    @field_validator("metrics")
    @classmethod
    def _possible(cls, metrics: Mapping[str, float | None]) -> Mapping[str, float | None]:
        for key, value in metrics.items():
            if key not in MEASURES:
                raise ValueError(f"unknown metric {key!r}{did_you_mean(key, MEASURES)}")
            if value is not None and (fault := value_fault(key, value)):
                raise ValueError(f"expected {fault} for {key}, got {value:g}")
        return metrics


class ReportedEpisode(_Measured):
    """One reported episode."""

    map: Line
    """The name of the map, which is the stem of its file."""
    seed: int | None = None
    """None where the rows have no seeds: the start is then the map's own."""
    budget: float | None = Field(None, gt=0)
    """Steps that a time which was never reached counts as."""
    success: bool | None = None
    """Whether the episode reached :attr:`ReportedPolicy.level`; None where the rows do not say."""


class ReportedMean(_Measured):
    """Published means without rows."""

    episodes: int = Field(ge=1)
    """Number of episodes that the means are over."""
    success: float | None = Field(None, ge=0, le=1)
    """Share of episodes that reached :attr:`ReportedPolicy.level`."""


class ReportedPolicy(Strict):
    """A policy that others flew."""

    name: Line
    source: Source
    level: float | None = Field(None, gt=0, le=1)
    """Coverage that counts as success; None where no row says whether it succeeded."""
    files: tuple[str, ...] = ()
    """The files that the rows were imported from, with their SHA-256."""
    episodes: tuple[ReportedEpisode, ...] = ()
    means: tuple[ReportedMean, ...] = ()

    @property
    def scenarios(self) -> list[str]:
        """The scenarios of its rows and means, in their order."""
        return list(dict.fromkeys(each.scenario for each in (*self.episodes, *self.means)))


class _Contents(Strict):
    """What the file holds."""

    format: Literal[1] = 1
    policies: tuple[ReportedPolicy, ...]


def read_reported(folder: Path) -> tuple[ReportedPolicy, ...]:
    """Return the reported policies of a results folder, often none.

    Raises:
        InputError: the file cannot be read, or is damaged.

    """
    path = folder / FILE
    try:
        data = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        return ()
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: cannot be read: {error}; import the rows again") from error
    if not isinstance(data, Mapping):
        raise InputError(f"{path}: expected what import wrote, got a {type(data).__name__}; import the rows again")
    return validated(_Contents, data, str(path)).policies


def write_reported(policies: Iterable[ReportedPolicy], folder: Path) -> Path:
    """Write the reported policies of a results folder; equal policies give equal bytes."""
    path = folder / FILE
    with written_whole(path) as partial:
        text = _Contents(policies=tuple(policies)).model_dump_json(indent=1, exclude_defaults=True)
        partial.write_text(text + "\n", encoding="utf-8", newline="\n")
    return path


def joined(policies: Iterable[ReportedPolicy]) -> tuple[ReportedPolicy, ...]:
    """Return reported policies with those of one name as one.

    Raises:
        InputError: two of one name have other sources, levels or rows of a scenario.

    """
    found: dict[str, ReportedPolicy] = {}
    for each in policies:
        found[each.name] = _merged(found[each.name], each) if each.name in found else each
    return tuple(found.values())


def _merged(one: ReportedPolicy, other: ReportedPolicy) -> ReportedPolicy:
    way_out = "give one of them another name"
    if one.source != other.source:
        raise InputError(
            f"reported policy {one.name!r} has two sources, {one.source.url} and {other.source.url}; {way_out}"
        )
    if None not in (one.level, other.level) and one.level != other.level:
        raise InputError(f"reported policy {one.name!r} succeeds at {one.level:g} and at {other.level:g}; {way_out}")
    for name in (name for name in other.scenarios if name in one.scenarios):
        if _only(one, name) != _only(other, name):
            raise InputError(
                f"reported policy {one.name!r} has other rows of scenario {name!r} already; {way_out}, or import with "
                "--replace"
            )
    more = [name for name in other.scenarios if name not in one.scenarios]
    return one.model_copy(
        update={
            "level": other.level if one.level is None else one.level,
            "files": tuple(dict.fromkeys(one.files + other.files)),
            "episodes": one.episodes + tuple(each for each in other.episodes if each.scenario in more),
            "means": one.means + tuple(each for each in other.means if each.scenario in more),
        }
    )


def _only(policy: ReportedPolicy, scenario: str) -> tuple[_Measured, ...]:
    return tuple(each for each in (*policy.episodes, *policy.means) if each.scenario == scenario)


def refuse_flown_names(reported: Iterable[ReportedPolicy], flown: Iterable[str]) -> None:
    """Refuse a reported policy that has the name of a flown one.

    Raises:
        InputError: there is such a policy.

    """
    names = set(flown)
    for each in reported:
        if each.name in names:
            raise InputError(
                f"policy {each.name!r} is both flown and reported by {each.source.citation}; import the rows again "
                "with another policy name"
            )
