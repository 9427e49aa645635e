"""Where worker processes find the plug-ins of the tests."""

import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="module", autouse=True)
def plugins_found():
    """Let worker processes import the plug-ins by the path that they inherit."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [*sys.path, str(Path(__file__).resolve().parents[4])])
        yield
