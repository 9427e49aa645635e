"""The progress of a comparison: episodes, rate, time left, and the running means of each policy."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from types import TracebackType

import numpy as np
from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.episodes.record import Outcome, Record
from indoor_explorers.evaluation.results.coverage_threshold import T99, CoverageThreshold, shared

#: Seconds between two lines where the output is no terminal.
SAY_EVERY = 30.0


class Means:
    """The running means of one policy over the episodes flown so far in this run."""

    def __init__(self) -> None:
        self.episodes = 0
        self.failed = 0
        self._reached = 0
        self._area = 0.0
        self._coverage = 0.0

    def add(self, record: Record, level: CoverageThreshold = T99) -> None:
        """Take one more episode in, of a scenario judged by ``level``."""
        self.episodes += 1
        self.failed += record.outcome is Outcome.FAILED
        self._reached += record.metrics.get(level.key) is not None
        self._area += record.metrics.get("auc") or 0.0
        self._coverage += float(record.curve[-1])

    def cells(self) -> tuple[str, str, str, str]:
        """Return mean AUC, mean coverage at the end, the share that reached its level, and failures, as text."""
        figures = np.array([self._area, self._coverage, self._reached]) / max(1, self.episodes)
        area, covered, reached = figures.tolist()
        return f"{area:.3f}", f"{covered:.1%}", f"{reached:.0%}", str(self.failed) if self.failed else ""


class ProgressBar:
    """Show the progress of a run, live on a terminal; elsewhere say a line at the start and now and then."""

    def __init__(self, console: Console, levels: Mapping[str, CoverageThreshold] | None = None) -> None:
        """Write to ``console``; ``levels`` are what scenarios are judged by, 99 % for those not in it."""
        self._console = console
        self._levels = levels or {}
        self._means: dict[str, Means] = {}
        self._begun = False
        self._bar = Progress(
            TextColumn("flying"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=console,
        )
        self._task = self._bar.add_task("flying", total=None, rate="")
        self._live = Live(get_renderable=self._shown, console=console, transient=True, refresh_per_second=4)
        self._flown = self._missing = 0
        self._start = self._said = time.monotonic()

    def __enter__(self) -> ProgressBar:
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()

    def begin(self, total: int, missing: int) -> None:
        """Show how much there is to do."""
        if missing < total:
            rest = f"; flying {missing}" if missing else ""
            self._console.print(f"{total - missing} of {total} episodes are there already{rest}")
        elif not self._console.is_terminal:
            self._console.print(f"flying {total} episodes")
        self._missing, self._begun = missing, True
        self._start = self._said = time.monotonic()
        self._bar.reset(self._task, total=missing, rate="")

    def flown(self, records: Sequence[Record]) -> None:
        """Count finished episodes."""
        for record in records:
            level = self._levels.get(record.task.scenario, T99)
            self._means.setdefault(record.policy, Means()).add(record, level)
        self._flown += len(records)
        self._bar.update(self._task, completed=self._flown, rate=f"{self._rate:.1f} episodes/s")
        if not self._console.is_terminal and time.monotonic() - self._said > SAY_EVERY:
            self._said = time.monotonic()
            self._console.print(self._line(), highlight=False, markup=False, soft_wrap=True)

    @property
    def _reached(self) -> str:
        level = shared(self._levels.values()) if self._levels else T99
        return f"{level.percent} reached" if level else "reached"

    @property
    def _rate(self) -> float:
        return self._flown / max(1e-9, time.monotonic() - self._start)

    def _line(self) -> str:
        left = (self._missing - self._flown) / self._rate
        means = ", ".join(f"{policy} {means.cells()[0]}" for policy, means in self._means.items())
        return (
            f"{self._flown} of {self._missing} episodes, {self._rate:.1f} a second, some {left:.0f} s left; "
            f"mean AUC so far: {means}"
        )

    def _shown(self) -> Group:
        if self._begun and self._flown >= self._missing:
            return Group(Text("writing the report"))
        table = Table(box=None, header_style="dim", pad_edge=False)
        table.add_column("policy so far", overflow="ellipsis", no_wrap=True, max_width=32)
        for heading in ("episodes", "mean AUC", "covered", self._reached, "failed"):
            table.add_column(heading, justify="right")
        for policy, means in self._means.items():
            table.add_row(Text(policy), str(means.episodes), *means.cells())
        return Group(self._bar, table) if self._means else Group(self._bar)
