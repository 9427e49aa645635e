"""The command line; its modules are loaded when it is called, so that Ctrl-C is answered meanwhile as well."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from indoor_explorers.evaluation.cli.parser import build_parser

__all__ = ["build_parser", "main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    try:
        from indoor_explorers.evaluation.cli.parser import main as run
    except KeyboardInterrupt:
        sys.stderr.write("indoor-explorers: interrupted; nothing was done\n")
        return 130
    return run(argv)


def __getattr__(name: str) -> Any:
    from indoor_explorers.env.lazy_names import lazy_names

    return lazy_names(__name__, {"parser": ("build_parser",)})(name)
