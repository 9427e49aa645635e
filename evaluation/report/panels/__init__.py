"""Panels of the report that set policies against each other, and scenarios of a sweep beside each other."""

from indoor_explorers.evaluation.report.panels.scenario_panels import ScenarioPanels, scenario_panels
from indoor_explorers.evaluation.report.panels.sweep_panels import sweep_sections

__all__ = ["ScenarioPanels", "scenario_panels", "sweep_sections"]
