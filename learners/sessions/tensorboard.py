"""TensorBoard: the progress of a running training as event files in ``tensorboard/`` of its folder."""

from __future__ import annotations

import math
from contextlib import ExitStack
from functools import partial
from typing import Any

from indoor_explorers.learners.sessions.session import Progress, Session

FOLDER = "tensorboard"


class Scalars(ExitStack):
    """Write the progress of a session as event files; without the package tensorboardX, write nothing."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        try:
            from tensorboardX import SummaryWriter  # type: ignore[import-untyped]  # has no types
        except ModuleNotFoundError:
            return
        writer = self.enter_context(SummaryWriter(str(session.out / FOLDER)))
        session.listeners.append(partial(_write, writer))


def _write(writer: Any, progress: Progress) -> None:
    for name, value in scalars(progress).items():
        writer.add_scalar(name, value, progress.steps)


def scalars(progress: Progress) -> dict[str, float]:
    """Return the scalars of a progress report by name, without missing ones."""
    found = {name: getattr(progress, name) for name in ("epsilon", "loss", "episode_steps", "episodes")}
    found = {f"training/{name}": value for name, value in found.items() if value is not None}
    found["training/steps_per_second"] = progress.steps_per_second
    found |= {f"evaluation/{name}": value for name, value in (progress.evaluation or {}).items() if name != "steps"}
    return {name: float(value) for name, value in found.items() if not math.isnan(value)}
