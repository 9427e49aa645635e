"""Tests open no windows: SDL draws into memory."""

import pytest


@pytest.fixture(autouse=True)
def _no_windows(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
