"""The pictures of sensors and poses with errors show what the page says."""

import numpy as np

from indoor_explorers.env import UNKNOWN
from indoor_explorers.evaluation.site.pictures.sensor_errors import FALSE_FREE, FALSE_OBSTACLE, FLIGHTS, flown


def test_loop_closure_makes_the_drawn_map_better_and_the_exact_one_is_right():
    wrong = {}
    for title, settings in FLIGHTS.items():
        codes = flown(settings).codes
        wrong[title] = np.isin(codes, (FALSE_OBSTACLE, FALSE_FREE)).sum() / (codes != UNKNOWN).sum()
    assert wrong["exact"] == 0.0
    assert 0.0 < wrong["drift, loop closure"] < wrong["drift"] / 2
