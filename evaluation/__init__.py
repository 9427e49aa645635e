"""Experiments, their results and reports.

Names are imported when they are first used: worker processes do not need tables and statistics, and the command line
answers Ctrl-C from its first moment.
"""

from __future__ import annotations

TYPE_CHECKING = False  # typing takes a while to import
if TYPE_CHECKING:
    from typing import Any

    from indoor_explorers.evaluation.comparing import compare
    from indoor_explorers.evaluation.exports.episodes.export import export_episode
    from indoor_explorers.evaluation.harness.engines.local import fly_job
    from indoor_explorers.evaluation.harness.engines.workload import missing_jobs
    from indoor_explorers.evaluation.harness.episodes.record import Record
    from indoor_explorers.evaluation.harness.experiment.experiment import Experiment
    from indoor_explorers.evaluation.harness.experiment.planning import plan
    from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
    from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
    from indoor_explorers.evaluation.harness.experiment.selection import DEFAULT_POLICIES
    from indoor_explorers.evaluation.harness.results.custom_metrics import Metric
    from indoor_explorers.evaluation.harness.results.results import Results
    from indoor_explorers.evaluation.harness.results.store import Store

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
    "harness.experiment.policy_facts": ("policy_facts",),
    "harness.engines.local": ("fly_job",),
    "harness.engines.workload": ("missing_jobs",),
    "harness.experiment.experiment": ("Experiment",),
    "harness.experiment.planning": ("plan",),
    "harness.experiment.request": ("ComparisonRequest",),
    "harness.experiment.selection": ("DEFAULT_POLICIES",),
    "harness.episodes.record": ("Record",),
    "exports.episodes.export": ("export_episode",),
    "harness.results.custom_metrics": ("Metric",),
    "harness.results.results": ("Results",),
    "harness.results.store": ("Store",),
}


def __getattr__(name: str) -> Any:
    from indoor_explorers.env.lazy_names import lazy_names

    return lazy_names(__name__, _MODULES)(name)
