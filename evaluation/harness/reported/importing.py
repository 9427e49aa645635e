"""Reads rows of others from CSV, JSON and Parquet files: all of them, or none and a line for each bad row."""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, create_model

from indoor_explorers.env.errors import InputError, did_you_mean, shown
from indoor_explorers.env.maps.files import READERS
from indoor_explorers.evaluation.harness.episodes.metrics import TIMES
from indoor_explorers.evaluation.harness.reported.columns import (
    Columns,
    Entry,
    MetricColumn,
    SuccessColumn,
    read_columns,
)
from indoor_explorers.evaluation.harness.reported.rows import Amount, Line, ReportedPolicy, ReportedRow, Share, joined

#: The key of what is wrong with the number of cells of a CSV row.
CELLS = "\0cells"
#: A row by column, with its number: of a CSV file the line, else counted from 1.
NumberedRow = tuple[int, Mapping[str, Any]]


class BadRows(InputError):
    """Report rows that cannot be used; nothing was imported."""

    def __init__(self, faults: Sequence[str]) -> None:
        number = f"{len(faults)} fault{'s' * (len(faults) > 1)}"
        super().__init__(f"{number} in the rows; nothing was imported: mend the file or its TOML file")
        self.faults = list(faults)


def imported(files: Sequence[Path], columns: Path | None = None) -> tuple[ReportedPolicy, ...]:
    """Return the policies of some files; ``columns`` is the TOML file of all of them, by default each has its own.

    Raises:
        BadRows: some rows cannot be used.
        InputError: a file cannot be read, lacks columns, or disagrees with another one.

    """
    parts = [_Table(file, read_columns(file, columns)) for file in files]
    if faults := [fault for part in parts for fault in part.faults]:
        raise BadRows(faults)
    return joined(policy for part in parts for policy in part.policies())


def map_name(text: str) -> str:
    """Return the name of a map from that of its file: ``99`` from ``test/99.png``."""
    path = PurePosixPath(text.replace("\\", "/"))
    return path.stem if path.suffix.lower() in READERS else path.name


#: The types of what is read beside metrics.
TYPES: dict[str, Any] = {
    **{"policy": Line, "scenario": Line, "map": Annotated[Line, AfterValidator(map_name)]},
    **{"seed": Annotated[int, Field(ge=0)], **dict.fromkeys(("team", "budget", "n"), Annotated[int, Field(ge=1)])},
}


class _Table:
    """The rows of one file."""

    def __init__(self, file: Path, columns: Columns) -> None:
        self.file, self.columns = file, columns
        given = {name: getattr(columns, name) for name in (*TYPES, "success")}
        self._entries = {name: entry for name, entry in (given | dict(columns.metrics)).items() if entry is not None}
        self._model, data = self._row_model(), _bytes_of(file)
        self._origin = f"{file.name}, SHA-256 {hashlib.sha256(data).hexdigest()}"
        rows = list(_rows_of(file, data))
        self._refuse_missing_columns(rows)
        chosen = [(n, row) for n, row in rows if all(str(row.get(k)) == v for k, v in columns.where.items())]
        if not chosen:
            raise InputError(f"{file}: expected rows{' that match where' if rows else ''}, got none")
        self.faults: list[str] = []
        self._rows = {number: found for number, row in chosen if (found := self._read(number, row))}
        self._note_repeated()

    def _row_model(self) -> type[BaseModel]:
        """Return the model of a row with our names."""
        kinds = {**TYPES, "success": Share if self.columns.mean else bool}
        for metric in self.columns.metrics:
            may_lack = self.columns.budget is not None and metric in TIMES
            kind = Share if metric.startswith("auc") else Amount
            kinds[metric] = kind | None if may_lack else kind
        fields = {name: (_translated(entry, kinds[name]), ...) for name, entry in self._entries.items()}
        how = ConfigDict(coerce_numbers_to_str=True, str_strip_whitespace=True, allow_inf_nan=False)
        return create_model("Row", __config__=how, **fields)  # type: ignore[call-overload,no-any-return]

    def _refuse_missing_columns(self, rows: Sequence[NumberedRow]) -> None:
        there = {key for _, row in rows for key in row} - {CELLS}
        for name in (*(each.column for each in self._entries.values()), *self.columns.where) if rows else ():
            if name is not None and name not in there:
                raise InputError(f"{self.file}: no column {name!r}{did_you_mean(name, map(str, there))}")

    def _read(self, number: int, row: Mapping[str, Any]) -> dict[str, Any] | None:
        """Return the values of a row by our names; None where one of them is a fault."""
        if CELLS in row:
            self._fault(number, "the end", f"expected {row[CELLS]}")
            return None
        try:
            return self._model.model_validate({k: _value(e, row) for k, e in self._entries.items()}).model_dump()
        except ValidationError as error:
            for each in error.errors():
                entry = self._entries[str(each["loc"][0])]
                where = f"column {entry.column!r}" if entry.column else f"{each['loc'][0]} of the TOML file"
                got = row.get(entry.column) if entry.column else each["input"]
                what = each["msg"].removeprefix("Input should be ").removeprefix("Value error, ")
                self._fault(number, where, f"expected {what}, got {shown(got)}")
            return None

    def _fault(self, number: int, where: str, what: str) -> None:
        self.faults.append(f"{self.file}, row {number}, {where}: {what}")

    def _note_repeated(self) -> None:
        """Add a fault for each row of the same task as one before it; without seeds a task may have several rows."""
        seen: dict[tuple[Any, ...], int] = {}
        for number, row in self._rows.items() if self.columns.mean or self.columns.seed else ():
            task = tuple(row.get(name) for name in ("policy", "scenario", "team", "map", "seed"))
            if seen.setdefault(task, number) != number:
                self._fault(number, "all columns", f"expected another task, got that of row {seen[task]} again")

    def policies(self) -> list[ReportedPolicy]:
        """Return the policies of rows without faults."""
        level = self.columns.success.level if self.columns.success else None
        found: dict[str, list[ReportedRow]] = {}
        for row in self._rows.values():
            metrics = {metric: row.pop(metric) for metric in self.columns.metrics}
            found.setdefault(row.pop("policy"), []).append(ReportedRow(metrics=metrics, **row))
        about = {"source": self.columns.source, "level": level, "files": (self._origin,)}
        return [ReportedPolicy(name=name, rows=tuple(rows), **about) for name, rows in found.items()]


def _translated(entry: Entry | MetricColumn | SuccessColumn, kind: Any) -> Any:
    """Return the type of an entry, whose names are translated first."""
    if not isinstance(entry, Entry) or not entry.names:
        return kind

    def translate(value: Any) -> Any:
        if str(value) not in entry.names:
            raise ValueError(f"one of {', '.join(entry.names)}, which its table of names has")
        return entry.names[str(value)]

    return Annotated[kind, BeforeValidator(translate)]


def _value(entry: Entry | MetricColumn | SuccessColumn, row: Mapping[str, Any]) -> Any:
    """Return the value of a row, None for an empty cell; a number of a metric is in our unit."""
    value = row.get(entry.column) if entry.column is not None else getattr(entry, "value", None)
    if value in (None, "") or value != value:
        return None
    try:
        return entry.factor * float(value) if isinstance(entry, MetricColumn) else value
    except (TypeError, ValueError):
        return value


def _bytes_of(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror}") from error


def _rows_of(file: Path, data: bytes) -> Iterator[NumberedRow]:
    kinds = {".csv": _csv_rows, ".json": _json_rows, ".parquet": _parquet_rows}
    if file.suffix.lower() not in kinds:
        raise InputError(f"{file}: expected a file ending in {', '.join(kinds)}")
    try:
        yield from kinds[file.suffix.lower()](data)
    except ImportError as error:
        raise InputError(f"{file}: Parquet needs pyarrow; install it, or convert the file to CSV") from error
    except (ValueError, csv.Error, RecursionError, OSError) as error:  # of pyarrow too
        raise InputError(f"{file}: cannot be read: {error}") from error


def _csv_rows(data: bytes) -> Iterator[NumberedRow]:
    reader = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""), strict=True)
    names = next(reader, [])
    if len(set(names)) < len(names):
        raise ValueError(f"expected columns of different names, got {', '.join(names)}")
    for cells in filter(None, reader):
        wrong = {CELLS: f"{len(names)} cells, got {len(cells)}"} if len(cells) != len(names) else {}
        yield reader.line_num, dict(zip(names, cells, strict=False)) | wrong


def _json_rows(data: bytes) -> Iterator[NumberedRow]:
    rows = json.loads(data)
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise ValueError("expected a list of objects, one a row")
    yield from enumerate(rows, 1)


def _parquet_rows(data: bytes) -> Iterator[NumberedRow]:
    import pandas as pd

    table = pd.read_parquet(io.BytesIO(data)).astype(object)
    yield from enumerate(({str(k): v for k, v in row.items()} for row in table.to_dict("records")), 1)
