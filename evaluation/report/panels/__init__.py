"""Panels of the report that set policies against each other, and scenarios of a sweep beside each other."""

from indoor_explorers.evaluation.report.panels.section import SectionPanels, section_panels
from indoor_explorers.evaluation.report.panels.sweeping import sweep_sections

__all__ = ["SectionPanels", "section_panels", "sweep_sections"]
