"""The ``tune`` command: search, fly the gain on fresh episodes, and write tuned.toml, table, figure and page."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import tomli_w

from indoor_explorers.env import InputError
from indoor_explorers.env.files import writable, written_whole
from indoor_explorers.evaluation.driver import run
from indoor_explorers.evaluation.harness.engines.factory import kept_engine
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.studies.many_trainings import write_rows
from indoor_explorers.evaluation.studies.tuning.flights import Flights
from indoor_explorers.evaluation.studies.tuning.gain import NONE_BETTER, Gain
from indoor_explorers.evaluation.studies.tuning.plan import Search
from indoor_explorers.evaluation.studies.tuning.request import TuneRequest

if TYPE_CHECKING:
    from optuna.study import Study

#: Folder of the comparison on fresh episodes.
FRESH = "fresh"
#: The file that compare reads.
TUNED = "tuned.toml"

Tell = Callable[[str], None]


def run_tuning(request: TuneRequest, command: str, tell: Tell) -> None:
    """Tune a policy; ``tell`` gets a line for each trial, and last the gain on fresh episodes.

    Writes ``tuned.toml``, ``trials.csv``, ``tuning.html``, ``figures/``, the study in ``study.db``, its episodes in
    ``flights/`` and the comparison on fresh ones in ``fresh/``.

    Raises:
        InputError: Optuna is missing, something asked for does not exist or fit together, or the folder holds another
            search.

    """
    if find_spec("optuna") is None:
        raise InputError("tune needs Optuna, which is not installed: pip install 'indoor-explorers[tune]'")
    from indoor_explorers.evaluation.studies.tuning.search import run_search

    search = Search.of(request)
    with writable(request.out, "--out"):
        search.claim(request.out)
        with kept_engine(request.workers) as engine:
            study = run_search(search, Flights(search, engine, command), tell)
        best = study.best_trial
        gain = _gain(search, best.params, command) if best.number > 0 else None
        _write(search, study, gain, command)
    for line in (f"Page: {request.out / 'tuning.html'}", f"Tuned policy: {request.out / TUNED}"):
        tell(line)
    tell(NONE_BETTER if gain is None else gain.line)


def compared(search: Search, best: Mapping[str, Any], experiment: Experiment) -> Experiment:
    """Return an experiment with the default and the tuned policy."""
    return experiment.model_copy(update={"policies": (search.space.choice, search.tuned(best))})


def _gain(search: Search, best: Mapping[str, Any], command: str) -> Gain:
    """Fly default and tuned policy on the fresh episodes, and compare them."""
    experiment = compared(search, best, search.fresh)
    request = ComparisonRequest(workers=search.request.workers, ratio_to=(search.space.choice.name,))
    results = run(experiment, search.request.out / FRESH, request, command=command)
    return Gain.of(search, results, experiment.policies[1].name)


def _write(search: Search, study: Study, gain: Gain | None, command: str) -> None:
    from indoor_explorers.evaluation.studies.tuning.page import rows_of, write_page

    out = search.request.out
    with written_whole(out / TUNED) as partial:
        partial.write_text(tuned_toml(search, study.best_trial.params, command), encoding="utf-8", newline="\n")
    rows = rows_of(search, study)
    write_rows(out / "trials.csv", list(rows[0]), rows)
    write_page(search, study, gain, out, command)


def tuned_toml(search: Search, best: Mapping[str, Any], command: str) -> str:
    """Return the experiment file for ``compare --experiment``: both policies, and the scenarios if not of a suite.

    It names no seeds, so that a comparison flies others than the search.
    """
    whole = tomllib.loads(compared(search, best, search.tuning).to_toml())
    kept = ("policies",) if search.request.suite is not None else ("policies", "scenarios")
    return f"# Made by: {command}\n" + tomli_w.dumps({key: whole[key] for key in kept})
