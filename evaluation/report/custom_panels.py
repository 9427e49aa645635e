"""Panels of plug-ins: sections of the page that functions of the results write."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import described
from indoor_explorers.env.plugins import load_plugin
from indoor_explorers.evaluation.harness.results.results import Results

#: The entry-point group of panels: functions that take results and return HTML.
PANELS = "indoor_explorers.panels"


@dataclass(frozen=True)
class CustomPanel:
    """A section at the end of the page."""

    title: str
    """The first line of the function's docstring."""
    body: Markup
    """HTML, as the function wrote it."""


def custom_panels(results: Results, names: Sequence[str]) -> list[CustomPanel]:
    """Return the panels of these names; each function is given the results on the tasks that all policies flew.

    Raises:
        InputError: a panel cannot be loaded, or fails.

    """
    return [_panel(results, name) for name in names]


def _panel(results: Results, name: str) -> CustomPanel:
    write = load_plugin(PANELS, name, "panel")
    if not callable(write):
        raise InputError(f"panel {name!r}: expected a function of the results, got {type(write).__name__}")
    try:
        body = write(results)
    except Exception as error:
        raise InputError(f"panel {name!r} failed: {described(error)}") from error
    if not isinstance(body, str):
        raise InputError(f"panel {name!r}: expected HTML as text, got {type(body).__name__}")
    title = (inspect.getdoc(write) or name).partition("\n")[0].rstrip(".")
    return CustomPanel(title, Markup(body))
