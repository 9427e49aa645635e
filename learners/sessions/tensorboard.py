"""TensorBoard: the progress of a running training as event files in ``tensorboard/`` of its folder."""

from __future__ import annotations

import math
from types import TracebackType
from typing import Any

from indoor_explorers.learners.sessions.session import Progress, Session

FOLDER = "tensorboard"


class Scalars:
    """Write the progress of a session as event files; without the package tensorboardX, write nothing."""

    def __init__(self, session: Session) -> None:
        self._out = session.out / FOLDER
        self._writer: Any = None
        session.listeners.append(self.write)

    def __enter__(self) -> Scalars:
        """Open a new event file in the training's folder."""
        try:
            from tensorboardX import SummaryWriter  # type: ignore[import-untyped]  # has no types
        except ModuleNotFoundError:
            return self
        self._writer = SummaryWriter(str(self._out))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the event file."""
        if self._writer is not None:
            self._writer.close()

    def write(self, progress: Progress) -> None:
        """Write the scalars of a progress report."""
        if self._writer is not None:
            for name, value in scalars(progress).items():
                self._writer.add_scalar(name, value, progress.steps)


def scalars(progress: Progress) -> dict[str, float]:
    """Return the scalars of a progress report by name, without missing ones."""
    found = {name: getattr(progress, name) for name in ("epsilon", "loss", "episode_steps", "episodes")}
    found = {f"training/{name}": value for name, value in found.items() if value is not None}
    found["training/steps_per_second"] = progress.steps_per_second
    found |= {f"evaluation/{name}": value for name, value in (progress.evaluation or {}).items() if name != "steps"}
    return {name: float(value) for name, value in found.items() if not math.isnan(value)}
