"""The page and the table of a search."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import optuna

from indoor_explorers.evaluation.drawing.study_page import write_study_page
from indoor_explorers.evaluation.studies.tuning.drawing import write_figures
from indoor_explorers.evaluation.studies.tuning.gain import NONE_BETTER, Gain
from indoor_explorers.evaluation.studies.tuning.plan import Search
from indoor_explorers.evaluation.studies.tuning.sequential import LEVEL, looks
from indoor_explorers.evaluation.studies.tuning.trials import Flown, flown_trials, importances

#: Trials in the page's table.
LISTED = 10


def rows_of(search: Search, study: optuna.Study) -> list[dict[str, Any]]:
    """Return the rows of trials.csv."""
    return [
        {
            "trial": each.number,
            f"{search.request.metric}_to_default": f"{each.value:.6g}",
            "episodes": each.episodes,
            "dropped": str(each.dropped).lower(),
            "parameters": json.dumps(each.parameters),
        }
        for each in flown_trials(search, study)
    ]


def write_page(search: Search, study: optuna.Study, gain: Gain | None, out: Path, command: str) -> None:
    """Write figures and page of a search into its folder; ``gain`` is None where the default stayed the best."""
    flown, found = flown_trials(search, study), importances(search, study)
    figures = out / "figures"
    write_figures(flown, found, search.measure.title, figures)
    best = flown[-1].best
    (tuned,) = [each for each in flown if not each.dropped and each.value == best][:1]
    write_study_page(
        "indoor_explorers.evaluation.studies.tuning",
        out / "tuning.html",
        figures,
        search=search,
        scenarios=[scenario.name for scenario in search.tuning.scenarios],
        command=command,
        gain=gain,
        verdict=NONE_BETTER if gain is None else gain.line,
        parameters=_parameters(search, tuned, found),
        tuned=tuned,
        best=_ranked(search, flown)[:LISTED],
        flown=flown,
        dropped=sum(each.dropped for each in flown),
        saved=1 - sum(each.episodes for each in flown) / (len(flown) * len(search.tasks)),
        importances=found,
        level=LEVEL,
        looks=looks(len(search.tasks)),
    )


def _parameters(search: Search, tuned: Flown, found: dict[str, float]) -> list[tuple[str, str, Any, Any, float | None]]:
    """Return name, range, default, tuned value and importance of each parameter, the most important first."""
    space = search.space
    rows = [
        (name, str(each), space.defaults[name], tuned.parameters[name], found.get(name))
        for name, each in space.ranges.items()
    ]
    return sorted(rows, key=lambda row: -(row[-1] or 0.0))


def _ranked(search: Search, flown: Sequence[Flown]) -> list[Flown]:
    """Return the trials, the best first, dropped ones last."""
    sign = 1 if search.measure.lower_is_better else -1
    return sorted(flown, key=lambda each: (each.dropped, sign * each.value))
