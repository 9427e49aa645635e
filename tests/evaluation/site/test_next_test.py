"""The study of the declared comparisons: its tests are those of reports, its verdicts, and what the page declares."""

import re

import numpy as np
import pytest

from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.differences import differences
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.site.studies.next_test import (
    DECLARED,
    Claim,
    Declared,
    Verdict,
    adjusted,
    compared,
    table,
)
from indoor_explorers.evaluation.statistics import holm
from tests.documents import ROOT
from tests.evaluation.report.records import made_up, results_of, room

NEXT_TEST = (ROOT / "evaluation" / "NEXT_TEST.md").read_text("utf-8")
NUMBERS = np.random.default_rng(5)
BASE = NUMBERS.integers(40, 70, 24)
TIMES = {
    "base": BASE,
    "quick": BASE - NUMBERS.integers(2, 9, 24),
    "like": BASE + NUMBERS.integers(-1, 2, 24),
    "mixed": BASE - 5 + 20 * (NUMBERS.integers(0, 3, 24) - 1),
}


@pytest.fixture(scope="module")
def results() -> Results:
    """Three policies beside a base, on 24 tasks that all finished."""
    return results_of(
        [
            made_up(policy, Task("room", 0, seed), float(late))
            for policy, times in TIMES.items()
            for seed, late in enumerate(times)
        ],
        room(),
    )


def claims(*told: tuple[str, Claim, str]) -> list[Declared]:
    return [Declared("any", "room", "t99", *each) for each in told]


def verdicts(results: Results, *told: tuple[str, Claim, str]) -> list[Verdict]:
    return [each.verdict for each in adjusted([compared(each, results) for each in claims(*told)])]


def test_a_claim_has_the_figures_and_tests_of_the_tables_of_reports(results):
    fewer, equal = (
        compared(each, results) for each in claims(("quick", Claim.FEWER, "base"), ("like", Claim.AS_GOOD, "base"))
    )
    rows = {row.policy: row.contrast for row in differences(results, ["base"]) if row.metric == "t99"}
    assert fewer.contrast.difference == rows["quick"].difference
    assert fewer.p == rows["quick"].p_value
    others = [compared(each, results).p for each in claims(*((name, Claim.AS_GOOD, "base") for name in rows))]
    assert holm(others).tolist() == pytest.approx([row.equivalence_p for row in rows.values()])
    assert equal.p == others[list(rows).index("like")]
    assert fewer.means == pytest.approx((TIMES["quick"].mean(), TIMES["base"].mean()))
    assert fewer.ratio.ratio.of_means.mean == pytest.approx(TIMES["quick"].mean() / TIMES["base"].mean())


def test_verdicts_say_what_is_shown_what_is_not_and_where_the_opposite_is(results):
    assert verdicts(
        results,
        ("quick", Claim.FEWER, "base"),
        ("quick", Claim.MORE, "base"),
        ("base", Claim.MORE, "quick"),
        ("like", Claim.FEWER, "base"),
        ("like", Claim.AS_GOOD, "base"),
        ("mixed", Claim.AS_GOOD, "base"),
    ) == [Verdict.SHOWN, Verdict.OPPOSITE, Verdict.SHOWN, Verdict.OPEN, Verdict.SHOWN, Verdict.OPEN]


def test_fewer_steps_are_not_shown_of_a_policy_that_finished_fewer_tasks(results):
    records = [
        made_up("quick", record.task, None) if (record.policy, record.task.seed) == ("quick", 3) else record
        for record in results.records
    ]
    (verdict,) = verdicts(results_of(records, room()), ("quick", Claim.FEWER, "base"))
    assert verdict is Verdict.OPEN


def test_p_values_are_adjusted_for_all_comparisons(results):
    alone = [compared(each, results) for each in claims(*[("quick", Claim.FEWER, name) for name in ("base", "like")])]
    assert [each.p for each in adjusted(alone)] == holm([each.p for each in alone]).tolist()
    first = table(alone).splitlines()[2]
    assert first.startswith("| 1 | `room` | T99 | `quick` needs fewer steps than `base` | ")
    assert first.endswith(f"| {alone[0].p:.2g} | {2 * alone[0].p:.2g} | shown |")


@pytest.mark.parametrize(("number", "each"), [*enumerate(DECLARED, 1)])
def test_the_page_declares_what_is_tested(number: int, each: Declared):
    declared = NEXT_TEST.partition("## Comparisons")[2]
    row = re.search(rf"^\| {number} \| (.+?) \| (\w+) \| (.+?) \|$", declared, re.MULTILINE)
    assert row is not None
    place, metric, claim = row.groups()
    assert (f"`{each.scenario}`" in place) or (each.folder, place) == (
        "buildings-1",
        "buildings of another kind, one UAV",
    )
    assert metric == each.metric.upper()
    assert claim.startswith(f"`{each.policy}` {each.claim} `{each.other}`")
    assert ("within 5 %" in claim) == (each.claim is Claim.AS_GOOD)


def test_there_are_six_comparisons():
    assert len(DECLARED) == 6
