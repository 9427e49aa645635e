"""The command line; its modules are loaded when it is called, so that Ctrl-C is answered meanwhile as well."""

from __future__ import annotations

import contextlib
import os
import signal

TYPE_CHECKING = False  # typing takes a while to import
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any

    from indoor_explorers.evaluation.cli.parser import build_parser

__all__ = ["build_parser", "main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    # numpy's matrix products are small here, and waiting threads of OpenBLAS would burn the cores of the workers
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    before = signal.getsignal(signal.SIGINT)
    with contextlib.suppress(ValueError):  # not in the main thread, which alone is interrupted
        signal.signal(signal.SIGINT, _leave)
    try:
        from indoor_explorers.evaluation.cli.parser import main as run
    finally:
        with contextlib.suppress(ValueError):
            signal.signal(signal.SIGINT, before)
    return run(argv)


def _leave(*_: object) -> None:
    """End the process at once: modules that are interrupted half-way raise errors of all kinds."""
    os.write(2, b"indoor-explorers: interrupted; nothing was done\n")
    os._exit(130)


def __getattr__(name: str) -> Any:
    from indoor_explorers.env.lazy_names import lazy_names

    return lazy_names(__name__, {"parser": ("build_parser",)})(name)
