"""Where results come from: command, commit, versions and machine of a run."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any

from indoor_explorers.env.provenance import source_commit, versions

#: Packages whose versions can change results.
PACKAGES = ("indoor-explorers", "numpy", "numba", "scipy", "ompl", "pydantic")


def run_facts(command: str, workers: int) -> dict[str, Any]:
    """Return the facts of a run as a flat mapping of strings and numbers."""
    return {
        "command": command,
        "workers": workers,
        "commit": source_commit() or "unknown",
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count() or 0,
        **{f"{package} version": found for package, found in versions(PACKAGES).items()},
    }


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"
