"""Results of flights on maps of several levels."""

import numpy as np
import pytest

from indoor_explorers.env.scenarios.presets import scenario
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.episodes.resimulate import ended_as_recorded, resimulate
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.rows import floorplan_of, floorplan_row

TASK = scenario("small-storeys")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """One episode each of a planner that changes levels and of one that does not."""
    out = tmp_path_factory.mktemp("levels")
    names = ("--policies", "frontier-nearest,random", "--scenario", "small-storeys", "--episodes", "1")
    assert main(["compare", *names, "--workers", "1", "--set", "budget=400", "--out", str(out)]) == 0
    return Results.load(out)


def test_a_stored_map_is_read_back_with_its_levels():
    plan = draw_floorplan(TASK, 1)
    again = floorplan_of(floorplan_row(plan))
    assert again.levels == plan.levels
    assert again.digest == plan.digest
    np.testing.assert_array_equal(again.truth, plan.truth)


@pytest.mark.parametrize("count", [7, 8, 12])
def test_a_stored_map_with_added_levels_is_read_back_with_the_digest_of_its_source(count):
    plan = draw_floorplan(TASK, 1)
    again = floorplan_of(floorplan_row(plan.raised(count)))
    assert (again.level_count, again.added, again.digest) == (count, count - 7, plan.digest)


def test_a_stored_map_whose_height_is_wrong_is_refused():
    row = list(floorplan_row(draw_floorplan(TASK, 1)))
    row[2] += 1
    with pytest.raises(ValueError, match=r"its cells are not those of its hash|levels of equal height"):
        floorplan_of(tuple(row))


def test_recorded_flights_are_simulated_again_to_the_same_end(results):
    for record in results.records:
        assert record.floorplan.level_count == 7
        *_, last = resimulate(record, results.scenario(record.task.scenario))
        assert ended_as_recorded(record, last)
    assert max(int(record.actions.max()) for record in results.records) > 4


def test_lower_bounds_hold_and_are_worth_something(results):
    nearest = next(record for record in results.records if record.policy == "frontier-nearest")
    assert 1.0 <= nearest.metrics["t99_to_bound"] < 4.0


def test_another_number_of_levels_is_refused_in_a_folder_and_beside_it(tmp_path, capsys):
    np.save(tmp_path / "two.npy", np.zeros((2, 6, 7), np.bool_))
    words = ["--maps", str(tmp_path / "two.npy"), "--policies", "random", "--episodes", "1", "--workers", "0"]

    def flown(out, *more):
        status = main(["compare", *words, *more, "--out", str(tmp_path / out)])
        return status, capsys.readouterr().err

    more = ("--set", "map.least_levels=4")
    assert (flown("a")[0], flown("b", *more)[0]) == (0, 0)
    before = (tmp_path / "a" / "results.db").read_bytes()
    status, told = flown("a", *more)
    assert (status, told.count("\n")) == (2, 1)
    assert "what differs: levels of scenario 'two' (2 there, 4 here: omit or set map.least_levels); choose" in told
    assert (tmp_path / "a" / "results.db").read_bytes() == before
    assert main(["report", *(str(tmp_path / out) for out in "ab"), "--out", str(tmp_path / "both.html")]) == 2
    assert "what differs: map.levels (2 and 4)" in capsys.readouterr().err
    assert flown("a", *more, "--fresh")[0] == 0


def test_a_map_with_two_numbers_of_levels_in_one_comparison_is_refused_before_anything_is_flown(tmp_path, capsys):
    np.save(tmp_path / "two.npy", np.zeros((2, 6, 7), np.bool_))
    for name, least in (("low", 1), ("high", 4)):
        task = TASK.with_settings({"map.source": "files", "map.paths": [str(tmp_path / "two.npy")], "name": name})
        (tmp_path / f"{name}.toml").write_text(task.with_settings({"map.least_levels": least}).to_toml())
    words = ["--scenario", f"{tmp_path / 'low.toml'},{tmp_path / 'high.toml'}", "--out", str(tmp_path / "out")]
    assert main(["compare", "--policies", "random", "--episodes", "1", "--workers", "0", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "scenario 'high': expected map 'two' with 2 levels, as in another one, got 4; set map.least_levels" in line
    assert not (tmp_path / "out").exists()
