"""New results against old ones: what was planted is found, what is noise is not."""

import re
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.evaluation.analysis.against import HEADLINE, against_lines, compare_with
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.special_names import NAMES, SCENARIO, results

EPISODES = 12


@pytest.fixture(scope="module")
def old():
    return results(EPISODES)


def with_metric(held, metric, policy, shift):
    """Add ``shift`` (E,) to a metric of a policy, which is taken as 30 where it was never reached."""

    def shifted(record):
        value = record.metrics[metric]
        moved = (30.0 if value is None else value) + shift[record.task.seed - 4]
        return replace(record, metrics=record.metrics | {metric: moved}) if record.policy == policy else record

    return replace(held, records=[shifted(record) for record in held.records])


def printed(against, width=250):
    console = Console(width=width, no_color=True)
    with console.capture() as shown:
        for part in against_lines(against, width):
            console.print(part)
    return shown.get()


def test_the_same_results_are_the_same_flights(old):
    found = compare_with(old, replace(old, records=list(old.records)))
    assert (found.changes, found.shown, found.apart) == ([], 0, [])
    assert [each.text for each in found.identities] == [
        f"{EPISODES} of {EPISODES} episodes identical, step for step"
    ] * 3
    assert "12 of 12 episodes identical" in printed(found)


def test_a_planted_change_is_found_and_noise_is_not(old):
    noise = np.array([5.0, -5.0] * (EPISODES // 2))
    base = with_metric(with_metric(old, "t90", NAMES[0], np.zeros(EPISODES)), "t90", NAMES[1], np.zeros(EPISODES))
    new = with_metric(base, "t90", NAMES[0], np.linspace(-9, -7, EPISODES))
    new = with_metric(new, "path_length", NAMES[1], noise + np.arange(EPISODES) % 3)
    found = compare_with(new, base)
    assert [(change.policy, change.metric) for change in found.changes] == [
        *[(NAMES[0], "t90"), (NAMES[1], "path_length")]
    ]
    first, second = found.changes
    assert (first.shown, first.better, second.shown, found.shown) == (True, True, False, 1)
    assert first.difference.mean == pytest.approx(-8)
    assert first.adjusted_p == pytest.approx(2 * 2 / 2**EPISODES)  # exact, times the two comparisons
    assert first.difference.low <= -8 <= first.difference.high < 0
    assert (first.verdict, second.verdict) == ("better", "not significant")
    assert second.detectable > abs(second.difference.mean)
    assert "1 of 2 comparisons changed significantly" in printed(found)


def test_worse_goes_by_the_metric_and_latencies_get_a_caveat(old):
    new = with_metric(old, "auc", NAMES[0], np.linspace(-0.011, -0.01, EPISODES))
    new = with_metric(new, "latency_p50_us", NAMES[0], np.linspace(-2.2, -2, EPISODES))
    verdicts = {change.metric: change.verdict for change in compare_with(new, old).changes}
    assert verdicts == {"auc": "worse", "latency_p50_us": "better, or the machine"}


@pytest.mark.parametrize("width", [80, 109, 110])
def test_verdicts_and_differences_are_whole_in_narrow_windows(width, old):
    named = results(EPISODES)
    plain = replace(named, records=[replace(r, policy="frontier-nearest") for r in named.records[:EPISODES]])
    plain = replace(plain, policies={"frontier-nearest": {}})
    new = with_metric(plain, "latency_p50_us", "frontier-nearest", np.linspace(-2.2, -2, EPISODES))
    new = with_metric(new, "path_length", "frontier-nearest", np.array([5.0, -5.0] * (EPISODES // 2)))
    found = compare_with(new, plain)
    shown = printed(found, width)
    assert "frontier-nearest" in shown
    assert "not significant" in " ".join(shown.split())
    assert all(change.figures[2] in shown for change in found.changes)
    assert "\N{HORIZONTAL ELLIPSIS}" not in shown


def test_many_comparisons_of_noise_invent_nothing(old):
    rng, new = np.random.default_rng(3), old
    for metric in [name for name in HEADLINE if name != "success"]:
        for policy in NAMES:
            new = with_metric(new, metric, policy, rng.normal(0, 1, EPISODES))
    base = old
    for metric in ("t90", "t99"):
        for policy in NAMES:
            base = with_metric(base, metric, policy, np.zeros(EPISODES))
    found = compare_with(new, base)
    assert "t99" not in {change.metric for change in found.changes}  # the goal does not ask for it
    assert len(found.changes) == 3 * (len(HEADLINE) - 2)
    assert found.shown == 0


def test_too_few_tasks_say_so(old):
    few = replace(old, records=[record for record in old.records if record.task.seed < 7])
    found = compare_with(with_metric(few, "path_length", NAMES[0], [9] * EPISODES), few)
    assert [(change.verdict, change.figures[3]) for change in found.changes] == [("too few tasks", "\u2013")]


def test_flights_and_policies_that_differ_are_counted(old):
    records = [replace(old.records[0], actions=old.records[0].actions[::-1]), *old.records[1:]]
    policies = old.policies | {NAMES[0]: old.policies[NAMES[0]] | {"parameters": {"speed": "9"}, "hash": "x"}}
    first = compare_with(replace(old, records=records, policies=policies), old).identities[0]
    assert first.text == "11 of 12 episodes identical, step for step; the policy differs: parameters.speed (1 and 9)"
    policies[NAMES[0]] = {"class": "b:B", "parameters": {"other": "1"}}
    first = compare_with(replace(old, policies=policies), old).identities[0]
    assert first.parameters == "class (not set and b:B)"


def test_what_only_one_has_is_listed(old):
    fewer = replace(old, records=[r for r in old.records if r.policy != NAMES[2] and r.task.seed != 4])
    lines = compare_with(old, fewer).apart
    assert f"policy {NAMES[2]!r} flew {SCENARIO!r} in the new results only" in lines
    assert f"policy {NAMES[0]!r} on {SCENARIO!r}: 11 tasks in both, 1 in one only" in lines
    other = {SCENARIO: old.scenarios[SCENARIO] | {"fingerprint": "0", "budget": 9}}
    unlike = compare_with(old, replace(old, scenarios=other))
    assert unlike.apart == [f"scenario {SCENARIO!r} is not the same task in both; what differs: budget (9 and 60)"]
    assert (unlike.changes, unlike.identities) == ([], [])
    nothing = compare_with(old, replace(old, scenarios={}, records=[]))
    assert nothing.apart == [f"scenario {SCENARIO!r} is in the new results only"]


def test_the_page_shows_names_as_text_and_only_when_asked(old):
    found = compare_with(with_metric(old, "path_length", NAMES[0], np.arange(EPISODES)), old)
    page = render(old, against=found)
    assert '<a href="#against">' in page
    section = page[page.index('<section id="against">') :].partition("</section>")[0]
    assert "<script" not in section
    assert not re.search(r"<(?!/?(h2|p|q|div|table|thead|tbody|tr|t[hd]|ul|li|strong|section)\b)", section)
    assert "1 of 1 comparison changed significantly" in section
    assert "12 of 12 episodes identical, step for step" in section
    assert "Against the old results" not in render(old)
    assert all(name in printed(found) for name in NAMES)


def test_the_command_tells_and_exits_well(tmp_path, capsys):
    words = ["compare", "--scenario", "thesis-open", "--episodes", "3", "--workers", "0", "--out"]
    main([*words, str(tmp_path / "old"), "--policies", "random"])
    main([*words, str(tmp_path / "new"), "--policies", "random,frontier-nearest"])
    capsys.readouterr()
    report = ["report", str(tmp_path / "new"), "--against", str(tmp_path / "old"), "--out", str(tmp_path / "r.html")]
    assert main([*report, "--exports", str(tmp_path / "exports")]) == 0
    shown = capsys.readouterr().out
    assert "thesis-open, random: 3 of 3 episodes identical, step for step" in shown
    assert "policy 'frontier-nearest' flew 'thesis-open' in the new results only" in " ".join(shown.split())
    assert "Against the old results" in (tmp_path / "r.html").read_text(encoding="utf-8")
    assert (tmp_path / "exports" / "planner-arena.db").is_file()
    assert (tmp_path / "exports" / "summary.csv").read_bytes() == (tmp_path / "new" / "summary.csv").read_bytes()
    assert main(["report", str(tmp_path / "new"), "--against", str(tmp_path), "--out", str(tmp_path / "no.html")]) == 2


def test_results_without_a_common_task_are_refused(tmp_path, capsys):
    words = ["compare", "--policies", "random", "--scenario", "thesis-open", "--episodes", "1", "--workers", "0"]
    main([*words, "--out", str(tmp_path / "old")])
    main([*words, "--seed", "5", "--out", str(tmp_path / "new")])
    capsys.readouterr()
    page = tmp_path / "page.html"
    assert main(["report", str(tmp_path / "new"), "--against", str(tmp_path / "old"), "--out", str(page)]) == 2
    shown = capsys.readouterr()
    assert (shown.out, shown.err.count("\n")) == ("", 1)
    assert (
        "expected results of the same tasks, got none in both; policy 'random' on 'thesis-open': 0 tasks" in shown.err
    )
    assert not page.exists()
