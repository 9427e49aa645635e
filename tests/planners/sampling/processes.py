"""Whether what a script prints depends on the process that runs it, or on the order of its arguments."""

from __future__ import annotations

import subprocess
import sys

import pytest


def assert_same_in_any_process_and_order(
    script: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Run a script, which prints two lines for each seed among its arguments, here and in a process of its own.

    Nothing may be left to compile: it would say so.
    """
    capsys.readouterr()
    monkeypatch.setattr(sys, "argv", ["-", "1", "2", "3"])
    exec(script, {})
    here, errors = capsys.readouterr()
    command = [sys.executable, "-c", script, "3", "1", "2", "2"]
    there = subprocess.run(command, capture_output=True, text=True, check=True)
    assert set(here.splitlines()) == set(there.stdout.splitlines())
    assert len(set(here.splitlines())) == 6
    assert errors == there.stderr == ""
