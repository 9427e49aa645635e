"""Experiments, their results and reports.

Names are imported when they are first used: worker processes do not need tables and statistics, and the command line
answers Ctrl-C from its first moment.
"""

from __future__ import annotations

TYPE_CHECKING = False  # typing takes a while to import
if TYPE_CHECKING:
    from typing import Any

    from indoor_explorers.evaluation.comparing import compare
    from indoor_explorers.evaluation.engines.local import fly_job
    from indoor_explorers.evaluation.engines.workload import missing_jobs
    from indoor_explorers.evaluation.episodes.record import Record
    from indoor_explorers.evaluation.experiment.experiment import Experiment
    from indoor_explorers.evaluation.experiment.planning import plan
    from indoor_explorers.evaluation.experiment.policy_facts import policy_facts
    from indoor_explorers.evaluation.experiment.request import ComparisonRequest
    from indoor_explorers.evaluation.experiment.selection import DEFAULT_POLICIES
    from indoor_explorers.evaluation.exports.episodes.export import export_episode
    from indoor_explorers.evaluation.results.custom_metrics import Metric
    from indoor_explorers.evaluation.results.results import Results
    from indoor_explorers.evaluation.results.store import Store

__all__ = [
    "DEFAULT_POLICIES",
    "ComparisonRequest",
    "Experiment",
    "Metric",
    "Record",
    "Results",
    "Store",
    "compare",
    "export_episode",
    "fly_job",
    "missing_jobs",
    "plan",
    "policy_facts",
]

_MODULES = {
    "comparing": ("compare",),
    "experiment.policy_facts": ("policy_facts",),
    "engines.local": ("fly_job",),
    "engines.workload": ("missing_jobs",),
    "experiment.experiment": ("Experiment",),
    "experiment.planning": ("plan",),
    "experiment.request": ("ComparisonRequest",),
    "experiment.selection": ("DEFAULT_POLICIES",),
    "episodes.record": ("Record",),
    "exports.episodes.export": ("export_episode",),
    "results.custom_metrics": ("Metric",),
    "results.results": ("Results",),
    "results.store": ("Store",),
}


def __getattr__(name: str) -> Any:
    from indoor_explorers.env.lazy_names import lazy_names

    return lazy_names(__name__, _MODULES)(name)
