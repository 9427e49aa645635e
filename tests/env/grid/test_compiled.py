"""Machine code is kept for the present state of the sources, and compiling it is announced once."""

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numba

import indoor_explorers.env
from indoor_explorers.env.grid.compiled import NOTICE, QUIET, _stamp, _top

CODE = """
import numpy as np
from indoor_explorers.env.grid.cells import largest_part
print(largest_part(np.ones((2, 3), bool)).sum())
"""


def test_compiling_is_announced_once_and_not_at_all_when_the_code_was_kept(tmp_path):
    def run(**more):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / more.get(QUIET, "0"))} | more
        done = subprocess.run(
            [sys.executable, "-P", "-c", CODE], env=environment, capture_output=True, text=True, check=True
        )
        assert done.stdout == "6\n"
        return done.stderr

    assert run() == NOTICE
    assert run() == ""
    assert run(**{QUIET: "1"}) == ""


def test_kept_code_that_cannot_be_read_any_more_is_compiled_again(tmp_path):
    def run():
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
        return subprocess.run(
            [sys.executable, "-P", "-c", CODE], env=environment, capture_output=True, text=True, check=True
        ).stderr

    run()
    indexes = list(tmp_path.rglob("*largest_part*.nbi"))
    for index in indexes:
        version = pickle.dumps(numba.__version__)
        index.write_bytes(version + b"cgone_module\nGone\n.")  # names a class of a module that is not there
    assert indexes
    assert run() == NOTICE
    assert run() == ""


def test_a_change_in_any_file_of_the_package_makes_kept_code_stale(tmp_path):
    copy = Path(shutil.copytree(Path(indoor_explorers.env.__file__).parent, tmp_path / "env"))

    def stamp():
        _stamp.cache_clear()
        return _stamp(copy)

    before = stamp()
    assert stamp() == before
    (copy / "maps" / "thesis.py").write_text("# another file\n")
    changed = stamp()
    assert changed != before
    (copy / "maps" / "new.py").write_text("")
    assert stamp() not in {before, changed}
    _stamp.cache_clear()


def test_the_package_of_a_file_is_the_outermost_one():
    folder = Path(indoor_explorers.env.__file__).parent
    assert _top(folder / "maps") == _top(folder) == folder
