"""Where results come from: versions, commit, machine and command of a run."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

#: Packages whose versions can change results.
PACKAGES = ("indoor-explorers", "numpy", "numba", "scipy", "ompl", "torch", "pydantic")


def run_facts(command: str, workers: int) -> dict[str, Any]:
    """Return the facts of a run as a flat mapping of strings and numbers."""
    return {
        "command": command,
        "workers": workers,
        "commit": source_commit(),
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count() or 0,
        **{f"{package} version": found for package in PACKAGES if (found := _version(package))},
    }


def source_commit() -> str:
    """Return the git commit of the source tree, marked when it has uncommitted changes, or ``unknown``."""
    here = Path(__file__).resolve().parent

    def git(*words: str) -> str:
        done = subprocess.run(["git", *words], cwd=here, capture_output=True, text=True, timeout=10, check=True)
        return done.stdout.strip()

    try:
        if git("ls-files", "--error-unmatch", Path(__file__).name):
            dirty = git("status", "--porcelain", "--untracked-files=no")
            return git("rev-parse", "--short=12", "HEAD") + (" with uncommitted changes" if dirty else "")
    except (OSError, subprocess.SubprocessError):
        pass
    return "unknown"


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"
