"""Panels of the page that compare policies with each other, and the scenarios of a sweep."""

from indoor_explorers.evaluation.analysis.panels.scenario_panels import ScenarioPanels, scenario_panels
from indoor_explorers.evaluation.analysis.panels.sweep_panels import sweep_sections

__all__ = ["ScenarioPanels", "scenario_panels", "sweep_sections"]
