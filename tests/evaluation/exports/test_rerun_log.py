"""Recordings for Rerun, read back."""

import sys

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.evaluation.cli.watch import WatchedFlight
from indoor_explorers.evaluation.exports.rerun_log import places
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from tests.evaluation.cli.test_cli import run

STEPS = 6


def rows_of(path):
    """Return what is logged, by entity path: a list of (step, fields), in the order of the steps."""
    chunks = pytest.importorskip("rerun.chunk")
    found = {}
    for chunk in chunks.RrdReader(str(path)).stream():
        if not chunk.is_static:
            for row in chunk.to_record_batch().to_pylist():
                found.setdefault(chunk.entity_path.strip("/"), []).append((row["step"], row))
    return {name: sorted(rows, key=lambda row: row[0]) for name, rows in found.items()}


@pytest.mark.parametrize("scenario", ["small-storeys", "thesis-team-2"])
def test_a_recording_has_maps_poses_and_trails_of_each_step(capsys, tmp_path, scenario):
    path, policy = tmp_path / "new" / "flight.rrd", "frontier-nearest"
    words = ["watch", "--policy", policy, "--scenario", scenario, "--steps", STEPS, "--rerun", path]
    pytest.importorskip("rerun")
    status, printed, errors = run(capsys, *words)
    assert (status, errors) == (0, "")
    assert f"Saved: {path}" in printed
    rows = rows_of(path)
    flight = WatchedFlight(plan(ComparisonRequest(policies=[policy], scenario=scenario, episodes=1)), 0, STEPS)
    trail = []
    for _ in flight.moments():
        state, step = flight.world.state, flight.step
        levels = flight.world.briefing(0, 0).levels
        trail.append(places(state.cell[0], levels))
        for name, belief in (("team", state.union[0]), ("uav-1", flight.world.view(0, 1).belief)):
            shown = [row for when, row in rows[f"{policy}/maps/{name}/obstacles"] if when <= step][-1]
            expected = places(np.argwhere((belief == OCCUPIED) & ~levels.between), levels)
            np.testing.assert_array_equal(np.reshape(shown["Boxes3D:centers"], (-1, 3)), expected)
        (pose,) = [row for when, row in rows[f"{policy}/uavs/1"] if when == step]
        np.testing.assert_array_equal(pose["Points3D:positions"], trail[-1][1:2])
        (line,) = [row for when, row in rows[f"{policy}/uavs/1/trail"] if when == step]
        np.testing.assert_array_equal(line["LineStrips3D:strips"][0], [each[1] for each in trail])
        (covered,) = [row for when, row in rows[f"{policy}/coverage"] if when == step]
        assert covered["Scalars:scalars"] == [flight.coverage[-1]]
    assert step == STEPS


def test_a_level_higher_is_higher_and_a_row_further_is_behind():
    levels = Levels(3, 4, 5)
    assert places(np.array([levels.cell((2, 1, 3))]), levels).tolist() == [[3.0, -1.0, 2.0]]
    plain = World(PRESETS["thesis-team-2"]).scenario.map.level_count
    assert places(np.array([[2, 7]]), Levels(plain, 20, 20)).tolist() == [[7.0, -2.0, 0.0]]


WATCH = ["watch", "--policy", "frontier-nearest", "--scenario", "thesis-team-2"]


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--rerun", "film.gif"], "expected a file *.rrd to record in, got 'film.gif'; --rerun alone opens a viewer"),
        (["--rerun", "a.rrd", "--save", "a.gif"], "expected --rerun without --save, which is about pictures"),
        (["--rerun", "a.rrd", "--explain", "0"], "expected --rerun without --explain, which is about pictures"),
    ],
)
def test_what_does_not_go_with_it_is_refused(capsys, words, line):
    status, printed, errors = run(capsys, *WATCH, *words)
    assert (status, printed) == (2, "")
    assert line in errors


def test_a_missing_extra_is_said_in_a_line(capsys, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "rerun", None)
    status, printed, errors = run(capsys, *WATCH, "--rerun", tmp_path / "a.rrd")
    assert (status, printed) == (2, "")
    assert errors == "indoor-explorers: rerun-sdk is not installed; pip install 'indoor-explorers[rerun]'\n"


def test_without_a_file_the_viewer_is_started(capsys, monkeypatch):
    rerun, started = pytest.importorskip("rerun"), []
    monkeypatch.setattr(rerun, "spawn", lambda **about: started.append(about["recording"]))
    status, printed, errors = run(capsys, *WATCH, "--steps", "1", "--rerun")
    assert (status, errors, len(started)) == (0, "", 1)
    assert "Saved" not in printed
    assert "step 1 of 400, coverage" in printed
