"""``watch``: show policies fly one episode, or save it as a video."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console
from indoor_explorers.evaluation.cli.commands.one_episode import EpisodeOptions
from indoor_explorers.evaluation.harness.experiment.request import (
    Option,
    read_count,
    read_names,
    read_natural,
    read_rate,
)


class WatchOptions(EpisodeOptions):
    """The options of ``watch``."""

    policy: Annotated[tuple[str, ...], Option(metavar="NAME,...", read=read_names)]
    """The policy: a name, NAME:PATH such as sb3:DIR, or module:Class, with parameters as in
    'dddqn(map_alone=true)'; several, with commas, fly side by side."""
    save: Annotated[Path | None, Option(metavar="FILE")] = None
    """Write a .gif, an .mp4, or the last step as a .png."""
    steps: Annotated[int | None, Option(metavar="N", read=read_count)] = None
    """Stop after N steps."""
    frames: Annotated[int | None, Option(metavar="N", read=read_count)] = None
    """Keep at most N frames of a .gif or .mp4 (default 240 or 1800): every second, fourth, ... step of longer ones."""
    fps: Annotated[float | None, Option(metavar="N", read=read_rate)] = None
    """Frames per second (default 8; long videos up to 25)."""
    rerun: Annotated[Path | None, Option(metavar="FILE.rrd", read=Path, alone="")] = None
    """Log the flights to a viewer of Rerun, or into a file for it: maps, poses, trails and beliefs by step."""
    explain: Annotated[int | None, Option(metavar="N", read=read_natural)] = None
    """Draw where UAV N flies and why: way, candidates, scores. In a window the key e explains one after the other."""


def run_watch(options: WatchOptions, typed: str) -> int:
    """Fly one episode in a window, into a file, or into Rerun."""
    if options.rerun is not None:
        return _run_rerun(options, options.rerun)
    from indoor_explorers.env.rendering.video_writer import VideoWriter
    from indoor_explorers.evaluation.cli.watch import watch
    from indoor_explorers.evaluation.harness.experiment.planning import plan

    film = None if options.save is None else VideoWriter(options.save, options.fps, options.frames)
    experiment = plan(options.comparison(options.policy))
    watch(experiment, make_console(), film=film, steps=options.steps, fps=options.fps, explained=options.explain)
    return 0


def _run_rerun(options: WatchOptions, path: Path) -> int:
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.evaluation.cli.watch import log_in_rerun
    from indoor_explorers.evaluation.harness.experiment.planning import plan

    pictures = {"save": options.save, "frames": options.frames, "fps": options.fps, "explain": options.explain}
    given = [f"--{name}" for name, value in pictures.items() if value is not None]
    if given:
        raise InputError(f"expected --rerun without {given[0]}, which is about pictures; leave one of them out")
    log_in_rerun(plan(options.comparison(options.policy)), make_console(), path, options.steps)
    return 0


WATCH = Command(WatchOptions, run_watch, "nothing was written")
