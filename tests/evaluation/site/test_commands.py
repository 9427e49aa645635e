"""Commands on the site are broken where a shell continues them."""

import shlex

from indoor_explorers.evaluation.site.commands import WIDE, broken

LONG = "indoor-explorers compare --policies 'frontier,pso(length=1)' --scenario offices --set team=1,2 --out results/o"


def test_a_long_command_is_broken_before_options_and_stays_the_same_command():
    shown = broken(f"    {LONG}\n    indoor-explorers demo")
    assert max(map(len, shown.splitlines())) <= WIDE
    first, _, last = shown.rpartition("\n")
    assert last == "    indoor-explorers demo"
    assert all(line.endswith(" \\") for line in first.splitlines()[:-1])
    assert shlex.split(first.replace("\\\n", " ")) == shlex.split(LONG)


def test_what_is_no_long_command_is_left_alone():
    for line in (f"print({LONG!r})", f"{LONG}  # this one", "indoor-explorers demo", ""):
        assert broken(line) == line
