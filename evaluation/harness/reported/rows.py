"""Reported policies: figures that others measured, kept in ``reported.json`` of a results folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.files import write_whole
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES

#: The file of a results folder that holds reported policies.
FILE = "reported.json"
#: A name or a citation.
Line = Annotated[str, Field(min_length=1, max_length=400, pattern=r"^[^\r\n]*\S[^\r\n]*$")]
Share = Annotated[float, Field(ge=0, le=1)]
Amount = Annotated[float, Field(ge=0)]


class Strict(BaseModel):
    """A frozen model that refuses unknown keys and numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Source(Strict):
    """Where reported rows come from."""

    citation: Line
    url: Annotated[str, Field(pattern=r"^https?://[^\s\"<>]+$", max_length=400)]
    measured: bool = False
    """Whether the rows were measured here, in the simulator of others that is cited."""


def known_metrics(metrics: Mapping[str, object]) -> None:
    """Refuse keys that are no metrics.

    Raises:
        ValueError: there is such a key.

    """
    for key in metrics:
        if key not in MEASURES:
            raise ValueError(f"unknown metric {key!r}{did_you_mean(key, MEASURES)}")


class ReportedRow(Strict):
    """One reported episode, or published means of some."""

    scenario: Line
    map: Line | None = None
    """The name of the map, which is the stem of its file; None for means."""
    seed: int | None = None
    """None where the rows have no seeds: the start is then the map's own."""
    team: int | None = Field(None, ge=1)
    """Number of UAVs; None where the rows do not say."""
    budget: int | None = Field(None, ge=1)
    """Steps that a time which was never reached counts as."""
    n: int | None = Field(None, ge=1)
    """Number of episodes that the row is the mean of; None for an episode."""
    metrics: Mapping[str, Amount | None]
    """By key, in the units of this package; None for a time that was never reached."""
    success: Share | None = None
    """Share of successes, 0 or 1 for an episode; None where the rows do not say."""

    @field_validator("metrics")
    @classmethod
    def _known(cls, metrics: Mapping[str, float | None]) -> Mapping[str, float | None]:
        known_metrics(metrics)
        return metrics


class ReportedPolicy(Strict):
    """A policy that others flew."""

    name: Line
    source: Source
    level: float | None = Field(None, gt=0, le=1)
    """Coverage that counts as success; None where no row says whether it succeeded."""
    files: tuple[str, ...] = ()
    """The files that the rows were imported from, with their SHA-256."""
    rows: tuple[ReportedRow, ...]

    @property
    def scenarios(self) -> list[str]:
        """The scenarios of its rows, in their order."""
        return list(dict.fromkeys(row.scenario for row in self.rows))

    def on(self, scenario: str) -> tuple[ReportedRow, ...]:
        """Return the rows of a scenario."""
        return tuple(row for row in self.rows if row.scenario == scenario)


class _Contents(Strict):
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
    return validated(_Contents, data, str(path)).policies


def write_reported(policies: Iterable[ReportedPolicy], folder: Path) -> None:
    """Write the reported policies of a results folder; equal policies give equal bytes."""
    text = _Contents(policies=tuple(policies)).model_dump_json(indent=1, exclude_defaults=True)
    write_whole(folder / FILE, text + "\n")


def joined(policies: Iterable[ReportedPolicy], flown: Iterable[str] = ()) -> tuple[ReportedPolicy, ...]:
    """Return reported policies with those of one name as one.

    Raises:
        InputError: two of one name have other sources, levels or rows of a scenario, or one has the name of a ``flown``
            policy.

    """
    found: dict[str, ReportedPolicy] = {}
    for each in policies:
        found[each.name] = _merged(found[each.name], each) if each.name in found else each
    for name in flown:
        if name in found:
            raise InputError(f"policy {name!r} is both flown and reported; import the rows with another policy name")
    return tuple(found.values())


def _merged(one: ReportedPolicy, other: ReportedPolicy) -> ReportedPolicy:
    differing = [key for key in ("source", "level") if getattr(one, key) != getattr(other, key)]
    differing += [f"rows of {name!r}" for name in other.scenarios if one.on(name) and one.on(name) != other.on(name)]
    if differing:
        raise InputError(
            f"two reported policies are named {one.name!r} and differ in: {', '.join(differing)}; give one of them "
            "another name, or import with --replace"
        )
    more = tuple(row for row in other.rows if not one.on(row.scenario))
    files = tuple(dict.fromkeys(one.files + other.files))
    return one.model_copy(update={"files": files, "rows": one.rows + more})
