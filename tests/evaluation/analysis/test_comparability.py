from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env.scenarios.seed_sets import fresh_test_set
from indoor_explorers.evaluation.analysis.comparability import verdict_on
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.report.summary.overview import lead
from tests.evaluation.reports import Page


@pytest.fixture
def sound(results: Results) -> Results:
    policies = {name: results.policies[name] for name in ("straight", "wavy")}
    return replace(results, policies=policies, records=[r for r in results.records if r.policy in policies])


def test_sound_results_may_be_compared(sound: Results) -> None:
    verdict = verdict_on(sound)
    assert verdict.fine
    assert (
        verdict.headline
        == "Both policies flew the same 12 tasks: 2 scenarios, each on 6 seeds, every seed a map of its own."
    )
    assert any("wavy" in note and "true map" in note for note in verdict.notes)
    assert '"glance fine"' in render(sound)


def test_missing_episodes_leave_only_common_tasks(sound: Results) -> None:
    held = [r for r in sound.records if not (r.policy == "wavy" and r.task.scenario == "rooms" and r.task.seed == 2)]
    partial = replace(sound, records=held)
    verdict = verdict_on(partial)
    assert not verdict.fine
    assert "11 tasks of 12 in common" in verdict.headline
    assert "wavy lacks 1 of 6; only the 5 tasks" in verdict.warnings[0]
    common = partial.on_common_tasks
    assert {r.task.seed for r in common.groups["rooms", "straight"]} == {0, 1, 3, 4, 5}
    assert len(common.groups["four", "straight"]) == 6
    assert Page(render(partial)).figures["straight", "t99"][0] == np.mean(common.values("rooms", "straight", "t99"))


def test_policies_without_a_common_task_keep_theirs_and_are_told_apart(sound: Results) -> None:
    odd = replace(sound, records=[r for r in sound.records if (r.task.seed % 2 == 0) == (r.policy == "wavy")])
    assert len(odd.on_common_tasks.records) == len(odd.records)
    assert any("no task was flown by all" in text for text in verdict_on(odd).warnings)
    assert '"glance doubt"' in render(odd)


def _elsewhere(record: Record) -> Record:
    cells = record.cells.copy()
    cells[0] += 1
    return replace(record, cells=cells)


def test_tasks_that_only_look_alike_are_found_out(sound: Results) -> None:
    moved = [_elsewhere(r) if r.policy == "wavy" and r.task.seed == 0 else r for r in sound.records]
    warnings = verdict_on(replace(sound, records=moved)).warnings
    assert [text.partition(",")[0] for text in warnings] == ["In rooms", "In four"]


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"commit": "abc with uncommitted changes"}, "uncommitted changes"),
        ({"commit": "def"}, "Runs differ in commit: abc, def."),
        ({"numpy version": "1.0"}, "Runs differ in numpy version: 2.0, 1.0."),
        ({"processor": "another"}, "Runs differ in processor: one, another; latencies do not compare."),
    ],
)
def test_unlike_runs_are_named(sound: Results, facts: dict[str, str], words: str) -> None:
    run = {"command": "a", "commit": "abc", "numpy version": "2.0", "processor": "one"}
    assert verdict_on(replace(sound, runs=[run, run | {"command": "b"}])).fine
    verdict = verdict_on(replace(sound, runs=[run, run | facts]))
    assert not verdict.fine
    assert any(words in text for text in verdict.warnings)


def test_seeds_that_a_policy_has_seen_are_noted(sound: Results) -> None:
    def notes(use: str, first: int, last: int) -> list[str]:
        about = sound.policies["straight"] | {"seen_seeds": {use: [[first, last]]}}
        return [
            text
            for text in verdict_on(replace(sound, policies=sound.policies | {"straight": about})).notes
            if "seen before" in text
        ]

    assert notes("training", 6, 9) == []
    assert notes("validation", 4, 9) == [
        "Seeds seen before (straight: validated on seeds 4 to 5): such figures may be optimistic; "
        f"for unseen seeds: --seed {fresh_test_set().first}."
    ]
    assert "straight: trained on seed 0" in notes("training", 0, 0)[0]


def test_what_policies_plan_for_is_noted_where_it_differs(sound: Results) -> None:
    def notes(**aims: str) -> list[str]:
        told = {
            name: about | ({"plans_for": aims[name]} if name in aims else {}) for name, about in sound.policies.items()
        }
        return [text for text in verdict_on(replace(sound, policies=told)).notes if "policies optimise" in text]

    assert notes() == notes(straight="all cells", wavy="all cells") == []
    assert "optimise: all cells by straight; not stated by wavy. Compare" in notes(straight="all cells")[0]
    lower = {name: about | {"goal": 0.9} for name, about in sound.scenarios.items()}
    sound = replace(sound, scenarios=lower)
    assert "optimise: all cells by straight, wavy." in notes(straight="all cells", wavy="all cells")[0]


def test_plug_ins_without_hashes_of_their_sources_are_named_once(sound: Results) -> None:
    def notes(**facts: object) -> list[str]:
        told = {name: about | facts for name, about in sound.policies.items()}
        return [text for text in verdict_on(replace(sound, policies=told)).notes if "The code behind" in text]

    assert [note.partition(":")[0] for note in notes()] == ["The code behind straight, wavy is unknown"]
    assert notes(sources={"a.py": "0"}) == []
    assert notes(**{"class": "indoor_explorers.planners.swarm.pso:Pso"}) == []


def test_failures_few_episodes_and_spent_budgets_are_told(results: Results, hostile: Results) -> None:
    assert any(text.startswith("Failed policies: broken in 12 episodes") for text in verdict_on(results).warnings)
    assert any("Fewer than 5 episodes" in text for text in verdict_on(hostile).warnings)
    never = [replace(r, metrics=r.metrics | {"t99": None}) for r in hostile.records]
    assert sum(text.count("100\u202f%") for text in verdict_on(replace(hostile, records=never)).notes) == 3


def test_few_maps_are_said_to_speak_for_themselves_alone(sound: Results) -> None:
    plans = {r.task.seed % 3: r.floorplan for r in sound.records if r.task.scenario == "rooms"}
    records = [replace(r, floorplan=plans[r.task.seed % 3]) for r in sound.records if r.task.scenario == "rooms"]
    three = Results(sound.policies, {"rooms": sound.scenarios["rooms"]}, [], records)
    assert any("its 3 maps alone" in text for text in verdict_on(three).notes)
    assert "on these 3 maps" in lead([Comparison(three, "rooms")])


def test_the_overview_names_the_first_of_every_scenario(results: Results, page: Page) -> None:
    comparisons = [Comparison(results, name) for name in results.scenarios]
    assert "Lowest mean T99" in lead(comparisons)
    targets = {about.get("id") for _, about in page.tags}
    links = {str(about["href"])[1:] for tag, about in page.tags if tag == "a"}
    assert {"s1", "s2", "overview", "def-t99", "def-holm"} <= links <= targets


def test_exact_copies_of_flights_are_found_out(sound: Results) -> None:
    first = sound.groups["rooms", "straight"][0]

    def told(*policies: str) -> list[str]:
        copies = [
            replace(r, floorplan=first.floorplan, cells=first.cells)
            if r.task.scenario == "rooms" and r.policy in policies
            else r
            for r in sound.records
        ]
        verdict = verdict_on(replace(sound, records=copies))
        return [text for text in (*verdict.warnings, *verdict.notes) if "different flight" in text]

    why = "as map and starts repeat; intervals and tests count them all."
    assert told() == []
    assert told("straight") == [f"In rooms, the 6 episodes of straight are only 1 different flight, {why}"]
    assert told("straight", "wavy") == [
        f"In rooms, the 6 episodes of straight and wavy are only 1 different flight each, {why}"
    ]


def test_maps_of_unlike_sizes_are_named(sound: Results) -> None:
    large = [replace(r, reachable=4 * r.reachable) if r.task.seed == 0 else r for r in sound.records]
    assert any(
        "cells to cover: the large ones dominate means" in note
        for note in verdict_on(replace(sound, records=large)).notes
    )
    assert not any("cells to cover" in note for note in verdict_on(sound).notes)
