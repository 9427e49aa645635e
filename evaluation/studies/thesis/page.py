"""The page about the thesis's experiments: one HTML file that needs nothing else."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.drawing.formatting import percent
from indoor_explorers.evaluation.studies.thesis.experiments import GROUPS, ThesisExperiment
from indoor_explorers.evaluation.studies.thesis.results import Run

#: The figures of a group with their captions.
FIGURES = {
    "scores": "The thesis's training curve: the first UAV's rewards summed over each episode, random moves included; "
    "black, its moving average over ten episodes or a hundredth of the training.",
    "coverage": "Left, as the thesis plots it: training episodes, which are left out of the mean once they have ended. "
    "Right, greedy episodes on maps not used in training; an episode that has ended keeps its coverage.",
    "greedy": "The network without random moves, for all UAVs, on maps not used in training.",
}


def write_page(runs: Sequence[Run], config: Any, folder: Path, path: Path) -> None:
    """Write the page with the figures of ``folder``; ``config`` is the class of the learner's settings."""
    environment = Environment(
        loader=PackageLoader("indoor_explorers.evaluation.studies.thesis", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["percent"] = lambda share: percent(share, 0)
    text = environment.get_template("page.html").render(
        experiments=_rows(runs),
        groups=[group for group in GROUPS.items() if any(run.experiment.group == group[0] for run in runs)],
        figures=FIGURES,
        picture=lambda stem: _embedded(folder / f"{stem}.png"),
        switches=_switches(runs, config),
        facts=runs[0].record,
    )
    with written_whole(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")


def _rows(runs: Sequence[Run]) -> list[tuple[ThesisExperiment, list[dict[str, Any]]]]:
    """Return the experiments, each once, with the rows of their versions."""
    experiments = list(dict.fromkeys(run.experiment for run in runs))
    return [(one, [run.row() for run in runs if run.experiment == one]) for one in experiments]


def _embedded(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")


def _switches(runs: Sequence[Run], config: Any) -> list[tuple[str, Any, str]]:
    """Return name, the thesis's value and the explanation of every setting that differs between the versions."""
    configs = [run.record["config"] for run in runs]
    own = {"episodes", "initial_weights", "evaluation_every", "checkpoint_every"}
    differing = [name for name in configs[0] if name not in own and any(c[name] != configs[0][name] for c in configs)]
    fields = config.model_fields
    return [(name, fields[name].default, " ".join(fields[name].description.split())) for name in differing]
