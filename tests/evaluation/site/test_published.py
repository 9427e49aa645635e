"""The reports on the site: the commands that the page shows, and that comparisons are flown once."""

import re
import shlex
from pathlib import Path

import pytest

from indoor_explorers.evaluation.cli.command import make_console
from indoor_explorers.evaluation.cli.parser import build_parser
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.site import published as site

#: Two rooms of a suite that needs no files.
ROOMS = site.PublishedComparison(
    "rooms",
    "The suite rooms",
    "Two rooms.",
    {"suite": "rooms", "team": 1, "episodes": 2, "policies": ("random", "frontier-nearest"), "workers": 0},
    replays=0,
)


@pytest.mark.parametrize("comparison", [*site.experiments(2), *site.suites(Path("DIR"))], ids=lambda it: it.name)
def test_the_command_of_a_comparison_asks_for_its_options(comparison):
    asked = vars(build_parser().parse_args(shlex.split(comparison.command)[1:]))
    assert (asked.pop("command"), asked.pop("out")) == ("compare", "DIR")
    assert ComparisonRequest.of(**asked) == ComparisonRequest.of(**comparison.options)


def test_a_report_without_replays_is_listed_with_its_command_and_flown_once(tmp_path, capsys):
    (first,) = site.published(tmp_path, [ROOMS], make_console())
    assert capsys.readouterr().out == f"{ROOMS.command}\nflying 4 episodes\n"
    (again,) = site.published(tmp_path, [ROOMS])
    assert len(Results.load(tmp_path / "rooms").runs) == 1
    assert again.origin == first.origin
    assert first.report.count(b"No episode of this scenario is replayed") == 1
    assert b'id="replay-data-' not in first.report
    assert not re.findall(rb"Click a (?:cell|curve|panel)", first.report)
    page = site.reports_page([first], with_suites=False)
    assert re.search(
        rf"## The suite rooms\n.*\(rooms\.html\).*Two rooms\.\n\nFlown on .*\n\n    {ROOMS.command}\n", page, re.S
    )
    assert "make docs DATA=FOLDER" in page
    assert "make docs" not in site.reports_page([first], with_suites=True)
