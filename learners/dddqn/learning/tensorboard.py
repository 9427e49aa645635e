"""The figures of a training as it goes, for TensorBoard."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any

FOLDER = "tensorboard"


class Scalars:
    """Write event files that TensorBoard shows; without the package tensorboardX, write nothing."""

    def __init__(self, out: Path) -> None:
        self._out = out / FOLDER
        self._writer: Any = None

    def __enter__(self) -> Scalars:
        """Begin another event file in the training's folder."""
        try:
            from tensorboardX import SummaryWriter  # type: ignore[import-untyped]  # has no types
        except ModuleNotFoundError:
            return self
        self._writer = SummaryWriter(str(self._out))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the event file."""
        if self._writer is not None:
            self._writer.close()

    def write(self, steps: int, scalars: dict[str, float]) -> None:
        """Note figures by name after so many steps of training."""
        if self._writer is not None:
            for name, value in scalars.items():
                self._writer.add_scalar(name, value, steps)
