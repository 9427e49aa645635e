"""A dataset of flown episodes: one Parquet file with a row for each, a data card, and their SHA-256 sums.

``make dataset RESULTS="results/a results/b"`` and ``python -m indoor_explorers.evaluation.exports.dataset`` write it
from folders of ``compare``. Nothing is computed anew: metrics are those that were stored.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from indoor_explorers.env import InputError
from indoor_explorers.env.files import expanded, writable, write_whole, written_whole
from indoor_explorers.env.policies.registry import missing_module
from indoor_explorers.evaluation.exports.markdown import line
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES, TIMES
from indoor_explorers.evaluation.harness.results.reading import StoreReader
from indoor_explorers.evaluation.harness.results.results import Results

EPISODES, CARD, SUMS = "episodes.parquet", "datacard.md", "SHA256SUMS"
#: Columns that are no metrics, with their meaning. Those of the run are as it recorded them.
COLUMNS = {
    "results": "name of the folder of results that the row is from",
    "policy": "name of the policy in these results",
    "scenario": "name of the scenario in these results",
    "suite": "suite and version whose tasks all episodes of the folder are of; missing where there is none",
    "part": "part of that suite",
    "map": "name of the map",
    "map_digest": "digest of the map's cells",
    "map_index": "number of the map in the scenario",
    "seed": "seed of start, order of moves, radio, failures and pilots, and of generated maps",
    "team": "number of UAVs",
    "budget": "steps after which the episode ends",
    "reachable": "cells that are 100 % coverage",
    "outcome": "complete, budget, ended or failed",
    "reason": "why the policy failed, or what ended the UAVs",
    "steps": "steps flown",
    "retries": "attempts at the episode that failed before; missing where the results have none",
    "commit": "git commit of the code that flew it",
    "command": "command that flew it, as it was typed",
    "started": "when that command was started, UTC",
    "version": "version of indoor-explorers",
    "python": "version of Python",
}
#: The columns of a run's facts, and what they are there.
OF_RUNS = {
    "commit": "commit",
    "command": "command",
    "started": "started",
    "version": "indoor-explorers version",
    "python": "python",
}
WHOLE = ("map_index", "seed", "team", "budget", "reachable", "steps", "retries")
INTRODUCTION = """\
# Data card: {count:,} flown episodes

Each row of `{file}` is one episode: a policy explored a map with a team of UAVs, from one seed. Its metrics are
those that `indoor-explorers compare` stored; nothing was left out, failed episodes included. `sha256sum -c {sums}`
checks the files.

    import pandas

    episodes = pandas.read_parquet("{file}")

- **For**: comparing policies task by task. Rows of one `results`, `scenario`, `map_digest` and `seed` are the same
  task, flown by each policy.
- **Not for**: means over rows of several folders, which flew different tasks; intervals that treat episodes on one map
  as independent; training, where `part` is `test`.
- **Missing values**: a time such as `t99` is missing where the coverage was never reached. Means that leave these rows
  out favour policies that fail; `compare` counts them as the budget.
- **Licence**: that of the package, MIT. Maps are not part of the data.
"""


def write_dataset(folders: Sequence[Path], out: Path) -> Path:
    """Write the episodes of folders of ``compare`` into the folder ``out``, and return it.

    Equal results give equal bytes, with one version of pyarrow.

    Raises:
        InputError: a folder holds no results, two have one name, pyarrow is missing, or nothing can be written.

    """
    names = [folder.resolve().name for folder in folders]
    if not names or len(set(names)) < len(names):
        raise InputError(f"expected folders of results with different names, got {', '.join(names) or 'none'}")
    table = episode_table(dict(zip(names, folders, strict=True)))
    with writable(out, "--out"):
        out.mkdir(parents=True, exist_ok=True)
        with written_whole(out / EPISODES) as partial:
            _write_parquet(table, partial)
        write_whole(out / CARD, data_card(table))
        sums = (f"{hashlib.sha256((out / name).read_bytes()).hexdigest()}  {name}\n" for name in (CARD, EPISODES))
        write_whole(out / SUMS, "".join(sums))
    return out


def episode_table(folders: Mapping[str, Path]) -> pd.DataFrame:
    """Return one row for each episode of folders of results by name: the :data:`COLUMNS`, then all metrics."""
    tables = [_episodes_of(name, Results.load(folder), folder) for name, folder in folders.items()]
    table = pd.concat(tables, ignore_index=True)
    metrics = [str(column) for column in table if column not in COLUMNS]
    kinds = {name: "Int64" if name in WHOLE else "string" for name in COLUMNS} | dict.fromkeys(metrics, "Float64")
    return table.reindex(columns=[*COLUMNS, *metrics]).astype(kinds)


def data_card(table: pd.DataFrame) -> str:
    """Return the text that says what the rows are, where they are from, and what each column means."""
    flown = table.groupby(["results", "suite", "part", "version", "commit", "command"], dropna=False, sort=False)
    sources = ([*("-" if pd.isna(cell) else str(cell) for cell in key), len(rows)] for key, rows in flown)
    counts = table.groupby(["policy", "team"], sort=True).agg(rows=("seed", "size"), tasks=("scenario", "nunique"))
    columns = (_column(str(name), str(kind)) for name, kind in table.dtypes.items())
    return "\n".join(
        [
            INTRODUCTION.format(count=len(table), file=EPISODES, sums=SUMS),
            *_section("Sources", ("results", "suite", "part", "version", "commit", "command", "episodes"), sources),
            *_section("Policies", ("policy", "UAVs", "episodes", "scenarios"), ([*k, *v] for k, v in _items(counts))),
            *_section("Columns", ("column", "type", "unit", "meaning"), columns),
        ]
    )


def _episodes_of(name: str, results: Results, folder: Path) -> pd.DataFrame:
    """Return the episodes of one folder of results with where they are from."""
    records = [record for group in results.groups.values() for record in group]
    if not records:
        raise InputError(f"{folder}: expected results with episodes, got none; fly compare --out first")
    with StoreReader(folder / "results.db") as store:
        runs = store.runs_of_episodes()
    flown = [runs[record.policy, record.task] for record in records]
    suite = results.suite_run
    return results.episodes().assign(
        results=name,
        suite=suite and suite.suite.title,
        part=suite and str(suite.part),
        map_digest=[record.floorplan.digest for record in records],
        **{column: [facts.get(fact) for facts in flown] for column, fact in OF_RUNS.items()},
    )


def _write_parquet(table: pd.DataFrame, path: Path) -> None:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ModuleNotFoundError as error:
        raise InputError(f"Parquet: {missing_module(error)}") from error
    pq.write_table(pa.Table.from_pandas(table, preserve_index=False), path)


def _column(name: str, kind: str) -> list[str]:
    """Return the row of a column in the data card; statistics that a pilot counts have no unit."""
    measure = MEASURES.get(name)
    meaning = COLUMNS.get(name) or (measure.definition if measure else "a statistic that the policy's pilots count")
    if name in TIMES:  # here, none has the budget in its place
        meaning = f"{meaning.partition(';')[0]}; missing where that never was"
    return [f"`{name}`", kind.lower(), measure.unit if measure else "", meaning]


def _items(table: pd.DataFrame) -> Iterator[tuple[Any, list[Any]]]:
    return ((key, list(row)) for key, row in zip(table.index, table.to_numpy(), strict=True))


def _section(title: str, heads: Sequence[str], rows: Iterator[Sequence[Any]]) -> Iterator[str]:
    """Yield the lines of a heading and a table in Markdown."""
    yield from (f"## {title}", "", line(heads), "|" + "---|" * len(heads))
    for row in rows:
        yield line(str(cell).replace("|", "\\|").replace("\n", " ") for cell in row)
    yield ""


def main() -> None:
    """Write the dataset of the folders on the command line."""
    parser = argparse.ArgumentParser(description="Write a dataset of the episodes in folders of results.")
    parser.add_argument("folders", nargs="+", type=expanded, metavar="DIR", help="a folder written by compare")
    parser.add_argument("--out", type=expanded, required=True, metavar="DIR", help="the folder of the dataset")
    given = parser.parse_args()
    try:
        write_dataset(given.folders, given.out)
    except InputError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
