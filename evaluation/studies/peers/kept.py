"""The file of a results folder that holds flights, one a line."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.harness.reported.rows import Strict

Kind = TypeVar("Kind", bound=Strict)


def read_flights(path: Path, kind: type[Kind]) -> list[Kind]:
    """Return the flights of a file, none if there is no file.

    Raises:
        InputError: the file is damaged.

    """
    if not path.is_file():
        return []
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = [{key: value or None for key, value in row.items()} for row in csv.DictReader(file)]
        return TypeAdapter(list[kind]).validate_python(rows)  # type: ignore[valid-type]
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(f"{path}: expected flights of the command peer, cannot read them: {error}") from error


def write_flights(path: Path, kind: type[Kind], found: Iterable[Kind]) -> None:
    """Write flights to a file, and make its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with written_whole(path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, kind.model_fields, lineterminator="\n")
        writer.writeheader()
        writer.writerows(each.model_dump() for each in found)
