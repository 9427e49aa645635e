"""Where results come from: command, commit, versions and machine of a run."""

from __future__ import annotations

import hashlib
import os
import platform
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from indoor_explorers.env.provenance import source_commit, versions

#: Packages whose versions can change results.
PACKAGES = ("indoor-explorers", "numpy", "numba", "scipy", "ompl", "pydantic")
#: Folders of the package, and the kinds of files in them that results depend on.
FLOORS, SOURCES = ("env", "planners", "learners", "evaluation"), {".py", ".txt", ".safetensors"}


def run_facts(command: str, engine: str, workers: int | None) -> dict[str, Any]:
    """Return the facts of a run as a flat mapping of strings and numbers; ``workers`` is None for all cores."""
    return {
        "command": command,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "engine": engine,
        "workers": "all" if workers is None else workers,
        "commit": source_commit() or "unknown",
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count() or 0,
        "threads a worker": 1,
        **{f"{package} version": found for package, found in versions(PACKAGES).items()},
    }


def source_digest() -> str:
    """Return a hash of the package's modules, maps and weights: equal where these are, wherever they are installed."""
    root, digest = Path(__file__).resolve().parents[3], hashlib.sha256()
    for file in sorted(file for floor in FLOORS for file in (root / floor).rglob("*") if file.suffix in SOURCES):
        digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"
