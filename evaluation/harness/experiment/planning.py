"""Turns a request, and the experiment file or suite that it names, into an experiment."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.env.scenarios.suites.catalogue import suite_of
from indoor_explorers.env.scenarios.suites.clones import scenarios_of
from indoor_explorers.env.scenarios.suites.suite import Part, Suite
from indoor_explorers.env.scenarios.validation import read_toml, validated
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, build_experiment
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.experiment.selection import chosen_policies, chosen_scenarios

#: Keys of an experiment file, and the fields of a request that they fill.
KEYS = {
    **{name: name for name in ("policies", "episodes", "seed", "margin")},
    **{"scenarios": "scenario", "set": "settings"},
}
#: The folder of the experiments that ship.
SHIPPED = Path(__file__).parents[2] / "experiments"


def plan(request: ComparisonRequest) -> Experiment:
    """Build an experiment from a request and the file that it names.

    A policy or scenario that has the name of an entry of the file means that entry. A suite takes the place of the
    file's scenarios, seed and episodes.

    Raises:
        InputError: a policy, scenario or file does not exist, or options contradict each other.

    """
    path = None if request.experiment is None else experiment_file(request.experiment)
    file = ComparisonRequest() if path is None else read_experiment(path)
    policies = chosen_policies(request.policies, file.policies)
    margin = file.margin if request.margin is None else request.margin
    if request.suite is not None:
        return suite_experiment(request, policies, margin)
    refuse_without_suite(request)
    team = {} if request.team is None else {"team": request.team}
    return build_experiment(
        policies,
        _scenarios(request, file, Path() if path is None else path.parent),
        episodes=file.episodes if request.episodes is None else request.episodes,
        seed=file.seed if request.seed is None else request.seed,
        margin=margin,
        settings={**file.settings, **request.settings, **team},
    )


def experiment_file(asked: Path) -> Path:
    """Return the path of an experiment file: the one asked for, or that of a shipped experiment by name.

    Raises:
        InputError: there is no such file and none of that name.

    """
    if asked.suffix or asked.exists():
        return asked
    names = [file.stem for file in SHIPPED.glob("*.toml")]
    if asked.name not in names:
        hint = did_you_mean(str(asked), names)
        raise InputError(f"unknown experiment {str(asked)!r} (expected a file or one that ships){hint}")
    return SHIPPED / f"{asked.name}.toml"


def read_experiment(path: Path) -> ComparisonRequest:
    """Read an experiment file; its policies and scenarios may be tables, which are not yet validated."""
    data = read_toml(path)
    for key in data:
        if key not in KEYS:
            raise InputError(f"{path}: unknown key {key!r}{did_you_mean(key, KEYS)}")
    for key in ("policies", "scenarios"):
        if key in data and not isinstance(data[key], list):
            raise InputError(f"{path}: expected {key} to be a list, got {data[key]!r}")
    if not isinstance(data.get("set", {}), dict):
        raise InputError(f"{path}: expected [set] to be a table of settings, got {data['set']!r}")
    return validated(ComparisonRequest, {KEYS[key]: value for key, value in data.items()}, str(path))


def _scenarios(request: ComparisonRequest, file: ComparisonRequest, folder: Path) -> list[Scenario]:
    """Return the scenarios asked for, with the maps of the request if it has any; ``folder`` is that of the file."""
    if request.resolution is not None and not request.maps:
        raise InputError("expected --maps with --resolution, got none; name the map files to resample")
    if not request.maps:
        return chosen_scenarios(request.scenario, file.scenario, folder)
    files = on_files(request.maps, request.resolution).for_evaluation()
    if request.scenario is None and file.scenario is None:
        return [files]
    return [
        each.model_copy(update={"name": f"{each.name} on {files.name}", "map": files.map, "budget": None})
        for each in chosen_scenarios(request.scenario, file.scenario, folder)
    ]


#: Options that would make other tasks than those of the suite.
FIXED = {"resolution": "--resolution", "seed": "--seed", "settings": "--set"}
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
            f"suite {suite.name!r} has {len(seeds)} episodes a {'scenario' if suite.generated else 'map'} in its "
            f"{part} part, got --episodes {episodes}; ask for fewer"
        )
    _refuse_unknown(suite, request)
    scenarios = scenarios_of(
        suite,
        part,
        request.data,
        only=request.maps,
        teams=None if request.team is None else [request.team],
        radios=request.radio,
        names=request.scenario,
    )
    return build_experiment(policies, scenarios, episodes=episodes, seed=seeds[0], margin=margin, settings={})


def _refuse_unknown(suite: Suite, request: ComparisonRequest) -> None:
    """Refuse teams and radios that the suite does not have."""
    teams = sorted({scenario.team for scenario in suite.scenarios()})
    if request.team is not None and request.team not in teams:
        listed = ", ".join(map(str, teams))
        raise InputError(
            f"suite {suite.name!r} has teams of {listed} UAVs, got --team {request.team}; ask for one of them"
        )
    for name in request.radio or ():
        if name not in suite.radios:
            raise InputError(f"suite {suite.name!r} has no radio {name!r}{did_you_mean(name, suite.radios)}")
