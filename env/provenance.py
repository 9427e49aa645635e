"""Provenance of results and weights: the source's commit and the versions of packages."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TypeVar

from indoor_explorers.env.scenarios.seed_sets import SeedUse

#: The file of a training's record in its folder.
RECORD = "training.json"

Seen = TypeVar("Seen")


def versions(packages: Iterable[str]) -> dict[str, str]:
    """Return the versions of the given packages that are installed."""
    found = {}
    for package in packages:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def source_commit() -> str | None:
    """Return the git commit of the source tree, marked when it has uncommitted changes; None when not under git."""
    here = Path(__file__).resolve()
    if _git(here.parent, "ls-files", "--error-unmatch", here.name) is None:
        return None
    commit = _git(here.parent, "rev-parse", "HEAD")
    return f"{commit} with uncommitted changes" if _git(here.parent, "status", "-uno", "--porcelain") else commit


def record_of(weights: Path) -> Path:
    """Return the path of the record of the training that made a weights file: that of shipped ones has their name."""
    shipped = weights.with_suffix(".json")
    return shipped if shipped.exists() else weights.parent / RECORD


def recorded_maps(path: Path) -> dict[str, list[str]]:
    """Return the map files that weights were trained on, by use: ``seen_maps`` of a training's record, if any."""
    try:
        seen = json.loads(path.read_text(encoding="utf-8")).get("seen_maps", {})
        return {SeedUse(use): [str(each) for each in listed] for use, listed in seen.items()}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def joined(records: Sequence[Mapping[str, Sequence[Seen]]]) -> dict[str, list[Seen]]:
    """Return the union of several trainings' seeds or maps by use, each entry once."""
    uses = dict.fromkeys(use for record in records for use in record)
    return {use: list(dict.fromkeys(each for record in records for each in record.get(use, ()))) for use in uses}


def _git(folder: Path, *words: str) -> str | None:
    try:
        done = subprocess.run(["git", *words], cwd=folder, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
