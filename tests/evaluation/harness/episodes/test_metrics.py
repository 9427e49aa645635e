"""Metrics by their definitions."""

import numpy as np
import pytest

from indoor_explorers.evaluation.harness.episodes.metrics import (
    LEVELS,
    MEASURES,
    area_under_curve,
    curve_metrics,
    extended,
    first_step,
)


def test_first_step_is_at_or_above_the_level():
    curve = np.array([0.1, 0.5, 0.9, 0.9, 1.0])
    assert [first_step(curve, q) for q in (0.05, 0.5, 0.9, 0.95)] == [0, 1, 2, 4]
    assert first_step(curve[:3], 0.95) is None


def test_a_level_is_reached_in_spite_of_rounding():
    covered = np.array([89, 90]) / 100
    assert first_step(covered, 0.9) == 1
    assert first_step(np.array([297 / 300]), 0.99) == 0


def test_area_is_trapezoids_and_constant_after_the_end():
    assert area_under_curve(np.array([0.0, 1.0]), 1) == pytest.approx(0.5)
    assert area_under_curve(np.array([0.0, 1.0]), 10) == pytest.approx(0.95)
    assert area_under_curve(np.full(11, 0.3), 10) == pytest.approx(0.3)


def test_extended_cuts_and_continues():
    assert extended(np.array([1.0, 2.0]), 4).tolist() == [1, 2, 2, 2]
    assert extended(np.array([1.0, 2.0, 3.0]), 2).tolist() == [1, 2]


def test_every_metric_of_a_curve_is_defined():
    metrics = curve_metrics(np.linspace(0, 1, 101), 200)
    assert metrics == {"auc": pytest.approx(0.75), "t50": 50, "t90": 90, "t95": 95, "t98": 98, "t99": 99}
    assert set(metrics) <= set(MEASURES)
    assert [MEASURES[name].title for name in LEVELS] == ["T50", "T90", "T95", "T98", "T99"]
