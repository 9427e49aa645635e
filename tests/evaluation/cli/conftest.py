"""Comparisons here write no figures as PDF: each embeds fonts, which takes as long as all the rest; the report's do."""

import pytest

from indoor_explorers.evaluation.report.style import print_style


@pytest.fixture(autouse=True)
def _no_pdf(monkeypatch):
    formats = {ending: options for ending, options in print_style.FORMATS.items() if ending != "pdf"}
    monkeypatch.setattr(print_style, "FORMATS", formats)
