"""The search itself: trials that Optuna draws and the paired test drops, in a study that is stored after each look.

The parameters of a trial depend on the finished trials, the seed and their number alone, so a search that was killed
goes on as if it had not been: the trial during which it was killed is drawn again, and its episodes are in the store.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import optuna
from numpy.typing import NDArray
from optuna.trial import FrozenTrial, Trial, TrialState
from sqlalchemy import URL

from indoor_explorers.evaluation.studies.tuning.flights import Flights
from indoor_explorers.evaluation.studies.tuning.plan import Search
from indoor_explorers.evaluation.studies.tuning.sequential import VALUES, PairedTest, looks

#: The study's file and name.
STUDY, NAME = "study.db", "tune"
#: The states of trials that count.
FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)
SECONDS_AN_HOUR = 3600


def finished(study: optuna.Study) -> list[FrozenTrial]:
    """Return the trials that were flown to the end or dropped, in order; the first one has the default parameters."""
    return study.get_trials(deepcopy=False, states=FINISHED)


def run_search(search: Search, flights: Flights, tell: Callable[[str], None]) -> optuna.Study:
    """Fly the trials that the study in the folder lacks, and return it; each is told in a line."""
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    flights.fly_default()
    study = optuna.create_study(
        storage=_storage(search.request.out / STUDY),
        study_name=NAME,
        load_if_exists=True,
        direction="minimize" if search.measure.lower_is_better else "maximize",
        pruner=PairedTest(flights.maps),
    )
    for trial in study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
        study.tell(trial.number, state=TrialState.FAIL)  # the one during which the search was killed
    if not finished(study):
        study.add_trial(_default(search, flights.values(search.space.choice, len(search.tasks))))
    while not _over(search, study):
        number = len(finished(study))
        study.sampler = optuna.samplers.TPESampler(seed=_seed(search.request.seed, number), constant_liar=False)
        flown = _fly(study, study.ask(search.space.distributions()), number, flights)
        tell(_line(search, study, flown, number))
    return study


def _storage(path: Path) -> optuna.storages.RDBStorage:
    return optuna.storages.RDBStorage(URL.create("sqlite", database=str(path.resolve())).render_as_string())


def _seed(seed: int, number: int) -> int:
    """Return the seed of the sampler for a trial."""
    return int(np.random.SeedSequence((seed, number)).generate_state(1)[0])


def _over(search: Search, study: optuna.Study) -> bool:
    """Return whether there are enough trials, or they took the hours asked for."""
    trials = finished(study)[1:]
    if search.trials is not None:
        return len(trials) >= search.trials
    spent = sum(trial.duration.total_seconds() for trial in trials if trial.duration is not None)
    return spent >= (search.request.hours or 0) * SECONDS_AN_HOUR


def _default(search: Search, values: NDArray[np.float64]) -> FrozenTrial:
    """Return the trial with the default parameters."""
    return optuna.trial.create_trial(
        params=dict(search.space.defaults),
        distributions=search.space.distributions(),
        value=float(values.mean()),
        user_attrs={VALUES: values.tolist()},
    )


def _fly(study: optuna.Study, trial: Trial, number: int, flights: Flights) -> FrozenTrial:
    """Fly a trial to the end or until it is dropped."""
    choice = flights.search.space.with_parameters(f"trial-{number}", trial.params)
    best, total = study.best_trial, len(flights.search.tasks)
    for count in (*looks(total), total):
        values = flights.values(choice, count)
        trial.set_user_attr(VALUES, values.tolist())
        trial.report(estimated(values, best), count)
        if count < total and trial.should_prune():
            return study.tell(trial, state=TrialState.PRUNED)
    return study.tell(trial, float(values.mean()))


def estimated(values: NDArray[np.float64], best: FrozenTrial) -> float:
    """Return the mean over all episodes of a trial of which some (E,) were flown: the best's, plus the difference."""
    return float(np.mean(best.user_attrs[VALUES]) + (values - best.user_attrs[VALUES][: len(values)]).mean())


def _line(search: Search, study: optuna.Study, trial: FrozenTrial, number: int) -> str:
    """Return what is told of a trial."""
    count, total = trial.last_step or 0, len(search.tasks)
    fate = f"dropped after {count} of {total} episodes" if trial.state is TrialState.PRUNED else f"{total} episodes"
    of = f" of {search.trials}" if search.trials is not None else ""
    best = ", the best so far" if trial.number == study.best_trial.number else ""
    figure = trial.intermediate_values[count]
    return f"trial {number}{of}: {search.measure.title} {figure:.3f} of the default's, {fate}{best}"
