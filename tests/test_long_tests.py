"""The list of the tests that `make test` leaves to continuous integration."""

import ast
from pathlib import Path

from tests import long_tests
from tests.long_tests import found, function_of, is_long

ROOT = Path(__file__).resolve().parents[1]
#: As pytest prints them: a test of two parameters, one of many, one beside a fixture, and files with long fixtures.
DURATIONS = """
3.10s call     tests/a/test_a.py::test_two[b::c-1]@tests/a/test_a.py
0.40s setup    tests/a/test_a.py::test_two[b::c-1]@tests/a/test_a.py
0.20s call     tests/a/test_a.py::test_two[2]@tests/a/test_a.py
0.50s call     tests/a/test_a.py::test_many[0]@group
0.60s call     tests/a/test_a.py::test_many[1]@group
0.50s call     tests/a/test_a.py::test_many[2]@group
0.90s call     tests/a/test_a.py::test_short
2.00s setup    tests/test_b.py::test_first@tests/test_b.py
2.00s setup    tests/test_b.py::test_second@tests/test_b.py
1.50s call     tests/test_b.py::test_second@tests/test_b.py
9.00s teardown tests/a/test_a.py::test_short
"""


def there(file, function=None):
    """Tell whether a file exists and defines a function."""
    path = ROOT / file
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if path.exists() else []
    return path.exists() if function is None else any(getattr(node, "name", None) == function for node in nodes)


def test_functions_are_long_by_their_parameters_and_files_by_their_fixtures():
    assert found(DURATIONS.splitlines()) == ["tests/a/test_a.py::test_two", "tests/test_b.py"]


def test_a_test_of_a_listed_function_or_file_is_long():
    listed = {"tests/a/test_a.py::test_two", "tests/test_b.py"}
    assert is_long("tests/a/test_a.py::test_two[1@2::3]@tests/a/test_a.py", listed)
    assert is_long("tests/test_b.py::test_second", listed)
    assert not is_long("tests/a/test_a.py::test_two_others", listed)
    assert not is_long("tests/a/test_b.py::test_second", listed)
    assert function_of("tests/test_b.py::test_c[d]@e") == "tests/test_b.py::test_c"


def test_what_is_listed_is_there():
    assert {name for name in long_tests.read() if not there(*name.split("::"))} == set()
