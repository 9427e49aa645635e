"""The font of figures for print."""

import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font

from indoor_explorers.env.grid.compile_cache import cache_folder
from indoor_explorers.evaluation.drawing import fonts

TEXT = "T90 [95 %] of a café, naïve Ω ≤ μ·τ → “Жук” AVATAR fjord"


def picture(family, weight, text):
    """The pixels of a text."""
    with mpl.rc_context({"font.family": family}):
        figure = Figure(figsize=(6, 1))
        canvas = FigureCanvasAgg(figure)
        figure.text(0.02, 0.4, text, weight=weight)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())


@pytest.mark.parametrize("weight", ["normal", "bold"])
@pytest.mark.parametrize("text", [TEXT, f"{TEXT} \u2713"])
def test_text_looks_as_in_the_whole_font(weight, text):
    np.testing.assert_array_equal(
        picture(fonts.families(), weight, text), picture([fonts.FAMILY], weight, text), strict=True
    )


@pytest.mark.parametrize("weight", ["normal", "bold"])
def test_it_is_small(weight):
    reduced, whole = (
        get_font(findfont(FontProperties(family=family, weight=weight), fallback_to_default=False))
        for family in fonts.families()
    )
    assert reduced.num_glyphs < whole.num_glyphs / 3
    assert reduced.postscript_name == whole.postscript_name


def test_no_temporary_folder_is_made(monkeypatch):
    monkeypatch.setattr(tempfile, "mkdtemp", None)
    fonts.families.cache_clear()
    for _ in range(2):
        reduced, _ = fonts.families()
        assert Path(findfont(reduced)).is_relative_to(cache_folder())


def test_where_nothing_can_be_kept_the_whole_font_is_used(monkeypatch):
    monkeypatch.setattr(fonts, "cache_folder", lambda: None)
    assert fonts.families.__wrapped__() == [fonts.FAMILY]
