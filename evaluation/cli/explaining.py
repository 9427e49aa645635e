"""Fly an episode up to a step, and print why each UAV flies where it does."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from indoor_explorers.env import Explanation, InputError, Pilot, World
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment


def explained(experiment: Experiment, step: int) -> tuple[World, list[Pilot]]:
    """Fly the first episode of an experiment with its policy, for at most ``step`` steps; return world and pilots.

    The pilots have decided on the action that leads to the world's present step.

    Raises:
        InputError: the experiment has several scenarios or policies.
        RunError: the policy failed.

    """
    if len(experiment.scenarios) > 1 or len(experiment.policies) > 1:
        raise InputError(
            f"expected one policy and one scenario to explain, got {len(experiment.policies)} and "
            f"{len(experiment.scenarios)}; give one of each"
        )
    scenario, policy = experiment.scenarios[0], experiment.policies[0].make()
    world = World(scenario)
    world.begin(0, experiment.seed, floorplan=draw_floorplan(scenario, experiment.seed))
    try:
        pilots = make_pilots(policy, world)
        for pilot in pilots.values():
            pilot.explaining = True
        for _ in rollout(world, ask_pilots(policy, pilots, world)):
            if int(world.state.step[0]) >= step:
                break
    except Exception as error:
        raise RunError(f"policy failed at step {world.state.step[0]}: {type(error).__name__}: {error}") from error
    return world, [pilots[0, agent] for agent in range(scenario.team)]


def print_explanations(world: World, pilots: Sequence[Pilot], agents: Sequence[int], console: Console) -> None:
    """Print why each of some UAVs made its last move."""
    step = int(world.state.step[0])
    for agent in agents:
        told, cell = pilots[agent].explain(), cell_text(world.state.believed_cell[0, agent].tolist())
        console.print(f"UAV {agent}, step {step}, in {cell}: {summary(told)}", highlight=False, soft_wrap=True)
        if told is not None and told.candidates:
            console.print(f"  among {len(told.candidates)}, by {told.score}:", highlight=False, soft_wrap=True)
            console.print(candidates_table(told))
        if told is not None and told.mates:
            others = ", ".join(f"UAV {mate} to {cell_text(goal)}" for mate, goal in sorted(told.mates.items()))
            console.print(f"  it supposes: {others}", highlight=False, soft_wrap=True)


def cell_text(cell: Sequence[int] | Cell) -> str:
    """Return a cell as text: its row and column."""
    return f"({cell[0]}, {cell[1]})"


def summary(told: Explanation | None) -> str:
    """Return the sentence about an explanation."""
    if told is None:
        return "this policy does not explain its actions"
    way = "" if len(told.path) < 2 else f", {len(told.path) - 1} steps away"
    goal = "no goal" if told.goal is None else f"flies to {cell_text(told.goal)}{way}, chosen at step {told.step}"
    return f"{goal}; {told.note}" if told.note else goal


def candidates_table(told: Explanation) -> Table:
    """Return the candidates of an explanation, the best first, the chosen one marked."""
    names = list(told.candidates[0].parts)
    table = Table("", "cell", "score", *names, box=None, header_style="bold", pad_edge=False)
    for column in table.columns[2:]:
        column.justify = "right"
    for each in told.candidates:
        mark = ">" if each.cell == told.goal else ""
        table.add_row(mark, cell_text(each.cell), f"{each.score:.3g}", *(f"{each.parts[name]:.3g}" for name in names))
    return table
