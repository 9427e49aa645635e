"""The report: a self-contained HTML page, the terminal's table, and figures for print."""

from indoor_explorers.evaluation.report.figures import write_figures
from indoor_explorers.evaluation.report.page import write_report
from indoor_explorers.evaluation.report.tables.headline_table import headline_table

__all__ = ["headline_table", "write_figures", "write_report"]
