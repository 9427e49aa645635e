"""The pictures of sensors and poses that err are those of the page, and show what it says."""

import re
from pathlib import Path

import numpy as np

from indoor_explorers.env import UNKNOWN
from indoor_explorers.evaluation.site.pictures import sensor_errors
from indoor_explorers.evaluation.site.pictures.sensor_errors import FALSE_FREE, FALSE_OBSTACLE, FLIGHTS, flown

PAGE = Path(sensor_errors.__file__).parents[1] / "pages" / "harder-tasks.md"


def test_the_page_shows_every_picture_and_all_are_svg(monkeypatch):
    monkeypatch.setattr(sensor_errors, "STEPS", 40)
    pictures = sensor_errors.sensor_error_pictures()
    assert re.findall(r"\(gallery/(errors-.+?)\)", PAGE.read_text("utf-8")) == list(pictures)
    assert all(picture.lstrip().startswith(b"<?xml") and b"<svg" in picture for picture in pictures.values())


def test_loop_closure_makes_the_drawn_map_better_and_the_exact_one_is_right():
    wrong = {}
    for title, settings in FLIGHTS.items():
        codes = flown(settings).codes
        wrong[title] = np.isin(codes, (FALSE_OBSTACLE, FALSE_FREE)).sum() / (codes != UNKNOWN).sum()
    assert wrong["exact"] == 0.0
    assert 0.0 < wrong["drift, loop closure"] < wrong["drift"] / 2
