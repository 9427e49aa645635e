"""Show an episode of one policy, or of several side by side, in a window or save it to a file.

Each is the episode that a comparison flies for that seed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.rendering import Trails, floored_percent, paint, scene_of
from indoor_explorers.env.rendering.scene import Told
from indoor_explorers.env.rendering.side_by_side import MOST, SideBySide, paint_side_by_side
from indoor_explorers.env.rendering.video_writer import FPS, VideoWriter
from indoor_explorers.env.rendering.window import Window
from indoor_explorers.evaluation.exports.rerun_log import VIEWER, RerunLog
from indoor_explorers.evaluation.harness.episodes.flight import Flight
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment

#: The key that explains the next UAV.
EXPLAINS = "e"


def watch(
    experiment: Experiment,
    console: Console,
    *,
    film: VideoWriter | None,
    steps: int | None,
    fps: float | None,
    explained: int | None = None,
) -> None:
    """Fly the first episode of an experiment with each policy, and write it to a film, or show it in a window.

    ``steps`` limits its length, and ``explained`` is the UAV whose pilot tells why it flies where it does. Prints the
    path of the file and how the episodes ended.

    Raises:
        InputError: too many policies, several scenarios, no such UAV, or no window can be opened.
        RunError: a policy failed; no file is written.

    """
    count = len(experiment.policies)
    if count > MOST:
        raise InputError(f"expected up to {MOST} policies to watch side by side, got {count}; leave some out")
    _refuse_several(experiment)
    if explained is not None:
        _refuse_unexplained(experiment, explained)
    explaining = count == 1 and (film is None or explained is not None)
    flights = [WatchedFlight(experiment, number, steps, explaining=explaining) for number in range(count)]
    title = f"{experiment.scenarios[0].name}  \u00b7  {flights[0].name}  \u00b7  seed {experiment.seed}"
    if count == 1:
        show = Show(flights, title, explained=explained)
    else:
        title = f"{experiment.scenarios[0].name}  \u00b7  {count} policies  \u00b7  seed {experiment.seed}"
        show = Show(flights, title, _longest(experiment, steps) if film is not None else 0)
    if film is None:
        show.in_window(fps)
    else:
        show.in_file(film, console)
    for each in flights:
        console.print(f"{each.name} on {each.ending(experiment.seed)}", highlight=False, soft_wrap=True)


def log_in_rerun(experiment: Experiment, console: Console, path: Path, steps: int | None) -> None:
    """Fly the first episode of an experiment with each policy, and log it in a ``.rrd`` file or in Rerun's viewer.

    Raises:
        InputError: several scenarios, the path is no ``.rrd`` file, or Rerun is not installed.
        RunError: a policy failed; the steps before are logged.

    """
    _refuse_several(experiment)
    names, scenario = [choice.name for choice in experiment.policies], experiment.scenarios[0]
    log = RerunLog(f"{scenario.name}, seed {experiment.seed}", path, names, scenario.team)
    flights = [WatchedFlight(experiment, number, steps) for number in range(len(names))]
    for _ in together(flights):
        for each in flights:
            log.add(each.name, each.world)
    log.close()
    if path != VIEWER:
        console.print(f"Saved: {path}; rerun {path} opens it", highlight=False, soft_wrap=True)
    for each in flights:
        console.print(f"{each.name} on {each.ending(experiment.seed)}", highlight=False, soft_wrap=True)


def _refuse_several(experiment: Experiment) -> None:
    if len(experiment.scenarios) > 1:
        raise InputError(f"expected one scenario to watch, got {len(experiment.scenarios)}; give --set one value each")


def _refuse_unexplained(experiment: Experiment, agent: int) -> None:
    """Refuse to explain several policies, or a UAV that is not in the team."""
    team = experiment.scenarios[0].team
    if len(experiment.policies) > 1:
        raise InputError(f"expected one policy to explain, got {len(experiment.policies)}; leave out --explain or them")
    if not 0 <= agent < team:
        raise InputError(f"expected --explain from 0 to {team - 1}, got {agent}")


def _longest(experiment: Experiment, steps: int | None) -> int:
    """Return the steps of the longest flight, so that all charts end there."""
    flights = [WatchedFlight(experiment, number, steps) for number in range(len(experiment.policies))]
    for each in flights:
        for _ in each.moments():
            pass
    return max(each.step for each in flights)


class WatchedFlight(Flight):
    """The first episode of an experiment with one of its policies, for at most ``steps`` steps."""

    def __init__(self, experiment: Experiment, number: int, steps: int | None, *, explaining: bool = False) -> None:
        choice = experiment.policies[number]
        super().__init__(choice.make(), experiment.scenarios[0], experiment.seed, explaining=explaining)
        self.name = choice.name
        budget = int(self.world.state.budget[0])
        self.last = min(budget, steps if steps is not None else budget)
        self.trails = Trails(self.world.state.truth.shape[1:])
        self.coverage: list[float] = []

    def moments(self) -> Iterator[bool]:
        """Fly; yield at the start and after every step whether the episode goes on."""
        self._note()
        yield self.last > 0
        for _ in islice(self.steps(), self.last):
            self._note()
            yield bool(self.world.flying[0].any()) and self.step < self.last

    def _note(self) -> None:
        self.trails.add(self.world.state.cell[0])
        self.coverage.append(float(self.world.counted_coverage[0]))

    def ending(self, seed: int) -> str:
        """Return the sentence on how far the episode came."""
        state = self.world.state
        facts = f"step {state.step[0]} of {state.budget[0]}, coverage {floored_percent(self.world.counted_coverage[0])}"
        return f"{self.world.scenario.name}, seed {seed}: {facts}"


def together(flights: Sequence[WatchedFlight]) -> Iterator[bool]:
    """Fly all flights a step at a time; yield at the start and after every step whether any goes on."""
    flying = {each.moments(): True for each in flights}
    while any(flying.values()):
        for moments, going in flying.items():
            flying[moments] = going and next(moments)
        yield any(flying.values())


class Show:
    """Draws episodes while they are flown.

    Args:
        flights: Flights over maps of one size.
        title: Of the whole picture.
        longest: Steps that the charts of several flights reach to; 0: as far as has been flown.
        explained: The UAV of a single flight to explain; None for none.

    """

    def __init__(
        self, flights: Sequence[WatchedFlight], title: str, longest: int = 0, explained: int | None = None
    ) -> None:
        self._flights, self._title, self._longest, self._explained = flights, title, longest, explained

    def picture(self) -> NDArray[np.uint8]:
        """Return a picture of the current step, (h, w, 3) uint8."""
        scenes = [scene_of(each.world, 0, each.trails, self._title) for each in self._flights]
        if len(scenes) == 1:
            return paint(replace(scenes[0], told=self._told()))
        seen = [SideBySide(each.name, scene, each.coverage) for each, scene in zip(self._flights, scenes, strict=True)]
        return paint_side_by_side(seen, self._longest or self._step)

    def _told(self) -> Told | None:
        """Return what the explained UAV tells."""
        agent = self._explained
        return None if agent is None else Told(agent, self._flights[0].explanations()[agent])

    def press(self, key: str) -> None:
        """Explain the next UAV, or after the last one none, where the key is ``EXPLAINS``."""
        if key == EXPLAINS and len(self._flights) == 1:
            following = 0 if self._explained is None else self._explained + 1
            self._explained = following if following < self._flights[0].world.scenario.team else None

    @property
    def _step(self) -> int:
        return max(each.step for each in self._flights)

    def in_window(self, fps: float | None) -> None:
        """Show every step in a window, and the last one until the window is closed; closing it ends the flights."""
        window = Window(self._title, fps if fps is not None else FPS[0], "use --save FILE.gif")

        def picture() -> NDArray[np.uint8]:
            for key in window.taken_keys():
                self.press(key)
            return self.picture()

        try:
            for going in together(self._flights):
                if going:
                    window.show(picture())
                else:
                    window.linger(picture)
                if window.closed:
                    return
        finally:
            window.close()

    def in_file(self, video: VideoWriter, console: Console) -> None:
        """Record the flights, write the file and print its path."""
        if not console.is_terminal:
            console.print(f"flying {self._title}", highlight=False, soft_wrap=True)
        columns = [TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()]
        with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
            flying = bar.add_task("flying", total=max(each.last for each in self._flights))
            for going in together(self._flights):
                video.add(self.picture, last=not going)
                bar.update(flying, completed=self._step)
            bar.update(flying, total=self._step)
            writing = bar.add_task("writing", total=len(video))
            video.save(lambda written: bar.update(writing, completed=written))
        width, height = video.size
        frames = f"{len(video)} frames of " if len(video) > 1 else ""
        console.print(f"Saved: {video.path} ({frames}{width} x {height} pixels)", highlight=False, soft_wrap=True)
