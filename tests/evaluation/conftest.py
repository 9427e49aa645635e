"""Comparisons in these tests draw no figures for print, which would take most of their time."""

import pytest

from indoor_explorers.evaluation import exports


@pytest.fixture
def figures():
    """Have comparisons draw them in a test that takes this argument."""


@pytest.fixture(autouse=True)
def _no_figures(request, monkeypatch):
    if "figures" not in request.fixturenames:
        monkeypatch.setattr(exports, "write_figures", lambda results, folder: [])
