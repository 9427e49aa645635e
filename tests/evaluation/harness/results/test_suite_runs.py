"""Results of a suite are known as such, however they were flown; maps of one building count as one."""

from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.analysis.comparability import verdict_on
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.exports.scenario_tables import caption
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.combine import combined
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from tests.suites import tiny, tiny_clones

__all__ = ["tiny", "tiny_clones"]


def fly(out: Path, **options) -> Results:
    """Fly what the command would fly, and write no report."""
    request = ComparisonRequest.of(**{"policies": ["frontier-nearest"], "workers": 0} | options)
    fly_missing(plan(request), out, request)
    return Results.load(out)


def test_a_suite_flown_whole_says_so(tiny: Path, tmp_path: Path):
    whole = fly(tmp_path, suite="tiny", data=tiny)
    assert whole.suite_notes == ["suite tiny 3, test part: complete"]
    page = render(whole, replays=0)
    assert "<span>suite tiny 3, test part</span><span>complete</span>" in page
    assert "Intervals and tests count maps of one building as one, as they are alike: 3 maps of 2 buildings." in page
    assert "Intervals of tiny-1, tiny-2-none, tiny-2-disc hold for their 3 maps alone" in page
    alone = Comparison(whole, "tiny-1")
    assert alone.maps("frontier-nearest").tolist() == ["tiny: A"] * 4 + ["tiny: B"] * 2
    assert (alone.map_count, alone.unit_count) == (3, 2)
    told = caption(alone)
    assert told[0] == "6 episodes of each policy on 3 maps of 2 buildings; suite tiny 3, test part, complete."


def test_maps_of_one_layout_count_as_one(tmp_path: Path):
    free = np.zeros((9, 14), np.bool_)
    free[1:4, 1:12] = free[1:8, 9:12] = True
    other = free.copy()
    other[6, 2:10] = True
    for name, mask in {"plan": free, "turned": np.rot90(free), "mirrored": free[:, ::-1], "other": other}.items():
        np.save(tmp_path / f"{name}.npy", np.where(mask, 0, 100).astype(np.int8))
    files = [str(tmp_path / f"{name}.npy") for name in ("plan", "turned", "other", "mirrored")]
    results = fly(tmp_path / "out", maps=files, episodes=2)
    flown = Comparison(results, *results.scenarios)
    labels = flown.maps("frontier-nearest").tolist()
    assert [labels.index(label) for label in labels] == [0, 0, 0, 0, 4, 4, 0, 0]
    assert (flown.map_count, flown.unit_count, flown.maps_flown) == (4, 2, "4 maps of 2 layouts")
    page = render(results, replays=0)
    assert "Intervals and tests count maps of one layout as one, as they are alike: 4 maps of 2 layouts." in page


def test_a_part_of_a_suite_says_how_much_it_is(tiny: Path, tmp_path: Path):
    some = fly(tmp_path / "a", suite="tiny", data=tiny, team=1, maps=["A"])
    assert some.suite_notes == ["suite tiny 3, test part: a subset of it: 4 of 18 tasks, in 1 of 3 scenarios"]
    files = [str(tiny / "floors" / f"{name}.npy") for name in ("a2", "b")]
    with_maps = {"maps": files, "resolution": 1.0, "settings": {"lidar.range": 4.0}, "seed": 32_000_001, "episodes": 1}
    assert fly(tmp_path / "b", **with_maps).suite_notes == [
        "suite tiny 3, test part: a subset of it: 2 of 18 tasks, in 1 of 3 scenarios"
    ]


RAISED = {"settings": {"lidar.range": 4.0, "map.least_levels": 2}}


@pytest.mark.parametrize("change", [{"seed": 32_000_002}, {"settings": {}}, {"resolution": 2.0}, RAISED])
def test_other_tasks_on_its_maps_are_no_suite(tiny: Path, tmp_path: Path, change):
    files = [str(tiny / "floors" / "a1.npy")]
    as_there = {"maps": files, "resolution": 1.0, "settings": {"lidar.range": 4.0}, "seed": 32_000_000, "episodes": 1}
    assert fly(tmp_path, **as_there | change).suite_notes == []


def test_folders_of_one_suite_combine(tiny: Path, tmp_path: Path):
    one = fly(tmp_path / "one", suite="tiny", data=tiny, team=1)
    two = fly(tmp_path / "two", suite="tiny", data=tiny, team=2)
    whole = combined([one, two])
    assert whole.suite_notes == ["suite tiny 3, test part: complete"]
    other = fly(tmp_path / "other", suite="tiny", data=tiny, policies=["random"])
    assert combined([whole, other]).suite_notes == whole.suite_notes
    assert "a subset of it: 6 of 18 tasks, in 1 of 3 scenarios" in str(combined([one, other]).suite_notes)
    with pytest.raises(InputError, match="scenario 'tiny-1' is not the same task"):
        combined([one, fly(tmp_path / "less", suite="tiny", data=tiny, team=1, maps=["B"])])


def test_a_generated_suite_is_known_by_its_seeds(tmp_path: Path):
    some = fly(tmp_path, suite="rooms", part="validation", team=1, episodes=3)
    assert some.suite_notes == ["suite rooms 1, validation part: a subset of it: 3 of 700 tasks, in 1 of 7 scenarios"]
    assert len(np.unique(some.maps("rooms-1", "frontier-nearest"))) == 3


def test_maps_that_a_policy_has_seen_are_warned_of(tiny: Path, tmp_path: Path):
    flown = fly(tmp_path, suite="tiny", data=tiny, team=1)
    seen = [record.floorplan.digest for record in flown.records][:3]
    flown.policies["frontier-nearest"]["seen_maps"] = {"training": [*seen, "of no map here"], "validation": seen[:1]}
    assert flown.map_notes == [
        "maps seen before (frontier-nearest: trained on 2 of 3, a1, a2): such figures may be optimistic"
    ]
    verdict = verdict_on(flown)
    assert (
        "Maps seen before (frontier-nearest: trained on 2 of 3, a1, a2): such figures may be optimistic."
        in verdict.warnings
    )
    assert not verdict.fine


def test_a_map_that_a_policy_has_seen_in_a_mirror_is_warned_of(tiny: Path, tmp_path: Path):
    flown = fly(tmp_path, suite="tiny", data=tiny, team=1)
    plan = next(record.floorplan for record in flown.records if record.floorplan.name == "a1")
    mirrored = Floorplan.from_free(plan.truth[:, ::-1] == FREE, "mirrored")
    assert mirrored.digest != plan.digest
    flown.policies["frontier-nearest"]["seen_maps"] = {"tuning": [mirrored.digest, mirrored.layout]}
    assert flown.map_notes == [
        "maps seen before (frontier-nearest: developed on 1 of 3, a1): such figures may be optimistic"
    ]
