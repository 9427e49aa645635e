"""Show one episode of a policy in a window or save it to a file: the same episode that a comparison flies."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from indoor_explorers.env import Policy, World
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.rendering import Trails, paint, percent, scene_of
from indoor_explorers.env.rendering.video_writer import FPS, VideoWriter
from indoor_explorers.env.rendering.window import Window
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.experiment.experiment import Experiment


def watch(experiment: Experiment, console: Console, *, save: Path | None, steps: int | None, fps: float | None) -> None:
    """Fly the first episode of an experiment's first policy and show it, or save it to a file.

    ``steps`` limits its length. Prints the path of the file and how the episode ended.

    Raises:
        InputError: the file cannot be written, or no window can be opened.
        RunError: the policy failed; no file is written.

    """
    policy, scenario = experiment.policies[0].make(), experiment.scenarios[0]
    title = f"{scenario.name}  \u00b7  {experiment.policies[0].name}  \u00b7  seed {experiment.seed}"
    world = World(scenario)
    world.begin(0, experiment.seed, floorplan=draw_floorplan(scenario, experiment.seed))
    last = min(int(world.state.budget[0]), steps if steps is not None else int(world.state.budget[0]))
    show = Show(world, title, last)
    moments = flight(policy, world, last)
    if save is None:
        show.in_window(moments, fps)
    else:
        show.in_file(moments, VideoWriter(save, fps), console)
    console.print(
        f"{experiment.policies[0].name} on {scenario.name}, seed {experiment.seed}: "
        f"step {world.state.step[0]} of {world.state.budget[0]}, coverage {percent(world.team_coverage[0])}",
        highlight=False,
        soft_wrap=True,
    )


def flight(policy: Policy, world: World, last: int) -> Iterator[bool]:
    """Fly episode 0 of a world that has begun, up to step ``last``.

    Yields at the start and after every step whether the episode goes on. The episode is the one that
    :mod:`indoor_explorers.evaluation.episodes.runner` flies in a batch of one.
    """
    yield last > 0
    try:
        asks = ask_pilots(policy, make_pilots(policy, world), world)
        for _ in islice(rollout(world, asks), last):
            yield bool(world.flying[0].any()) and int(world.state.step[0]) < last
    except Exception as error:
        raise RunError(f"policy failed at step {world.state.step[0]}: {type(error).__name__}: {error}") from error


class Show:
    """Draws an episode while it is flown."""

    def __init__(self, world: World, title: str, last: int) -> None:
        self._world = world
        self._title = title
        self._last = last
        self._trails = Trails(world.state.truth.shape[1:])

    def picture(self) -> NDArray[np.uint8]:
        """Return a picture of the current step, (h, w, 3) uint8."""
        return paint(scene_of(self._world, 0, self._trails, self._title))

    def in_window(self, moments: Iterator[bool], fps: float | None) -> None:
        """Show every step in a window, and the last one until the window is closed; closing it ends the flight."""
        window = Window(self._title, fps if fps is not None else FPS[0])
        try:
            for going in moments:
                self._trails.add(self._world.state.cell[0])
                if going:
                    window.show(self.picture())
                else:
                    window.linger(self.picture())
                if window.closed:
                    return
        finally:
            window.close()

    def in_file(self, moments: Iterator[bool], video: VideoWriter, console: Console) -> None:
        """Record the flight, write the file and print its path."""
        if not console.is_terminal:
            console.print(f"flying {self._title}", highlight=False, soft_wrap=True)
        columns = [TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()]
        with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
            flying = bar.add_task("flying", total=self._last)
            for going in moments:
                self._trails.add(self._world.state.cell[0])
                video.add(self.picture, last=not going)
                bar.update(flying, completed=int(self._world.state.step[0]))
            bar.update(flying, total=int(self._world.state.step[0]))
            writing = bar.add_task("writing", total=len(video))
            video.save(lambda written: bar.update(writing, completed=written))
        width, height = video.size
        frames = f"{len(video)} frames of " if len(video) > 1 else ""
        console.print(f"Saved: {video.path} ({frames}{width} x {height} pixels)", highlight=False, soft_wrap=True)
