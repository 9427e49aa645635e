"""The ``tune`` command: search, fly the gain on fresh episodes, and write tuned.toml, table, figure and page."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING

import tomli_w

from indoor_explorers.env import InputError
from indoor_explorers.env.files import alone_in, writable, write_whole
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
    from optuna.trial import FrozenTrial

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
            search, or one that runs.

    """
    if find_spec("optuna") is None:
        raise InputError("tune needs Optuna, which is not installed: pip install 'indoor-explorers[tune]'")
    from indoor_explorers.evaluation.studies.tuning.search import run_search

    search = Search.of(request)
    with writable(request.out, "--out"):
        search.claim(request.out)
        with alone_in(request.out, "--out"):
            with kept_engine(request.workers) as engine:
                study = run_search(search, Flights(search, engine, command), tell)
            gain = _gain(search, study.best_trial, command) if study.best_trial.number > 0 else None
            _write(search, study, gain, command)
    for line in (f"Page: {request.out / 'tuning.html'}", f"Tuned policy: {request.out / TUNED}"):
        tell(line)
    tell(NONE_BETTER if gain is None else gain.line)


def compared(search: Search, best: FrozenTrial, experiment: Experiment) -> Experiment:
    """Return an experiment with the default and the tuned policy; with the first alone where no trial was better."""
    tuned = (search.tuned(best.params),) if best.number > 0 else ()
    return experiment.model_copy(update={"policies": (search.space.choice, *tuned)})


def _gain(search: Search, best: FrozenTrial, command: str) -> Gain:
    """Fly default and tuned policy on the fresh episodes, and compare them."""
    experiment = compared(search, best, search.fresh)
    request = ComparisonRequest(workers=search.request.workers, ratio_to=(search.space.choice.name,))
    results = run(experiment, search.request.out / FRESH, request, command=command)
    return Gain.of(search, results, experiment.policies[1].name)


def _write(search: Search, study: Study, gain: Gain | None, command: str) -> None:
    from indoor_explorers.evaluation.studies.tuning.page import rows_of, write_page

    out = search.request.out
    write_whole(out / TUNED, tuned_toml(search, study.best_trial, command))
    rows = rows_of(search, study)
    write_rows(out / "trials.csv", list(rows[0]), rows)
    write_page(search, study, gain, out, command)


def tuned_toml(search: Search, best: FrozenTrial, command: str) -> str:
    """Return the experiment file for ``compare --experiment``: both policies, and the scenarios if not of a suite.

    It names no seeds, so that a comparison flies others than the search.
    """
    whole = tomllib.loads(compared(search, best, search.tuning).to_toml())
    kept = ("policies",) if search.request.suite is not None else ("policies", "scenarios")
    return f"# Made by: {command}\n" + tomli_w.dumps({key: whole[key] for key in kept})
