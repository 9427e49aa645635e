"""``explain``: print why each UAV flies where it does at a step of an episode."""

from __future__ import annotations

from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console
from indoor_explorers.evaluation.cli.commands.one_episode import EpisodeOptions
from indoor_explorers.evaluation.harness.experiment.request import Option, read_count


class ExplainOptions(EpisodeOptions):
    """The options of ``explain``."""

    step: Annotated[int, Option(metavar="N", read=read_count)] = 1
    """The step to explain; the last one of a shorter episode."""
    agent: Annotated[int | None, Option(metavar="N", read=int)] = None
    """The number of the UAV to explain, from 0 on (default all)."""


def run_explain(options: ExplainOptions, typed: str) -> int:
    """Fly to a step and print why each UAV flies where it does."""
    from indoor_explorers.env import InputError
    from indoor_explorers.evaluation.cli.explaining import explained, print_explanations
    from indoor_explorers.evaluation.harness.experiment.planning import plan

    experiment = plan(options.comparison((options.policy,)))
    team = experiment.scenarios[0].team
    if options.agent is not None and not 0 <= options.agent < team:
        raise InputError(f"expected --agent from 0 to {team - 1}, got {options.agent}")
    flight = explained(experiment, options.step)
    print_explanations(flight, range(team) if options.agent is None else [options.agent], make_console())
    return 0


EXPLAIN = Command(ExplainOptions, run_explain)
