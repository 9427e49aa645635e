"""The progress of a comparison: episodes, rate, time left, running means of the policies, and what is compiled."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import NamedTuple

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table
from rich.text import Text

from indoor_explorers.env.grid.compile_cache import compiling_since, not_compiled
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode, Outcome
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.coverage_threshold import T99, CoverageThreshold, shared


class Figures(NamedTuple):
    """The figures of an episode, or their sums."""

    auc: float = 0.0
    coverage: float = 0.0
    """Of the team at the end, from 0 to 1."""
    reached: float = 0.0
    """1 where the team reached the coverage threshold of the scenario, else 0."""

    def plus(self, other: Figures) -> Figures:
        """Return the sums."""
        return Figures(*(mine + theirs for mine, theirs in zip(self, other, strict=True)))

    def over(self, count: int) -> Figures:
        """Return the means over this many episodes."""
        return Figures(*(value / count for value in self))


class RunningMeans:
    """Means of the policies while they fly, over the tasks that every policy seen so far has flown.

    Means over all flown episodes would favour a policy that happens to fly an easier scenario first.
    """

    def __init__(self) -> None:
        self.tasks = 0
        """How many tasks the means are over."""
        self.episodes: dict[str, int] = {}
        """Episodes flown by policy, in this run."""
        self.failed: dict[str, int] = {}
        """Those of them that failed."""
        self._flown: dict[str, dict[Task, Figures]] = {}
        self._sums: dict[str, Figures] = {}

    def add(self, record: FlownEpisode, reached: bool) -> None:
        """Add an episode; ``reached`` says whether the team reached the coverage threshold of its scenario."""
        name = record.policy
        if name not in self._flown:  # a new policy: no task is common to all any more
            self._flown[name], self.episodes[name], self.failed[name] = {}, 0, 0
            self.tasks, self._sums = 0, dict.fromkeys(self._flown, Figures())
        self.episodes[name] += 1
        self.failed[name] += record.outcome is Outcome.FAILED
        auc = record.metrics.get("auc") or 0.0
        self._flown[name][record.task] = Figures(auc, float(record.curve[-1]), float(reached))
        if all(record.task in flown for flown in self._flown.values()):
            self.tasks += 1
            self._sums = {each: self._sums[each].plus(flown[record.task]) for each, flown in self._flown.items()}

    def means(self) -> dict[str, Figures | None]:
        """Return the means of each policy, None while there is no common task."""
        return {name: sums.over(self.tasks) if self.tasks else None for name, sums in self._sums.items()}


#: Seconds between two checks of the cache folder.
CHECK_INTERVAL = 0.5


class CompileStatus:
    """Name the functions that are being compiled on this machine, by this process or by workers, and count them."""

    def __init__(self) -> None:
        self._start = time.time() - 1.0  # file systems' clocks may be behind
        self._checked = 0.0
        self._missing: set[str] = set()
        self._line = ""

    def line(self) -> str:
        """Return what is compiled now, and how many functions were of those that the policies may need, or nothing."""
        if time.monotonic() - self._checked >= CHECK_INTERVAL:
            now = compiling_since(self._start)
            self._line = self._told(now) if now else ""
            self._checked = time.monotonic()
        return self._line

    def _told(self, now: set[str]) -> str:
        missing = not_compiled()
        self._missing |= missing
        names = ", ".join(sorted({label.rpartition("-")[0] for label in now}))
        done = len(self._missing) - len(missing)
        return f"compiling {names}: {done} of at most {counted(len(self._missing), 'function')} done, once per machine"


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
