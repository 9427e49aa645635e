"""The report: a self-contained HTML page."""

from indoor_explorers.evaluation.report.page import write_report

__all__ = ["write_report"]
