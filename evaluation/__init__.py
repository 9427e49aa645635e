"""Experiments, their results and reports."""

from typing import TYPE_CHECKING, Any

from indoor_explorers.evaluation.compare import compare

if TYPE_CHECKING:
    from indoor_explorers.evaluation.results.results import Results

__all__ = ["Results", "compare"]


def __getattr__(name: str) -> Any:
    """Import what tables and statistics need only when it is asked for: worker processes never do."""
    if name != "Results":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from indoor_explorers.evaluation.results.results import Results

    return Results
