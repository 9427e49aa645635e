"""The report: a self-contained HTML page, the terminal's table, and figures for print.

Figures are imported when they are first drawn: a page needs no matplotlib.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from indoor_explorers.evaluation.report.page import write_report
from indoor_explorers.evaluation.report.tables.headline_table import headline_table

if TYPE_CHECKING:
    from indoor_explorers.evaluation.report.figures import write_figures

__all__ = ["headline_table", "write_figures", "write_report"]


def __getattr__(name: str) -> Any:
    if name == "write_figures":
        from indoor_explorers.evaluation.report.figures import write_figures

        return write_figures
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
