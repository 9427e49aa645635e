from __future__ import annotations

import math
from typing import Any

import pytest

from indoor_explorers.env import Scenario, scenario
from indoor_explorers.evaluation.analysis.panels.sweep_panels import sweep_sections
from indoor_explorers.evaluation.analysis.panels.sweep_plots import setting_plots
from indoor_explorers.evaluation.analysis.panels.team_scaling import scaling_plots, speed_ups
from indoor_explorers.evaluation.analysis.sweeps import (
    RadioSweep,
    SettingSweep,
    TeamScaling,
    radio_sweeps,
    setting_sweeps,
    team_scalings,
)
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.report.records import BUDGET, facts, made_up, results_of, room

#: One point of every sweep of a setting.
BASE = scenario("thesis-obstacles").for_evaluation()


def radio(name: str, model: str, reach: float = 0.0, **others: Any) -> Scenario:
    return room(name, **{"team": 2, "radio.model": model, "radio.range": reach, **others})


def test_ranges_are_ordered_from_none_to_unlimited() -> None:
    found = radio_sweeps(
        facts(radio("all", "unlimited"), radio("five", "disc", 5.0), radio("none", "none"), radio("two", "disc", 2.0))
    )
    assert found == [RadioSweep("disc", 2, ("none", "two", "five", "all"), (0.0, 2.0, 5.0, math.inf))]


def test_models_are_sweeps_of_their_own_that_share_the_ends() -> None:
    found = radio_sweeps(facts(radio("none", "none"), radio("disc", "disc", 5.0), radio("square", "square", 5.0)))
    assert [(sweep.model, sweep.scenarios) for sweep in found] == [
        ("disc", ("none", "disc")),
        ("square", ("none", "square")),
    ]


def test_no_radio_against_an_unlimited_one_is_a_sweep() -> None:
    (sweep,) = radio_sweeps(facts(radio("none", "none"), radio("all", "unlimited")))
    assert sweep.reaches == (0.0, math.inf)


@pytest.mark.parametrize(
    "other",
    [
        radio("b", "disc", 9.0, team=3),
        radio("b", "disc", 9.0, **{"lidar.range": 5.0}),
        radio("b", "disc", 9.0, **{"radio.loss": 0.5}),
        radio("b", "square", 9.0),
        radio("b", "disc", 2.0),
        room("b"),
    ],
)
def test_what_differs_in_more_or_less_than_the_range_is_no_sweep(other: Scenario) -> None:
    assert radio_sweeps(facts(radio("a", "disc", 2.0), other)) == []


def test_settings_that_a_radio_does_not_use_do_not_matter() -> None:
    found = radio_sweeps(facts(radio("a", "disc", 2.0), radio("b", "disc", 3.0, **{"radio.wall_loss": 9.0})))
    assert [sweep.scenarios for sweep in found] == [("a", "b")]
    walls = {"radio.wall_loss": 9.0}
    assert radio_sweeps(facts(radio("a", "path-loss", 2.0), radio("b", "path-loss", 3.0, **walls))) == []
    assert len(radio_sweeps(facts(radio("a", "none"), radio("b", "disc", 3.0, **{"radio.loss": 0.2})))) == 1


def test_the_presets_form_the_sweeps_they_were_made_for() -> None:
    names = ["thesis-obstacles", "thesis-team-2", "thesis-team-4", *(f"thesis-team-2-radio-{r}" for r in (0, 1, 3))]
    settings = facts(*(scenario(name).for_evaluation() for name in names))
    (sweep,) = radio_sweeps(settings)
    assert sweep.scenarios == tuple(names[3:])
    assert sweep.reaches == (0.0, 1.0, 3.0)
    families = team_scalings(settings)
    assert families[0] == TeamScaling(("thesis-obstacles", "thesis-team-2", "thesis-team-4"), (1, 2, 4))


def test_listed_spawns_differ_between_teams_and_other_starts_do_not() -> None:
    solo, pair = room("solo", spawn=((1, 1),)), room("pair", 2, spawn=((1, 1), (2, 2)))
    assert team_scalings(facts(solo, pair)) == [TeamScaling(("solo", "pair"), (1, 2))]
    assert team_scalings(facts(solo, room("pair", 2, spawn="clustered"))) == []
    assert team_scalings(facts(room("solo"), room("pair", 2, budget=77))) == []
    assert team_scalings(facts(room("two", 2), room("four", 4))) == []


def test_scenarios_that_differ_in_one_setting_are_a_sweep_from_three_on() -> None:
    few = [BASE.with_settings({"name": f"obstacles {n}", "map.obstacles": n}) for n in (9, 0)]
    far = [BASE.with_settings({"name": f"lidar {n}", "lidar.range": n}) for n in (5, 2)]
    assert setting_sweeps(facts(BASE, *few)) == [
        SettingSweep("obstacles", ("obstacles 0", "thesis-obstacles", "obstacles 9"), (0.0, 5.0, 9.0))
    ]
    assert [each.values for each in setting_sweeps(facts(BASE, *few, *far))] == [(2.0, 3.0, 5.0), (0.0, 5.0, 9.0)]
    assert setting_sweeps(facts(BASE, few[0], far[0])) == []


def test_any_number_can_be_swept() -> None:
    loss = [radio(f"loss {n}", "disc", 3.0, **{"radio.loss": n}) for n in (0.0, 0.5, 0.2)]
    assert setting_sweeps(facts(*loss)) == [
        SettingSweep("radio.loss", ("loss 0.0", "loss 0.2", "loss 0.5"), (0.0, 0.2, 0.5))
    ]
    assert setting_sweeps(facts(*(radio(f"range {n}", "disc", n) for n in (1.0, 2.0, 3.0)))) == []


def test_kinds_of_maps_with_other_settings_are_no_sweep() -> None:
    names = ("thesis-obstacles", "rooms", "offices", "office", "cave", "maze", "floors")
    assert setting_sweeps(facts(*(scenario(name).for_evaluation() for name in names))) == []


def test_sides_are_swept_on_square_maps_alone() -> None:
    sizes = [BASE.with_settings({"name": f"{n}", "map.height": n, "map.width": n}) for n in (20, 24)]
    (sweep,) = setting_sweeps(facts(BASE, *sizes))
    assert (sweep.setting, sweep.values) == ("side of the map [cells]", (16.0, 20.0, 24.0))
    flat = BASE.with_settings({"name": "flat", "map.width": 30})
    assert setting_sweeps(facts(BASE, sizes[0], flat)) == []


def test_a_setting_is_drawn_from_its_least_value_on() -> None:
    far = [BASE.with_settings({"name": f"{n}", "lidar.range": n}) for n in (4, 5)]
    records = [made_up("a", Task(name, 0, seed), 30) for name in ("thesis-obstacles", "4", "5") for seed in range(6)]
    results = results_of(records, BASE, *far)
    (sweep,) = setting_sweeps(results.scenarios)
    plots = setting_plots(results, sweep, policy_styles(("a",)))
    assert [plot.title for plot in plots] == ["T90 [steps]", "T99 [steps]"]
    assert plots[0].x.title == "lidar range [cells]"
    assert plots[0].x.low == pytest.approx(3 - 0.07 * 2)
    assert plots[0].series[0].x == [3.0, 4.0, 5.0]
    assert plots[0].series[0].text[1].startswith("lidar range 4: ")


def test_the_range_of_a_sweep_leaves_out_who_is_far_behind_everywhere() -> None:
    far = [BASE.with_settings({"name": f"{n}", "lidar.range": n}) for n in (4, 5)]
    times = {"a": 20, "b": 24, "lost": 90}
    records = [
        made_up(policy, Task(name, 0, seed), late)
        for policy, late in times.items()
        for name in ("thesis-obstacles", "4", "5")
        for seed in range(6)
    ]
    results = results_of(records, BASE, *far)
    (sweep,) = setting_sweeps(results.scenarios)
    for plot in setting_plots(results, sweep, policy_styles(times)):
        assert plot.y.high < 30
        assert [series.name for series in plot.series] == ["a", "b", "lost"]
        assert plot.beyond == "Ranges are made without lost, far behind."
    (panel,) = sweep_sections(results, policy_styles(times)).setting
    assert panel.beyond in render(results)


def test_speed_up_is_a_ratio_of_means_over_common_tasks() -> None:
    scenarios = room("solo"), room("pair", 2)
    alone, together = [40, 50, 60, 70, 80, 90], [20, 30, 40, 30, 40, None]
    records = [made_up("a", Task("solo", 0, seed), late) for seed, late in enumerate(alone)]
    records += [made_up("a", Task("pair", 0, seed), late, team=2) for seed, late in enumerate(together)]
    results = results_of(records, *scenarios)
    (scaling,) = team_scalings(results.scenarios)
    one, two = speed_ups(results, scaling, "a", "t99")
    assert (one.team, one.speedup.mean) == (1, 1.0)
    assert two.speedup.mean == pytest.approx(sum(alone) / (160 + BUDGET))
    assert two.speedup.low is not None
    assert two.speedup.high is not None
    assert two.speedup.low < two.speedup.mean < two.speedup.high
    assert two.censored
    assert two.per_uav().speedup.mean == pytest.approx(two.speedup.mean / 2)
    plots = scaling_plots(results, scaling, policy_styles(("a",)))
    assert [plot.title for plot in plots] == ["Speed-up to 90 %", "Speed-up to 99 %", "Efficiency to 99 %"]
    assert plots[1].guides[0].y == [1.0, 2.0]
    assert plots[1].series[0].hollow == [False, True]


def test_a_team_that_never_gets_there_has_no_speed_up() -> None:
    records = [made_up("a", Task("solo", 0, seed), 10) for seed in range(3)]
    records += [made_up("a", Task("pair", 0, seed), None, team=2) for seed in range(3)]
    results = results_of(records, room("solo"), room("pair", 2))
    (scaling,) = team_scalings(results.scenarios)
    assert speed_ups(results, scaling, "a", "t99") == []
    assert scaling_plots(results, scaling, policy_styles(("a",))) == []


def test_few_tasks_are_dots() -> None:
    records = [made_up("a", Task("solo", 0, seed), 10 + seed) for seed in range(3)]
    records += [made_up("a", Task("pair", 0, seed), 5, team=2) for seed in range(3)]
    results = results_of(records, room("solo"), room("pair", 2))
    (scaling,) = team_scalings(results.scenarios)
    _, two = speed_ups(results, scaling, "a", "t99")
    assert two.speedup.mean == pytest.approx(11 / 5)
    assert two.speedup.low is None
    assert two.each == pytest.approx([2.0, 2.2, 2.4])
