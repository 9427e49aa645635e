from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.coverage_axes import axes_of, coverage_at
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.charts.interactive import chart_data, times_data
from indoor_explorers.evaluation.report.charts.small_multiples import map_multiples, scenario_multiples
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.report.records import flown
from tests.evaluation.reports import Page


def _shares(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), "<u2") / 65535


def test_coverage_at_an_amount_is_that_of_the_last_step_it_pays_for(results: Results) -> None:
    records = results.groups["four", "straight"]
    for axis in ("distance", "seconds", "bytes"):
        amounts = np.linspace(0, max(record.spent(axis)[-1] for record in records), 7)
        found = coverage_at(records, amounts, axis=axis)
        for record, row in zip(records, found, strict=True):
            for amount, share in zip(amounts, row, strict=True):
                step = max((s for s, spent in enumerate(record.spent(axis)) if spent <= amount), default=0)
                assert share == record.curve[step]


def test_axes_are_offered_only_where_something_was_spent(results: Results) -> None:
    assert [axis.key for axis in axes_of(Comparison(results, "rooms"), 60)] == ["steps", "distance", "seconds"]
    four = axes_of(Comparison(results, "four"), 60)
    assert [axis.key for axis in four] == ["steps", "distance", "seconds", "bytes"]
    for axis in four:
        assert (np.diff(axis.amounts) > 0).all()
        assert 0 < axis.focus <= axis.amounts[-1]


def test_embedded_curves_are_the_means_of_the_records(results: Results) -> None:
    data = chart_data(Comparison(results, "four"), policy_styles(results.policies), 60)
    for axis in data["axes"]:
        for policy in data["policies"]:
            for who in ("team", "worst", "mean"):
                records = results.groups["four", policy["name"]]
                curves = policy["curves"][axis["key"]][who]
                mean = coverage_at(records, np.array(axis["amounts"]), who, axis["key"]).mean(axis=0)
                assert _shares(curves["mean"]) == pytest.approx(mean, abs=1e-5)
                assert (_shares(curves["low"]) <= _shares(curves["mean"])).all()
                assert (_shares(curves["high"]) >= _shares(curves["mean"])).all()


def test_times_end_at_the_share_that_ever_got_there(results: Results) -> None:
    data = times_data(Comparison(results, "rooms"), policy_styles(results.policies))
    assert [level["key"] for level in data["levels"]] == ["t99", "t95", "t90"]
    for policy in data["policies"]:
        for level, times in policy["times"].items():
            late = [record.metrics[level] for record in results.groups["rooms", policy["name"]]]
            reached = sorted(step for step in late if step is not None)
            assert times["steps"][-1] == data["budget"] == 400
            assert times["share"][-1] == pytest.approx(len(reached) / 6, abs=1e-4)
            for step, share in zip(times["steps"], times["share"], strict=True):
                assert share == pytest.approx(sum(one <= step for one in reached) / 6, abs=1e-4)


def _on_files(results: Results, files: int, folders: int) -> Results:
    """Pretend that the episodes of a scenario were flown on map files."""
    first = [record for record in results.records if record.task.scenario == "rooms" and record.task.seed < 2]
    records = [
        replace(r, task=r.task._replace(map_index=k), floorplan=replace(r.floorplan, name=f"</script> {k} 🗺"))
        for r in first
        for k in range(files)
    ]
    paths = [f"/maps/folder-{k % folders}/{k}.png" for k in range(files)]
    settings = results.scenarios["rooms"] | {"map": {"source": "files", "paths": paths}}
    return Results(results.policies, {"rooms": settings}, results.runs, records)


@pytest.mark.parametrize(
    ("files", "folders", "panels", "by_folder"), [(3, 1, 3, False), (30, 4, 4, True), (30, 1, 24, False)]
)
def test_every_map_gets_a_panel_or_its_folder_does(
    results: Results, files: int, folders: int, panels: int, by_folder: bool
) -> None:
    found = _on_files(results, files, folders)
    multiples = map_multiples(Comparison(found, "rooms"), policy_styles(found.policies))
    assert multiples is not None
    assert (len(multiples.panels), multiples.maps, multiples.by_folder) == (panels, files, by_folder)
    for panel in multiples.panels:
        assert panel.drawing.count('class="curve"') == len(found.policies)
    assert multiples.panels[0].title == ("folder-0" if by_folder else "</script> 0 🗺")


def test_a_panel_opens_the_replay_of_its_map(results: Results) -> None:
    found = _on_files(results, 3, 1)
    page = Page(render(found))
    targets = [json.loads(str(about["data-replay"])) for tag, about in page.tags if about.get("class") == "multiple"]
    assert [target["task"][0] for target in targets[:3]] == [0, 1, 2]
    assert map_multiples(Comparison(results, "rooms"), policy_styles(results.policies)) is None


def test_every_scenario_has_a_small_chart_that_names_its_kind(results: Results) -> None:
    names = {"a": "thesis", "b": "cave", "c": "thesis"}
    scenarios = {name: results.scenarios["rooms"] | {"map": {"source": kind}} for name, kind in names.items()}
    records = [
        replace(r, task=r.task._replace(scenario=name))
        for name in names
        for r in results.records
        if r.task[0] == "rooms"
    ]
    found = Results(results.policies, scenarios, [], records)
    pairs = [(f"s{number}", Comparison(found, name)) for number, name in enumerate(names, 1)]
    panels = scenario_multiples(pairs, policy_styles(found.policies))
    assert [(panel.title, panel.section) for panel in panels] == [("a", "s1"), ("b", "s2"), ("c", "s3")]
    assert panels[1].detail == "cave maps, 1 UAV"
    assert scenario_multiples(pairs[:1], policy_styles(found.policies)) == []


def test_bands_are_left_out_at_first_where_policies_are_so_many_that_they_hide_each_other() -> None:
    for number, bands in ((7, "shown"), (8, "hidden")):
        found = flown({f"p{k}": [9.0 + k] * 5 for k in range(number)})
        assert chart_data(Comparison(found, "room"), policy_styles(found.policies))["bands"] == bands
    pressed = [about for tag, about in Page(render(found)).tags if about.get("data-choice") == "bands"]
    assert [(about["data-value"], about["aria-pressed"]) for about in pressed] == [
        ("hidden", "true"),
        ("shown", "false"),
    ]
