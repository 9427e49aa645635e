"""What the columns of a file of others mean: the TOML file beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_validator

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.scenarios.validation import read_toml, validated
from indoor_explorers.evaluation.harness.reported.rows import Source, Strict, known_metrics


class Entry(Strict):
    """A column, or a value that all rows have."""

    column: str | None = None
    value: str | int | None = None
    names: Mapping[str, str] = {}
    """The names here of names in the file; a name that is missing here is refused. Empty: names are the same."""

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.column is None) == (self.value is None):
            raise ValueError('expected a value, or a table such as { column = "NAME" }')
        return self


class MetricColumn(Strict):
    """The column of a metric."""

    column: str
    factor: float = Field(1.0, gt=0)
    """What its numbers are multiplied by for the unit of the metric here, such as metres a pixel."""


class SuccessColumn(Strict):
    """The column that says whether an episode succeeded; of means, their share from 0 to 1."""

    column: str
    level: float = Field(gt=0, le=1)
    """Coverage that counts as success."""


def _entry(given: Any) -> Any:
    return given if isinstance(given, Mapping) else {"value": given}


Given = Annotated[Entry, BeforeValidator(_entry)]


class Columns(Strict):
    """What the columns of a file mean; see :class:`~.rows.ReportedRow`."""

    policy: Given
    source: Source
    scenario: Given
    map: Given | None = None
    seed: Given | None = None
    team: Given | None = None
    budget: Given | None = None
    n: Given | None = None
    mean: bool = False
    """Whether each row holds published means instead of an episode."""
    metrics: Mapping[str, MetricColumn] = {}
    success: SuccessColumn | None = None
    where: Mapping[str, str] = {}
    """Only the rows that have these values in these columns are read."""

    @model_validator(mode="after")
    def _complete(self) -> Self:
        known_metrics(self.metrics)
        if not self.metrics and self.success is None:
            raise ValueError("expected a table of metrics, or success")
        if self.mean and (self.n is None or self.map or self.seed or self.budget):
            raise ValueError("mean = true: expected n, and neither map, seed nor budget")
        if not self.mean and (self.map is None or self.n is not None):
            raise ValueError("expected map, and no n; published means say mean = true")
        return self


def read_columns(file: Path, given: Path | None) -> Columns:
    """Read the TOML file that was ``given``, or the one beside a file with its stem.

    Raises:
        InputError: there is none, or it does not say what is needed.

    """
    path = given or file.with_suffix(".toml")
    if given is None and not path.is_file():
        raise InputError(f"{file}: expected {path.name} beside it, which says what its columns are, or --columns FILE")
    return validated(Columns, read_toml(path), str(path))
