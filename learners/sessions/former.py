"""Commands that trained a learner before ``indoor-explorers train`` did: translated, told, and run."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Sequence


def translated(learner: str, words: Sequence[str]) -> list[str]:
    """Return the words of ``indoor-explorers`` for a former command's: ``--learn-from real`` is ``learn_from=real``.

    An interrupted training goes on, as it did then.
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
    """Tell which command this one has become, run that, and return its exit status."""
    now = translated(learner, sys.argv[1:])
    sys.stderr.write(f"this command is now: {shlex.join(['indoor-explorers', *now])}\n")
    return subprocess.call([sys.executable, "-P", "-m", "indoor_explorers.evaluation.cli", *now])
