"""Comparisons here write no figures as PDF, either."""

from tests.evaluation.cli.conftest import _no_pdf

__all__ = ["_no_pdf"]
