"""Why UAVs fly where they do, for the replay: embedded episodes are flown again with their policies, which explain.

What changes is packed for each UAV as whole numbers, by the step of the change; the page cuts a way at the cell of its
UAV, so that a UAV that flies along its way costs nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import floor, isfinite, log10, nan
from typing import Any

from indoor_explorers.env import Candidate, Explanation, InputError, Policy, Scenario
from indoor_explorers.env.errors import RunError, one_line
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.evaluation.harness.episodes.flight import Told, explained_again
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.stored_policy import policy_again, whole_scenario
from indoor_explorers.evaluation.report.packing import packed, text

#: Seconds of thinking, as recorded, of the episodes of a page that are flown again where nobody asks for more.
SECONDS = 2.0
#: What is said of the others.
LEFT_OUT = "not flown again, to save time; indoor-explorers report DIR --out FILE.html --explanations 60 does"
#: Most candidates of a choice.
MOST = 6
#: What changes in an entry: step, goal and note; the candidates; the way; or there is no explanation from now on.
CHOICE, CANDIDATES, WAY, NOTHING = 1, 2, 4, 8
#: Exponent of a number that is not finite.
NOT_FINITE = 127

_CODES = {(int(row), int(col)): code for code, (row, col) in enumerate(MOVES[:4])}


class Explaining:
    """Fly embedded episodes again, as many as thought at most ``seconds`` together when they were flown.

    Each scenario gets its share, with what those before it left. Without a number it is :data:`SECONDS`, and only the
    task with which the page opens a scenario is flown again.
    """

    def __init__(self, results: Results, seconds: float | None = None) -> None:
        given = SECONDS if seconds is None else seconds
        self._results, self._share, self._left = results, given / max(1, len(results.scenarios)), 0.0
        self._every, self._opening = seconds is not None, dict[str, Task]()
        self._made: dict[str, Policy | InputError] = {}
        self._scenarios: dict[str, Scenario] = {}

    def told(self, record: Record) -> dict[str, Any]:
        """Return the packed explanations of an episode, or in ``none`` why there are none."""
        try:
            return packed_explanations(record, self._again(record))
        except (InputError, RunError) as error:
            return {"none": one_line(str(error))}

    def _again(self, record: Record) -> Told:
        seconds, name = float(record.seconds[-1]), record.task.scenario
        if name not in self._opening:
            self._opening[name] = record.task
            self._left += self._share
        if record.outcome is Outcome.FAILED:
            raise RunError("the policy failed in this episode, which is not flown again")
        policy = self._policy(record.policy)
        if seconds > self._left or not (self._every or record.task == self._opening[name]):
            raise RunError(LEFT_OUT)
        self._left -= seconds
        if name not in self._scenarios:
            self._scenarios[name] = whole_scenario(self._results, name)
        return explained_again(record, self._scenarios[name], policy)

    def _policy(self, name: str) -> Policy:
        if name not in self._made:
            try:
                self._made[name] = policy_again(self._results, name)
            except InputError as error:
                self._made[name] = error
        made = self._made[name]
        if isinstance(made, InputError):
            raise made
        return made


def packed_explanations(record: Record, steps: Told) -> dict[str, Any]:
    """Return the explanations of each UAV after each step: streams of numbers by UAV, and the texts that they name."""
    texts = _Texts()
    writers = [_Writer(record.floorplan.shape[1], texts) for _ in range(record.team)]
    for step, told in enumerate(steps, 1):
        for writer, each in zip(writers, told, strict=True):
            writer.add(step, each)
    return {"texts": texts.kept, "uavs": [text(packed(writer.numbers)) for writer in writers]}


def size_of(told: Mapping[str, Any]) -> int:
    """Return the bytes that packed explanations take in a page."""
    return len(json.dumps(told, separators=(",", ":")))


class _Texts:
    """The different texts, and tuples of names, of an episode, each by its place."""

    def __init__(self) -> None:
        self.kept: list[str | list[str]] = []

    def place(self, words: str | list[str]) -> int:
        if words not in self.kept:
            self.kept.append(words)
        return self.kept.index(words)


class _Writer:
    """The numbers of one UAV: for each entry the steps since the one before, what changed, and that."""

    def __init__(self, width: int, texts: _Texts) -> None:
        self.numbers: list[int] = []
        self._width, self._texts = width, texts
        self._at = 0
        self._choice: tuple[Any, ...] | None = None
        self._candidates: tuple[Any, ...] = ()
        self._way: tuple[Cell, ...] = ()

    def add(self, step: int, told: Explanation | None) -> None:
        """Add what changed in this step."""
        if told is None:
            if self._choice is not None:
                self._entry(step, NOTHING, [])
            self._choice, self._candidates, self._way = None, (), ()
            return
        choice, candidates = (told.step, told.goal, told.note), (told.score, told.candidates[:MOST])
        kinds = CHOICE * (choice != self._choice) | CANDIDATES * (candidates != self._candidates)
        kinds |= WAY * (not _is_rest(told.path, self._way))
        parts: list[int] = []
        if kinds & CHOICE:
            parts += [max(step - told.step, 0), self._place(told.goal), self._texts.place(told.note)]
        if kinds & CANDIDATES:
            parts += self._compared(told.score, told.candidates[:MOST])
        if kinds & WAY:
            parts += self._steps_of(told.path)
            self._way = told.path
        if kinds:
            self._entry(step, kinds, parts)
        self._choice, self._candidates = choice, candidates

    def _entry(self, step: int, kinds: int, parts: Sequence[int]) -> None:
        self.numbers += [step - self._at, kinds, *parts]
        self._at = step

    def _place(self, cell: Cell | None) -> int:
        """Return 1 and the flat cell; 0 for none."""
        return 0 if cell is None else 1 + cell[0] * self._width + cell[1]

    def _compared(self, score: str, candidates: Sequence[Candidate]) -> Iterator[int]:
        names = list(candidates[0].parts) if candidates else []
        yield from (self._texts.place(score), self._texts.place(names), len(candidates))
        for each in candidates:
            yield self._place(each.cell)
            for value in (each.score, *(each.parts.get(name, nan) for name in names)):
                yield from number(value)

    def _steps_of(self, way: Sequence[Cell]) -> Iterator[int]:
        """Yield the number of runs, the first cell, and the runs: 5 times the length, and the direction.

        What is no step to a neighbour is a run of direction 4 with the cell that it leads to.
        """
        runs: list[list[int]] = []
        for one, other in pairwise(way):
            code = _CODES.get((other[0] - one[0], other[1] - one[1]), 4)
            if runs and code < 4 and runs[-1][0] % 5 == code:
                runs[-1][0] += 5
            else:
                runs.append([5 + code] if code < 4 else [4, self._place(other)])
        yield len(runs)
        yield self._place(way[0] if way else None)
        for run in runs:
            yield from run


def number(value: float) -> tuple[int, int]:
    """Return the exponent to base ten and the mantissa, both folded, of a number with three significant digits."""
    if not isfinite(value):
        return _folded(NOT_FINITE), 0
    exponent = 0 if value == round(value, 0) and abs(value) < 1000 else floor(log10(abs(value))) - 2
    return _folded(exponent), _folded(round(value / 10.0**exponent))


def _folded(value: int) -> int:
    return 2 * value if value >= 0 else -2 * value - 1


def _is_rest(way: tuple[Cell, ...], before: tuple[Cell, ...]) -> bool:
    """Tell whether a way is the end of the one before."""
    return way == before or bool(way and way == before[len(before) - len(way) :])
