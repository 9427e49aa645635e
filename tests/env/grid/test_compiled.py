"""Machine code is found again by its contents, in any copy of the sources, and compiling is announced once."""

import os
import shutil
import subprocess
import sys

import pytest

from indoor_explorers.env.grid import compile_cache
from indoor_explorers.env.grid.compiled import NOTICE, QUIET

CODE = """
import numpy as np
from indoor_explorers.env.search.connected_parts import largest_part
print(largest_part(np.ones((2, 3), bool)).sum())
"""
#: A module of two compiled functions, one of which calls the other and reads a constant.
MODULE = """
from indoor_explorers.env.grid.compiled import kernel, leaf

FACTOR = 2

@leaf()
def inner(x: int) -> int:
    '''Double a number.'''
    return FACTOR * x

@kernel()
def outer(x: int) -> int:
    return inner(x) + 1

@kernel()
def apart(x: int) -> int:
    return x - 1
"""
#: Prints the results and which functions were compiled for them, for the module in each of some folders.
CALLS = """
import sys
from indoor_explorers.env.grid import compile_cache
for folder in sys.argv[1:] or [""]:
    compiled = []
    compile_cache.listeners[:] = [lambda name: name and compiled.append(name)]
    sys.path.insert(0, folder)
    sys.modules.pop("made", None)
    import made
    print(made.outer(3), made.apart(3), *sorted(compiled))
"""


def run(code, cache, folder=None, timeout=None, words=(), **more):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)} | more
    done = subprocess.run(
        [sys.executable, *(["-P"] if folder is None else []), "-c", code, *words],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
        timeout=timeout,
    )
    return done.stdout.strip(), done.stderr


@pytest.fixture(scope="module")
def first_run(tmp_path_factory):
    """A cache that holds the machine code of :data:`CODE`, and what its first run printed."""
    cache = tmp_path_factory.mktemp("first-run")
    return cache, run(CODE, cache)


@pytest.fixture
def compiled(first_run, tmp_path):
    """A copy of that cache."""
    return shutil.copytree(first_run[0], tmp_path / "cache")


def test_compiling_is_announced_once_and_not_at_all_when_the_code_was_kept(first_run, compiled, tmp_path):
    assert first_run[1] == ("6", NOTICE)
    assert run(CODE, compiled) == ("6", "")
    assert run(CODE, tmp_path / "1", **{QUIET: "1"}) == ("6", "")


def test_kept_code_that_cannot_be_read_any_more_is_compiled_again(compiled):
    entries = list(compiled.rglob("*largest_part*.nbc"))
    for entry in entries:
        entry.write_bytes(b"cgone_module\nGone\n.")  # names a class of a module that is not there
    assert entries
    assert run(CODE, compiled) == ("6", NOTICE)
    assert run(CODE, compiled) == ("6", "")


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A cache that holds the machine code of :data:`MODULE`."""
    folder = tmp_path_factory.mktemp("first")
    (folder / "made.py").write_text(MODULE)
    cache = tmp_path_factory.mktemp("cache")
    assert run(CALLS, cache, folder)[0] == "7 2 apart inner outer"
    return cache


#: Changes of that module, and what :data:`CALLS` prints for each.
CHANGED = {
    "words": ("# a comment that moves all lines\n" + MODULE.replace("Double a number", "Another word"), "7 2"),
    "constant": (MODULE.replace("FACTOR = 2", "FACTOR = 3"), "10 2 inner outer"),
    "called function": (MODULE.replace("FACTOR * x", "FACTOR * x + 1"), "8 2 inner outer"),
    "caller": (MODULE.replace("inner(x) + 1", "inner(x) + 2"), "8 2 outer"),
    "apart": (MODULE.replace("x - 1", "x - 2"), "7 1 apart"),
    "options": (MODULE.replace("@leaf()", "@kernel()"), "7 2 inner outer"),
}


def test_what_has_changed_is_compiled_with_its_callers_and_nothing_else(kept, tmp_path):
    for name, (changed, _) in CHANGED.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "made.py").write_text(changed)
    shown, _ = run(CALLS, kept, tmp_path, words=CHANGED)
    assert dict(zip(CHANGED, shown.splitlines(), strict=True)) == {name: told for name, (_, told) in CHANGED.items()}


LEFT = """
from indoor_explorers.env.grid.compile_cache import not_compiled
import made
print(*sorted(label.partition("-")[0] for label in not_compiled()))
made.outer(3)
print(*sorted(label.partition("-")[0] for label in not_compiled()))
"""


def test_what_is_left_to_compile_is_known(tmp_path):
    (tmp_path / "made.py").write_text(MODULE)
    shown, _ = run(LEFT, tmp_path / "cache", tmp_path)
    assert shown.splitlines() == ["apart inner outer", "apart"]


def test_where_nothing_can_be_written_code_is_compiled_and_not_kept(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))  # no folder can be made below a file
    monkeypatch.setattr(compile_cache.tempfile, "gettempdir", lambda: str(tmp_path / "file"))
    compile_cache.cache_folder.cache_clear()
    try:
        assert compile_cache.cache_folder() is None
    finally:
        compile_cache.cache_folder.cache_clear()


def test_a_folder_that_cannot_be_written_is_replaced_by_one_for_temporary_files(tmp_path):
    (tmp_path / "file").write_text("")
    code = "from indoor_explorers.env.grid.compile_cache import cache_folder; print(cache_folder())"
    found, _ = run(code, tmp_path / "file", TMPDIR=str(tmp_path))
    assert found.startswith(str(tmp_path / "indoor-explorers-"))


def test_two_processes_that_start_together_compile_a_function_once(tmp_path):
    (tmp_path / "made.py").write_text(MODULE)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", CALLS], cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True
        )
        for _ in range(2)
    ]
    outputs = [process.communicate(timeout=300)[0].split() for process in processes]
    assert all(words[:2] == ["7", "2"] for words in outputs)
    assert sorted(name for words in outputs for name in words[2:]) == ["apart", "inner", "outer"]


def test_entries_that_nobody_uses_are_removed_after_a_while(compiled):
    (folder,) = compiled.glob("*/compiled")
    old, *others = sorted(folder.rglob("*.nbc"))
    os.utime(old, (0, 0))
    os.utime(folder / "last-cleaned", (0, 0))
    run("from indoor_explorers.env.grid.compile_cache import cache_folder; cache_folder()", compiled)
    assert not old.exists()
    assert all(entry.exists() for entry in others)
    assert others


WRONG = """
from indoor_explorers.env.grid.compiled import kernel

@kernel()
def wrong(number):
    return number + "one"

for _ in range(2):
    try:
        wrong(1)
    except Exception as error:
        print(type(error).__name__)
"""


def test_code_that_does_not_compile_is_refused_each_time_without_a_wait_for_the_first_call(tmp_path):
    (tmp_path / "wrong.py").write_text(WRONG)
    shown, _ = run("import wrong", tmp_path / "cache", tmp_path, timeout=compile_cache.PATIENCE)
    assert shown.split() == ["TypingError", "TypingError"]
