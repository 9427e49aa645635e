"""Fly an episode up to a step, and print why each UAV flies where it does."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from indoor_explorers.env import Explanation, InputError
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.policies.explanation import cell_text, sentence
from indoor_explorers.evaluation.harness.episodes.flight import Flight
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment


def explained(experiment: Experiment, step: int) -> Flight:
    """Fly the first episode of an experiment with its policy, for at most ``step`` steps, and return the flight.

    Raises:
        InputError: the experiment has several scenarios or policies.
        RunError: the policy failed.

    """
    if len(experiment.scenarios) > 1 or len(experiment.policies) > 1:
        raise InputError(
            f"expected one policy and one scenario to explain, got {len(experiment.policies)} and "
            f"{len(experiment.scenarios)}; give one of each"
        )
    flight = Flight(experiment.policies[0].make(), experiment.scenarios[0], experiment.seed, explaining=True)
    for _ in flight.steps():
        if flight.step >= step:
            break
    return flight


def print_explanations(flight: Flight, agents: Sequence[int], console: Console) -> None:
    """Print why each of some UAVs made its last move."""
    levels = flight.world.floorplan(0).levels
    for agent in agents:
        told = flight.pilots[agent].explain()
        cell, said = cell_text(flight.world.state.believed_cell[0, agent].tolist(), levels), sentence(told, levels)
        console.print(f"UAV {agent}, step {flight.step}, in {cell}: {said}", highlight=False, soft_wrap=True)
        if told is not None and told.candidates:
            console.print(f"  among {len(told.candidates)}, by {told.score}:", highlight=False, soft_wrap=True)
            console.print(candidates_table(told, levels))
        if told is not None and told.mates:
            others = ", ".join(f"UAV {mate} to {cell_text(goal, levels)}" for mate, goal in sorted(told.mates.items()))
            console.print(f"  it supposes: {others}", highlight=False, soft_wrap=True)


def candidates_table(told: Explanation, levels: Levels | None = None) -> Table:
    """Return the candidates of an explanation on a map of some levels, the best first, the chosen one marked."""
    names = list(told.candidates[0].parts)
    table = Table("", "cell", "score", *names, box=None, header_style="bold", pad_edge=False)
    for column in table.columns[2:]:
        column.justify = "right"
    for each in told.candidates:
        mark = ">" if each.cell == told.goal else ""
        parts = (f"{each.parts[name]:.3g}" for name in names)
        table.add_row(mark, cell_text(each.cell, levels), f"{each.score:.3g}", *parts)
    return table
