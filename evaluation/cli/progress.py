"""The progress of a comparison: episodes, rate, time left, and running means of the policies."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from types import TracebackType

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.cli.compile_status import CompileStatus
from indoor_explorers.evaluation.cli.running_means import RunningMeans
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode
from indoor_explorers.evaluation.harness.results.coverage_threshold import T99, CoverageThreshold, shared

#: Seconds between two lines where the output is not a terminal.
LINE_INTERVAL = 10.0


class ProgressBar:
    """Show the progress of a run: live on a terminal, elsewhere as a line every :data:`LINE_INTERVAL` seconds."""

    def __init__(self, console: Console, thresholds: Mapping[str, CoverageThreshold] | None = None) -> None:
        """Write to ``console``; ``thresholds`` are those of the scenarios by name, 99 % for others."""
        self._console = console
        self._thresholds = thresholds or {}
        self._means = RunningMeans()
        self._compiling = CompileStatus()
        self._begun = False
        self._bar = Progress(
            TextColumn("flying"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TextColumn("{task.fields[left]}"),
            console=console,
        )
        self._task = self._bar.add_task("flying", total=None, rate="", left="")
        self._live = Live(get_renderable=self._shown, console=console, transient=True, refresh_per_second=4)
        self._flown = self._missing = 0
        self._left = ""
        self._start = self._printed = time.monotonic()

    def __enter__(self) -> ProgressBar:
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()

    def begin(self, total: int, missing: int) -> None:
        """Show how many episodes are missing."""
        if missing < total:
            rest = f"; flying {missing}" if missing else ""
            self._console.print(f"{total - missing} of {counted(total, 'episode')} are in the store already{rest}")
        elif not self._console.is_terminal:
            self._console.print(f"flying {counted(total, 'episode')}")
        self._missing, self._begun = missing, True
        self._start = self._printed = time.monotonic()
        self._bar.reset(self._task, total=missing, rate="", left="")

    def flown(self, records: Sequence[FlownEpisode], seconds_left: float | None = None) -> None:
        """Count finished episodes; ``seconds_left`` is the estimated time for the others."""
        self._left = "" if seconds_left is None else f"about {seconds_left:.0f} s left"
        for record in records:
            threshold = self._thresholds.get(record.task.scenario, T99)
            self._means.add(record, record.metrics.get(threshold.key) is not None)
        self._flown += len(records)
        self._bar.update(self._task, completed=self._flown, rate=f"{self._rate:.1f} episodes/s", left=self._left)
        if not self._console.is_terminal and time.monotonic() - self._printed > LINE_INTERVAL:
            self._printed = time.monotonic()
            self._console.print(self._line(), highlight=False, markup=False, soft_wrap=True)

    @property
    def _reached(self) -> str:
        threshold = shared(self._thresholds.values()) if self._thresholds else T99
        return f"{threshold.percent} reached" if threshold else "reached"

    @property
    def _rate(self) -> float:
        return self._flown / max(1e-9, time.monotonic() - self._start)

    def _line(self) -> str:
        facts = (f"{self._flown} of {counted(self._missing, 'episode')}", f"{self._rate:.1f} a second", self._left)
        line = ", ".join(filter(None, facts))
        means = [f"{policy} {mean.auc:.3f}" for policy, mean in self._means.means().items() if mean]
        return f"{line}; mean AUC over {counted(self._means.tasks, 'task')}: {', '.join(means)}" if means else line

    def _shown(self) -> Group:
        if self._begun and self._flown >= self._missing:
            return Group(Text("writing the report"))
        compiling = self._compiling.line()
        above = [self._bar, Text(compiling, "dim", overflow="ellipsis", no_wrap=True)] if compiling else [self._bar]
        if not self._means.episodes:
            return Group(*above)
        tasks = counted(self._means.tasks, "task")
        caption = f"means over the {tasks} that all these policies have flown" if self._means.tasks else None
        table = Table(box=None, header_style="dim", pad_edge=False, caption=caption, caption_justify="left")
        table.add_column("policy so far", overflow="ellipsis", no_wrap=True, max_width=32)
        for heading in ("episodes", "failed", "mean AUC", "covered", self._reached):
            table.add_column(heading, justify="right")
        for policy, mean in self._means.means().items():
            cells = (f"{mean.auc:.3f}", f"{mean.coverage:.1%}", f"{mean.reached:.0%}") if mean else ()
            failed = self._means.failed[policy]
            table.add_row(Text(policy), str(self._means.episodes[policy]), str(failed) if failed else "", *cells)
        return Group(*above, table)
