"""Performance profiles: on how many tasks a policy is within a factor of the best one (Dolan & More 2002)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.panels.plot_data import Plot, PlotAxis, PlotSeries
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.formatting import percent
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles
from indoor_explorers.evaluation.statistics import performance_profile, performance_ratios

#: Limit of steps in the line of a policy; more tasks are reduced to this number.
STAIRS = 300


def profile_plot(task_times: TaskTimes, styles: Styles, far: Sequence[str] = ()) -> Plot | None:
    """Return the profiles over the tasks that all ranked policies flew; None when there is nothing to compare.

    The range leaves out what policies ``far`` behind solve at last.
    """
    common = task_times.common()
    if len(common.policies) < 2 or not common.reached.any():
        return None
    ratios = performance_ratios(np.where(common.reached, common.times, np.nan))
    near = ratios[:, [name not in far for name in common.policies]]
    end = max(1.2, 1.05 * float(near[np.isfinite(near)].max(initial=1.0)))
    tau, share = performance_profile(ratios)
    tau, share = tau[tau <= end], share[tau <= end]
    over = f"τ, multiple of the best policy's {common.level.title}"
    return Plot(
        title="Performance profile",
        label="Share of tasks on which each policy needs at most tau times the steps of the best one",
        x=PlotAxis(title=over, low=1.0, high=end, log=True, ticks=_ticks(end)),
        y=PlotAxis(title="share of tasks", low=0.0, high=1.03, share=True),
        series=[_stairs(name, styles[name], tau, share[:, column], end) for column, name in enumerate(common.policies)],
    )


def _stairs(
    name: str, style: PolicyStyle, tau: NDArray[np.float64], share: NDArray[np.float64], end: float
) -> PlotSeries:
    """Return the line of (T,) shares against (T,) factors ``tau``: the places where it rises, and the right edge."""
    rises = np.flatnonzero(np.diff(share, prepend=-1.0) > 0)
    if len(rises) > STAIRS:
        rises = rises[np.linspace(0, len(rises) - 1, STAIRS).round().astype(np.int64)]
    x, y = [*tau[rises].tolist(), end], [*share[rises].tolist(), float(share[-1])]
    text = [f"τ {at:.2f}: {percent(part)}" for at, part in zip(x, y, strict=True)]
    return PlotSeries(name=name, style=style, x=x, y=y, text=text, step=True)


def _ticks(end: float) -> tuple[tuple[float, str], ...]:
    places = (1, 1.1, 1.25, 1.5, 2, 3, 5, 10, 20, 50, 100) if end < 3 else (1, 1.5, 2, 3, 5, 10, 20, 50, 100)
    return tuple((float(place), f"{place:g}") for place in places if place <= end)
