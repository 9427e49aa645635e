"""The progress bar of a comparison: episodes, rate, time left and the running mean of each policy."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from indoor_explorers.evaluation.record import Record


class ProgressBar:
    """Show the progress of a run on a terminal; says a line at the start elsewhere."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task("flying", total=None, rate="")
        self._flown = 0

    def __enter__(self) -> ProgressBar:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def begin(self, total: int, missing: int) -> None:
        """Show how much there is to do."""
        if missing < total:
            rest = f"; flying {missing}" if missing else ""
            self._console.print(f"{total - missing} of {total} episodes are there already{rest}")
        elif not self._console.is_terminal:
            self._console.print(f"flying {total} episodes")
        self._bar.update(self._task, total=missing)

    def flown(self, records: Sequence[Record]) -> None:
        """Count finished episodes."""
        self._flown += len(records)
        seconds = self._bar.tasks[0].elapsed or 0.0
        rate = f"{self._flown / seconds:.1f} episodes/s" if seconds > 0 else ""
        self._bar.update(self._task, completed=self._flown, description=records[-1].policy, rate=rate)
