"""Training commands of earlier versions: they are translated to ``indoor-explorers train``, printed and run."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Sequence


def translated(learner: str, words: Sequence[str]) -> list[str]:
    """Return the arguments of ``indoor-explorers`` for those of a former command.

    ``--learn-from real`` becomes ``learn_from=real``. As before, an interrupted training is resumed.
    """
    given: dict[str, list[str]] = {}
    for word in words:
        if word.startswith("--"):
            given[word] = []
        elif given:
            given[next(reversed(given))].append(word)
    own = [part for name in ("--seed", "--out") if name in given for part in (name, *given.pop(name))]
    settings = [
        f"{name.removeprefix('--').replace('-', '_')}={','.join(values)}" if values else f"{name[5:]}=false"
        for name, values in given.items()
    ]
    return ["train", "--learner", learner, *(["--set", *settings] if settings else []), *own, "--resume"]


def run_former(learner: str) -> int:
    """Print the command that replaces this one, run it, and return its exit status."""
    now = translated(learner, sys.argv[1:])
    sys.stderr.write(f"this command is now: {shlex.join(['indoor-explorers', *now])}\n")
    return subprocess.call([sys.executable, "-P", "-m", "indoor_explorers.evaluation.cli", *now])
