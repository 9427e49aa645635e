"""Small drawings inside tables, as inline SVG in the colours of the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import with_interval
from indoor_explorers.evaluation.drawing.palette import DASHES, MARKER_PATHS, PolicyStyle
from indoor_explorers.evaluation.statistics import Estimate

#: Limit of dots in a plot; more episodes are reduced to this number of quantiles.
DOTS = 80


class Scale(NamedTuple):
    """A linear scale from ``low``..``high`` to ``width`` pixels; values beyond are drawn at the edge."""

    low: float
    high: float
    width: int

    def __call__(self, value: float) -> float:
        """Return the place of a value in pixels."""
        span = (self.high - self.low) or 1.0
        share = min(max((value - self.low) / span, 0.0), 1.0)
        return round(4 + share * (self.width - 8), 1)


def swatch(style: PolicyStyle) -> Markup:
    """Draw a policy's line and marker, as in the charts."""
    dash = " ".join(f"{length:g}" for length in DASHES[style.dash]) or "none"
    return Markup(
        '<svg class="swatch" width="28" height="10" viewBox="0 0 28 10" aria-hidden="true">'
        '<g style="color:{}"><path d="M0 5h28" stroke="currentColor" stroke-width="2" stroke-dasharray="{}"/>'
        '<path transform="translate(14 5)" d="{}" fill="currentColor"/></g></svg>'
    ).format(style.variable, dash, MARKER_PATHS[style.marker])


def _drawing(scale: Scale, body: Markup, label: str) -> Markup:
    return Markup(
        '<svg class="dot-plot" width="{w}" height="20" viewBox="0 0 {w} 20" role="img" aria-label="{label}">'
        "<title>{label}</title>{body}</svg>"
    ).format(w=scale.width, label=label, body=body)


def _dots(values: NDArray[np.float64], scale: Scale, y: float) -> Markup:
    if len(values) > DOTS:
        values = np.quantile(values, (np.arange(DOTS) + 0.5) / DOTS)
    dot = Markup('<circle class="dot" cx="{}" cy="{}" r="2"/>')
    return Markup("").join(dot.format(scale(value), y) for value in sorted(values.tolist()))


def _mean_and_interval(estimate: Estimate, scale: Scale, y: float) -> Markup:
    line = Markup("")
    if estimate.low is not None and estimate.high is not None:
        line = Markup('<path class="range" d="M{} {y}H{}"/>').format(scale(estimate.low), scale(estimate.high), y=y)
    return line + Markup('<circle class="mean" cx="{}" cy="{}" r="3.2"/>').format(scale(estimate.mean), y)


def _arrowhead(estimate: Estimate, scale: Scale, y: float) -> Markup:
    """Draw an arrowhead at the right edge for a mean beyond it; empty for others."""
    if estimate.mean <= scale.high:
        return Markup("")
    return Markup('<path class="beyond" d="M{} {}l7 5-7 5z"/>').format(scale.width - 8, y - 5)


def episode_dot_plot(values: NDArray[np.float64], estimate: Estimate, scale: Scale, style: PolicyStyle) -> Markup:
    """Draw every episode as a dot, above them the mean with its interval; an arrowhead for a mean beyond the scale."""
    if not len(values):
        return Markup("")
    mark = _arrowhead(estimate, scale, 6) or _mean_and_interval(estimate, scale, 6)
    body = Markup('<g style="color:{}"><path class="axis" d="M4 14.5H{}"/>{}{}</g>').format(
        style.variable, scale.width - 4, _dots(values, scale, 14.5), mark
    )
    listed = ", ".join(f"{value:g}" for value in values.tolist()) if len(values) <= 10 else f"{len(values)} episodes"
    return _drawing(scale, body, f"{listed}; mean {with_interval(estimate)}")


def interval_plot(estimate: Estimate, scale: Scale, style: PolicyStyle) -> Markup:
    """Draw a mean with its interval; an arrowhead for a mean beyond the scale."""
    mark = _arrowhead(estimate, scale, 10) or _mean_and_interval(estimate, scale, 10)
    body = Markup('<g style="color:{}"><path class="axis" d="M4 10H{}"/>{}</g>').format(
        style.variable, scale.width - 4, mark
    )
    return _drawing(scale, body, with_interval(estimate))


def difference_dot_plot(values: NDArray[np.float64], estimate: Estimate, scale: Scale, style: PolicyStyle) -> Markup:
    """Draw a difference with its interval beside a line at 0; without an interval, a dot for each of (E,) episodes."""
    zero = Markup('<path class="zero" d="M{} 0V20"/>').format(scale(0.0))
    dots = Markup("") if estimate.low is not None else _dots(values, scale, 10)
    mark = _arrowhead(estimate, scale, 10) or _mean_and_interval(estimate, scale, 10)
    body = zero + Markup('<g style="color:{}">{}{}</g>').format(style.variable, dots, mark)
    return _drawing(scale, body, f"difference {with_interval(estimate, sign=True)} steps")


def difference_scale(estimates: Sequence[Estimate], width: int = 200) -> Scale:
    """Return a scale for differences whose range one very slow policy does not determine."""
    ends = [max(abs(end) for end in (each.low, each.high, each.mean) if end is not None) for each in estimates]
    reach = max(1.0, min(max(ends, default=1.0), 4 * float(np.median(ends)) if ends else 1.0))
    lows = [each.mean if each.low is None else each.low for each in estimates]
    return Scale(-min(reach, max(0.12 * reach, -1.1 * min(lows, default=0.0))), reach * 1.05, width)


def share_dot_plot(
    scores: NDArray[np.float64], estimate: Estimate, style: PolicyStyle, label: str, width: int = 150
) -> Markup:
    """Draw a share from 0 to 1 with its interval and a line at one half; without an interval, a dot for each score."""
    scale = Scale(0.0, 1.0, width)
    half = Markup('<path class="axis" d="M4 10H{}"/><path class="zero" d="M{} 0V20"/>').format(width - 4, scale(0.5))
    dots = Markup("") if estimate.low is not None else _dots(scores, scale, 10)
    mark = _mean_and_interval(estimate, scale, 10)
    return _drawing(scale, half + Markup('<g style="color:{}">{}{}</g>').format(style.variable, dots, mark), label)
