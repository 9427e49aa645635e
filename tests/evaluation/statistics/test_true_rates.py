"""The true rates that STATISTICS.md prints are those of the study, and below their limit."""

import re

import pytest

from indoor_explorers.evaluation.site.studies.true_rates import FALSE, LAYOUTS, TRUE
from indoor_explorers.evaluation.statistics import undetected_share
from tests.documents import ROOT

DOCUMENT = (ROOT / "evaluation" / "STATISTICS.md").read_text("utf-8")
PRINTED = {
    name: [float(each) / 100 for each in re.findall(r"([\d.]+) %", row)]
    for name, row in re.findall(r"^\| (.+?) \| ((?:[\d.]+ % \| ){3}[\d.]+ %) \|$", DOCUMENT, re.MULTILINE)
}
#: The nominal rate and the error of a simulated one.
LIMIT = 0.06


def test_every_simulated_rate_is_printed_and_what_is_false_is_seldom_said():
    assert {*FALSE, *TRUE} <= PRINTED.keys()
    for name in FALSE:
        assert max(PRINTED[name]) <= (0.075 if "skewed" in name else LIMIT), name


@pytest.mark.parametrize(
    ("name", "layout"),
    [
        ("2 equal policies: one is better", "10"),
        ("2 with equal means, one 20 % slower on the first building", "36 in 26"),
        ("2, one 5 % slower: as good within 5 %", "30"),
        ("equal restricted means, one fails in 2 %: it is faster where both finish", "30"),
    ],
)
def test_a_few_simulations_agree_with_the_table(name, layout):
    printed = PRINTED[name][list(LAYOUTS).index(layout)]
    found = (FALSE | TRUE)[name].rate(LAYOUTS[layout], 200)
    assert abs(found - printed) <= 3 * (printed * (1 - printed) / 200) ** 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", FALSE)
def test_all_rates_of_what_is_false_are_below_their_limit(name):
    rates = [FALSE[name].rate(sizes, 1000) for sizes in LAYOUTS.values()]
    assert max(rates) <= (0.075 if "skewed" in name else LIMIT) + 0.014


def test_the_failures_that_cannot_be_excluded():
    assert undetected_share(0, 30) == pytest.approx(0.095, abs=5e-4)
    assert undetected_share(0, 100) == pytest.approx(0.030, abs=5e-4)
    assert undetected_share(0, 30) * (400 - 55) == pytest.approx(33, abs=0.5)
    assert round(0.05 / 0.98**30, 2) == 0.09
    assert undetected_share(30, 30) == 1.0
