"""``explain``: print why each UAV flies where it does at a step of an episode."""

from __future__ import annotations

from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console
from indoor_explorers.evaluation.harness.experiment.request import (
    NO_SETTINGS,
    RESOLUTION,
    SEED,
    TEAM,
    ComparisonRequest,
    Option,
    Request,
    Settings,
    read_count,
)


class ExplainOptions(Request):
    """The options of ``explain``."""

    policy: Annotated[str, Option(metavar="NAME")]
    """The policy: a name, NAME:PATH such as sb3:DIR, or module:Class, with parameters as in 'pso(length=1)'."""
    scenario: Annotated[str | None, Option(metavar="PRESET|FILE.toml")] = None
    """The scenario (default thesis-obstacles)."""
    maps: Annotated[str | None, Option(metavar="PATH")] = None
    """A map file to explore instead."""
    resolution: Annotated[float | None, RESOLUTION] = None
    """Metres per cell to resample the map file to. Pictures have no scale: a pixel of theirs counts as 1 m."""
    team: Annotated[int | None, TEAM] = None
    """Number of UAVs."""
    seed: Annotated[int, SEED] = 0
    """Seed of the episode; compare and watch fly the same episode for the same seed."""
    settings: Settings = NO_SETTINGS
    """Scenario settings such as goal=0.9 or radio.range=3."""
    step: Annotated[int, Option(metavar="N", read=read_count)] = 1
    """The step to explain; the last one of a shorter episode."""
    agent: Annotated[int | None, Option(metavar="N", read=int)] = None
    """The number of the UAV to explain, from 0 on (default all)."""


def run_explain(options: ExplainOptions, typed: str) -> int:
    """Fly to a step and print why each UAV flies where it does."""
    from indoor_explorers.env import InputError
    from indoor_explorers.evaluation.cli.explaining import explained, print_explanations
    from indoor_explorers.evaluation.harness.experiment.planning import plan

    request = ComparisonRequest(
        policies=(options.policy,),
        scenario=options.scenario,
        maps=options.maps,
        resolution=options.resolution,
        team=options.team,
        episodes=1,
        seed=options.seed,
        settings=options.settings,
    )
    experiment = plan(request)
    team = experiment.scenarios[0].team
    if options.agent is not None and not 0 <= options.agent < team:
        raise InputError(f"expected --agent from 0 to {team - 1}, got {options.agent}")
    world, pilots = explained(experiment, options.step)
    agents = range(team) if options.agent is None else [options.agent]
    print_explanations(world, pilots, agents, make_console())
    return 0


EXPLAIN = Command("explain", "print why each UAV flies where it does at a step", ExplainOptions, run_explain)
