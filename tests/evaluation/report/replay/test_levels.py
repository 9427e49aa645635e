"""Replays and lines of the report about maps of several levels."""

import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.report import page as report_page
from indoor_explorers.evaluation.report import write_report
from indoor_explorers.evaluation.report.replay.packed_episode import resimulated
from indoor_explorers.evaluation.report.replay.selection import replay_data
from tests.evaluation.report.replay.test_replay import results_of

TALL = PRESETS["small-storeys"].for_evaluation().with_settings({"budget": 12, "base.at": "start", "base.radius": 1.5})
FLAT = PRESETS["thesis-team-4"].for_evaluation().with_settings({"budget": 12})


@pytest.fixture(scope="module")
def results():
    return results_of(TALL, seeds=2)


def episodes_of(results, scenario):
    comparison = Comparison(results, scenario.name)
    return replay_data(comparison, policy_styles(list(comparison.groups)), 10**7)["episodes"]


def test_episodes_say_how_many_levels_only_where_there_are_some(results):
    assert {each["levels"] for each in episodes_of(results, TALL)} == {7}
    plain = episodes_of(results_of(FLAT, seeds=1), FLAT)
    assert plain
    assert all("levels" not in each for each in plain)


def test_the_base_is_linked_to_the_nearest_uav_in_three_dimensions(results):
    for record in results.records[:2]:
        flight = resimulated(record, TALL)
        apart = record.floorplan.levels.voxels(record.cells[:, :, :]) - record.floorplan.levels.voxel(flight.base)
        near, leads = (apart**2).sum(axis=2), flight.linked[:, :-1, -1]
        assert leads.any()
        for step in range(record.steps + 1):
            if leads[step].sum() == 1 and flight.linked[step, 0, 1]:
                assert near[step, leads[step].argmax()] == near[step].min()


def test_the_report_counts_levels_and_says_what_its_replay_shows(results, tmp_path):
    write_report(results, tmp_path / "tall.html")
    page = (tmp_path / "tall.html").read_text()
    assert "7 levels of 24 by 24 cells" in page
    assert "Levels lie beside each other" in page
    write_report(results_of(FLAT, seeds=1), tmp_path / "flat.html")
    assert "Levels lie beside" not in (tmp_path / "flat.html").read_text()


#: What only pages with levels have: bytes at most, and names of the files.
MOST = 620_000
OF_LEVELS = ("three.min.js", "replay_space", "replay_voxels", "replay_scene", "replay_orbit")


def test_only_pages_with_levels_carry_what_draws_them_in_three_dimensions(results, monkeypatch):
    taken = []

    def noted(name):
        taken.append(name)
        return report_page._raw(name)

    monkeypatch.setitem(report_page._environment().globals, "include_raw", noted)
    pages = {}
    for name, found in (("flat", results_of(FLAT, seeds=1)), ("tall", results)):
        taken.clear()
        text = report_page.render(found)
        pages[name] = {part for part in taken if any(each in part for each in OF_LEVELS)}
        assert ("THREE" in text) == (name == "tall")
    assert pages["flat"] == set()
    assert len(pages["tall"]) == 7
    sizes = [len(report_page._raw(name)) for name in pages["tall"]]
    assert sum(sizes) < MOST
