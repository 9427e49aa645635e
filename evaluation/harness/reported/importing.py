"""Reads rows of others from CSV, JSON and Parquet files: all of them, or none and a line for each bad row."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from indoor_explorers.env.errors import InputError, did_you_mean, shown
from indoor_explorers.env.maps.files import READERS
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, OTHER_TIMES
from indoor_explorers.evaluation.harness.reported.columns import Columns, Entry, read_columns
from indoor_explorers.evaluation.harness.reported.rows import (
    ReportedEpisode,
    ReportedMean,
    ReportedPolicy,
    joined,
    value_fault,
)

#: Texts that a boolean column may have.
TRUE, FALSE = ("true", "yes", "1"), ("false", "no", "0")
#: The key of what is wrong with the number of cells of a CSV row.
CELLS = "\0cells"
#: A row by column, with its number: of a CSV file the line, else counted from 1.
NumberedRow = tuple[int, Mapping[str, Any]]


class BadRows(InputError):
    """Report rows that cannot be used; nothing was imported."""

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__(f"{len(faults)} bad entries in the rows; nothing was imported: mend the file or its TOML file")
        self.faults = list(faults)


def imported(files: Sequence[Path], columns: Path | None = None) -> tuple[ReportedPolicy, ...]:
    """Return the policies of some files; ``columns`` is the TOML file of all of them, by default each has its own.

    Raises:
        BadRows: some rows cannot be used.
        InputError: a file cannot be read, lacks columns, or disagrees with another one.

    """
    parts = [_Table(file, read_columns(file, columns)) for file in files]
    faults = [fault for part in parts for fault in part.faults]
    if faults:
        raise BadRows(faults)
    return joined(policy for part in parts for policy in part.policies())


class _Wanted(NamedTuple):
    """What is read of each row."""

    name: str
    entry: Entry
    read: Callable[[Any], Any]
    """Returns the value; raises ``ValueError`` with what was expected."""


class _Table:
    """The rows of one file."""

    def __init__(self, file: Path, columns: Columns) -> None:
        self.file, self.columns = file, columns
        self.faults: list[str] = []
        data, self._wanted = _bytes_of(file), list(_wanted(columns))
        self.origin = f"{file.name}, SHA-256 {hashlib.sha256(data).hexdigest()}"
        rows = list(_rows_of(file, data))
        self._refuse_missing_columns(rows)
        chosen = [(n, row) for n, row in rows if all(str(row.get(k)) == v for k, v in columns.where.items())]
        if not chosen:
            raise InputError(f"{file}: expected rows{' that match where' if rows else ''}, got none")
        self.rows = [found for number, row in chosen if (found := self._read(number, row))]
        self._note_repeated()

    def _refuse_missing_columns(self, rows: Sequence[NumberedRow]) -> None:
        there = {key for _, row in rows for key in row} - {CELLS}
        for name in self.columns.named if rows else ():
            if name not in there:
                raise InputError(f"{self.file}: no column {name!r}{did_you_mean(name, map(str, there))}")

    def _read(self, number: int, row: Mapping[str, Any]) -> dict[str, Any] | None:
        """Return the values of a row; None where one of them is a fault."""
        if CELLS in row:
            self._fault(number, "the end", f"expected {row[CELLS]}")
            return None
        found, before = dict[str, Any](row=number), len(self.faults)
        for name, entry, read in self._wanted:
            value = entry.value if entry.column is None else row.get(entry.column)
            try:
                found[name] = read(value)
            except ValueError as error:
                where = f"column {entry.column!r}" if entry.column else f"{name} of the TOML file"
                self._fault(number, where, f"expected {error}, got {shown(value)}")
        return found if len(self.faults) == before else None

    def _fault(self, number: int, where: str, what: str) -> None:
        self.faults.append(f"{self.file}, row {number}, {where}: {what}")

    def policies(self) -> list[ReportedPolicy]:
        """Return the policies of rows without faults."""
        found: dict[str, list[dict[str, Any]]] = {}
        for row in self.rows:
            found.setdefault(row["policy"], []).append(row)
        return [self._policy(name, rows) for name, rows in found.items()]

    def _policy(self, name: str, rows: Sequence[dict[str, Any]]) -> ReportedPolicy:
        kind, key = (ReportedMean, "means") if self.columns.mean else (ReportedEpisode, "episodes")
        plain = set(kind.model_fields) - {"metrics"}
        made = [
            kind(
                **{field: row[field] for field in plain if field in row},
                metrics={metric: row[metric] for metric in self.columns.metrics},
            )
            for row in rows
        ]
        level = self.columns.success.level if self.columns.success else None
        about = {"name": name, "source": self.columns.source, "level": level, "files": (self.origin,)}
        return ReportedPolicy(**about, **{key: tuple(made)})

    def _note_repeated(self) -> None:
        """Add a fault for each row of the same task as one before it."""
        seen: dict[tuple[Any, ...], int] = {}
        names = ("policy", "scenario", "team") if self.columns.mean else ("policy", "scenario", "team", "map", "seed")
        for row in self.rows if self.columns.mean or self.columns.seed else ():
            first = seen.setdefault(tuple(row.get(name) for name in names), row["row"])
            if first != row["row"]:
                self._fault(row["row"], "all columns", f"expected a row of another task, got that of row {first} again")


def _wanted(columns: Columns) -> Iterator[_Wanted]:
    """Yield what is read of each row."""
    entries: dict[str, tuple[Entry | None, Callable[[Any], Any]]] = {
        "policy": (columns.policy, _text),
        "scenario": (columns.scenario, _text),
        "map": (columns.map, lambda value: map_name(_text(value))),
        "seed": (columns.seed, _whole(0)),
        "team": (columns.team, _whole(1)),
        "budget": (columns.budget, _whole(1)),
        "episodes": (columns.n, _whole(1)),
    }
    for name, (entry, read) in entries.items():
        if entry is not None:
            yield _Wanted(name, entry, _translated(entry.names, read) if entry.names else read)
    for metric, column in columns.metrics.items():
        may_lack = columns.budget is not None and (metric in LEVELS or metric in OTHER_TIMES)
        yield _Wanted(metric, Entry(column=column.column), _metric(metric, column.factor, may_lack))
    if columns.success is not None:
        yield _Wanted("success", Entry(column=columns.success.column), _share if columns.mean else _yes_or_no)


def map_name(text: str) -> str:
    """Return the name of a map from that of its file: ``99`` from ``test/99.png``."""
    path = PurePosixPath(text.replace("\\", "/"))
    return path.stem if path.suffix.lower() in READERS else path.name


def _is_empty(value: Any) -> bool:
    return value is None or value == "" or (isinstance(value, float) and math.isnan(value))


def _text(value: Any) -> str:
    text = "" if _is_empty(value) or isinstance(value, (bool, list, dict)) else str(value).strip()
    if not text or not text.isprintable() or len(text) > 400:
        raise ValueError("a name")
    return text


def _translated(names: Mapping[str, str], read: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def translate(value: Any) -> Any:
        text = _text(value)
        if text not in names:
            raise ValueError(f"one of {', '.join(names)}, which its table of names has")
        return read(names[text])

    return translate


def _number(value: Any) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ValueError("a number")
    return number


def _whole(least: int) -> Callable[[Any], int]:
    def read(value: Any) -> int:
        try:
            number = _number(value)
        except ValueError:
            number = math.nan
        if not number >= least or number != int(number):
            raise ValueError(f"a whole number of at least {least}")
        return int(value) if isinstance(value, int) else int(number)

    return read


def _metric(metric: str, factor: float, may_lack: bool) -> Callable[[Any], float | None]:
    """Return what reads a metric; a time that ``may_lack`` was never reached where its cell is empty."""

    def read(value: Any) -> float | None:
        if may_lack and _is_empty(value):
            return None
        number = factor * _number(value)
        if not math.isfinite(number) or (fault := value_fault(metric, number)):
            raise ValueError(f"{fault if math.isfinite(number) else 'a finite number'} for {metric}")
        return number

    return read


def _yes_or_no(value: Any) -> bool:
    text = str(value).strip().lower()
    if text not in (*TRUE, *FALSE):
        raise ValueError("true or false")
    return text in TRUE


def _share(value: Any) -> float:
    number = _number(value)
    if not 0 <= number <= 1:
        raise ValueError("a share from 0 to 1")
    return number


def _bytes_of(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror}") from error


def _rows_of(file: Path, data: bytes) -> Iterator[NumberedRow]:
    kinds = {".csv": _csv_rows, ".json": _json_rows, ".parquet": _parquet_rows}
    if file.suffix.lower() not in kinds:
        raise InputError(f"{file}: expected a file ending in {', '.join(kinds)}")
    return kinds[file.suffix.lower()](file, data)


def _csv_rows(file: Path, data: bytes) -> Iterator[NumberedRow]:
    try:
        reader = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""), strict=True)
        names = next(reader, [])
        if len(set(names)) < len(names):
            raise InputError(f"{file}: expected columns of different names, got {', '.join(names)}")
        for cells in filter(None, reader):
            wrong = {CELLS: f"{len(names)} cells, got {len(cells)}"} if len(cells) != len(names) else {}
            yield reader.line_num, dict(zip(names, cells, strict=False)) | wrong
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{file}: expected CSV in UTF-8, got {error}") from error


def _json_rows(file: Path, data: bytes) -> Iterator[NumberedRow]:
    try:
        rows = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file}: expected JSON, got {error}") from error
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{file}: expected a list of objects, one a row")
    yield from enumerate(rows, 1)


def _parquet_rows(file: Path, data: bytes) -> Iterator[NumberedRow]:
    import pandas as pd

    try:
        table = pd.read_parquet(io.BytesIO(data)).astype(object)
    except ImportError as error:
        raise InputError(f"{file}: Parquet needs pyarrow; install it, or convert the file to CSV") from error
    except Exception as error:
        raise InputError(f"{file}: expected Parquet, got {type(error).__name__}: {error}") from error
    yield from enumerate(({str(k): v for k, v in row.items()} for row in table.to_dict("records")), 1)
