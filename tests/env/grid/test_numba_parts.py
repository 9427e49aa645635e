"""Where numba has renamed a private part, everything is compiled by numba's own means: later, with the same results."""

import json
import textwrap
from pathlib import Path

import pytest

from indoor_explorers.env.grid.compiled import QUIET
from indoor_explorers.env.grid.numba_parts import MISSING
from tests.env.grid.test_compiled import CODE, run
from tests.marks import slow

ROOT = Path(__file__).parents[3]
#: What a new numba may do, before this project is imported.
CHANGES = {
    "renamed": "from numba.core import codegen; del codegen.JITCodeLibrary",
    "arguments": "from numba.core.caching import FunctionCache; FunctionCache.flush = lambda self, all=True: None",
}
FLIGHT = """
from tests.test_golden import flown
import json
print(json.dumps(flown("frontier-nearest", "thesis-team-2")))
"""


def test_the_installed_numba_has_all_parts():
    assert MISSING == ""


@pytest.mark.parametrize("change", ["renamed", *slow("arguments")])
def test_a_change_of_numba_slows_and_breaks_nothing(change, tmp_path):
    code = CHANGES[change] + textwrap.dedent(CODE)
    for _ in range(2):
        shown, told = run(code, tmp_path)
        assert shown == "6"
        assert told.startswith("indoor-explorers: numba ")
        assert told.count("\n") == 1
    assert list(tmp_path.rglob("*largest_part*.nbi"))
    assert run(code, tmp_path, **{QUIET: "1"}) == ("6", "")


@pytest.mark.slow
def test_a_golden_episode_is_flown_without_the_private_parts(tmp_path):
    shown, _ = run(CHANGES["renamed"] + FLIGHT, tmp_path, ROOT)
    golden = json.loads((ROOT / "tests/golden.json").read_text())
    assert json.loads(shown) == golden["frontier-nearest thesis-team-2"]
