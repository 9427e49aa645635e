"""The experiment of a request that names a suite: its tasks, or some of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.scenarios.suites.catalogue import suite_of
from indoor_explorers.env.scenarios.suites.clones import maps_of
from indoor_explorers.env.scenarios.suites.suite import Part, Suite
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, build_experiment
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest

#: Options that would make other tasks than those of the suite.
FIXED = {"scenario": "--scenario", "resolution": "--resolution", "seed": "--seed", "settings": "--set"}
#: Options that mean nothing without a suite.
OF_SUITES = {"part": "--part", "data": "--data", "radio": "--radio"}


def refuse_without_suite(request: ComparisonRequest) -> None:
    """Raise :class:`InputError` where an option chooses tasks of a suite that is not named."""
    for field, flag in OF_SUITES.items():
        if field in request.model_fields_set and getattr(request, field):
            raise InputError(f"expected --suite with {flag}, got none; name a suite, see indoor-explorers suites")


def suite_experiment(request: ComparisonRequest, policies: Sequence[Any], margin: float | None = None) -> Experiment:
    """Return the experiment of a suite's part, or of the tasks in it that the request asks for.

    Raises:
        InputError: the suite, or something in it, does not exist, its files are missing or changed, or an option would
            change its tasks.

    """
    suite, part = suite_of(request.suite or ""), Part(request.part)
    for field, flag in FIXED.items():
        if field in request.model_fields_set and getattr(request, field) not in (None, {}):
            raise InputError(f"suite {suite.name!r} has fixed tasks; leave {flag} out, or fly a scenario of your own")
    seeds = suite.seeds(part)
    episodes = len(seeds) if request.episodes is None else request.episodes
    if episodes > len(seeds):
        raise InputError(
            f"suite {suite.name!r} has {len(seeds)} episodes a {'map' if suite.map is None else 'scenario'} in its "
            f"{part} part, got --episodes {episodes}; ask for fewer"
        )
    _refuse_unknown(suite, request)
    maps = maps_of(suite, part, request.data, request.maps)
    teams = None if request.team is None else [request.team]
    scenarios = suite.scenarios(maps, teams, request.radio)
    return build_experiment(policies, scenarios, episodes=episodes, seed=seeds[0], margin=margin, settings={})


def _refuse_unknown(suite: Suite, request: ComparisonRequest) -> None:
    """Refuse teams and radios that the suite does not have."""
    if request.team is not None and request.team not in suite.teams:
        listed = ", ".join(map(str, suite.teams))
        raise InputError(
            f"suite {suite.name!r} has teams of {listed} UAVs, got --team {request.team}; ask for one of them"
        )
    for name in request.radio or ():
        if name not in suite.radios:
            raise InputError(f"suite {suite.name!r} has no radio {name!r}{did_you_mean(name, suite.radios)}")
