"""The measures of flown tracks are right, and the page on dynamics has the figures of the measured file."""

import importlib.util

import numpy as np
import pytest

from indoor_explorers.env import FREE, OCCUPIED
from indoor_explorers.evaluation.site.studies.dynamics import (
    FLIGHTS,
    HOVER,
    SEEDS,
    clearances,
    flight_table,
    measured,
    path_errors,
    touches,
)
from tests.documents import SITE

PAGE = (SITE / "pages" / "guides" / "dynamics.md").read_text("utf-8")
CORNER = np.array([[[0.5, 0.5]], [[0.5, 1.5]], [[1.5, 1.5]]])


def test_the_page_has_the_table():
    assert "\n".join(flight_table()) in PAGE


def test_every_episode_is_flown_in_every_way():
    table = measured()
    assert set(zip(table["seed"], table["flight"], strict=True)) == {(s, f) for s in SEEDS for f in [*FLIGHTS, HOVER]}
    for name, speed in FLIGHTS.items():
        if speed is not None:
            assert table[table["flight"] == name]["step_s"].to_numpy() == pytest.approx(1.25 / speed, rel=0.01)


def test_the_distance_from_a_path_is_that_from_its_nearest_part():
    position = np.array([[[0.5, 1.0]], [[0.8, 1.2]], [[1.0, 1.9]]])
    assert path_errors(CORNER, np.array([0, 0, 1]), position).ravel() == pytest.approx([0.0, 0.3, 0.4])


def test_a_uav_that_stays_is_as_far_from_its_path_as_from_its_cell():
    path = np.repeat(CORNER[:1], 4, axis=0)
    assert path_errors(path, np.array([2]), np.array([[[0.5, 0.9]]])).item() == pytest.approx(0.4)


@pytest.mark.parametrize("seed", range(3))
def test_the_clearance_is_the_distance_to_the_nearest_occupied_cell(seed):
    rng = np.random.default_rng(seed)
    truth = np.where(rng.random((6, 7)) < 0.2, OCCUPIED, FREE).astype(np.uint8)
    position = rng.uniform((0, 0), truth.shape, (40, 2, 2))
    walls = np.argwhere(np.pad(truth, 2, constant_values=OCCUPIED) == OCCUPIED) - 2
    beside = np.maximum(abs(position[..., None, :] - walls - 0.5) - 0.5, 0.0)
    expected = np.minimum(np.sqrt((beside**2).sum(axis=-1)).min(axis=-1), 1.0)
    assert clearances(truth, position) == pytest.approx(expected)


def test_a_touch_is_counted_once_however_long_it_lasts():
    clear = np.array([[0.1, 0.5], [0.1, 0.5], [0.5, 0.2], [0.2, 0.2], [0.2, 0.5]])
    assert touches(clear, 0.25) == 3


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
@pytest.mark.skipif(
    importlib.util.find_spec("PyFlyt") is None, reason="needs PyFlyt, a tool beside the tests: pip install PyFlyt"
)
def test_a_team_flies_a_path_in_pyflyt():
    from indoor_explorers.evaluation.site.studies.dynamics_pyflyt import flown

    path = np.repeat(CORNER, 2, axis=1) + np.array([[0.0, 0.0], [4.0, 0.0]])
    flight = flown(path, 2.5, seed=0)
    assert flight.seconds == pytest.approx(5.0)
    assert path_errors(path, flight.step, flight.position).max() < 0.5
