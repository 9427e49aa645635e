"""The function behind the compare command."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Any

from indoor_explorers.env.files import expanded
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest

if TYPE_CHECKING:
    from indoor_explorers.evaluation.driver import Watcher
    from indoor_explorers.evaluation.exports.summary_table import SummaryTable


def compare(out: str | Path, *, watcher: Watcher | None = None, command: str = "", **options: Any) -> SummaryTable:
    """Compare policies and return the summary: a DataFrame with the rows of ``summary.csv``.

    ``print`` shows T90, T99 and AUC of each policy with their intervals; ``table.wide(["t90", "path_length"])`` has the
    means of any metrics.

    Writes ``out/results.db``, ``report.html``, and what :func:`~indoor_explorers.evaluation.exports.write_exports`
    does. Plug-in policies are first checked for hidden knowledge, and marked if they fail; they decide in processes
    that never have the true map. Episodes that ``out/results.db`` already holds are not flown again, except failed ones
    with ``retry_failed``. A policy that breaks costs only its own episodes. With 0 workers plug-ins are neither checked
    nor isolated, and episodes are flown in this process, where a policy that hangs, leaks memory or ends the process is
    not caught.

    Args:
        out: the folder of the results; it is made where there is none.
        watcher: receives the progress.
        command: the command that was typed; the report shows it.
        **options: those of ``indoor-explorers compare``, which are the fields of
            :class:`~indoor_explorers.evaluation.harness.experiment.request.ComparisonRequest`: ``policies``,
            ``scenario``, ``experiment``, ``suite``, ``part``, ``data``, ``radio``, ``maps``, ``resolution``, ``team``,
            ``episodes``, ``seed``, ``settings``, ``workers``, ``engine``, ``address``, ``decision_timeout`` (seconds,
            None for none), ``memory_limit`` (GB per worker), ``isolate``, ``retry_failed``, ``refly``, ``fresh``,
            ``ratio_to``, ``margin``.

    Raises:
        InputError: something asked for does not exist or does not fit together.
        RunError: the disk is full, or no worker can be started; episodes stored before that are kept.

    """
    # imported here, so that the command line shows its help at once
    from indoor_explorers.evaluation.driver import run
    from indoor_explorers.evaluation.exports.summary_table import SummaryTable
    from indoor_explorers.evaluation.harness.experiment.planning import plan

    request = ComparisonRequest.of(**options)
    return SummaryTable(run(plan(request), expanded(out), request, watcher=watcher, command=command).summary())


def _signature() -> inspect.Signature:
    """Return the signature of :func:`compare` with every option in it, for ``help``."""
    own = inspect.signature(compare)
    first, *named = (part for part in own.parameters.values() if part.kind is not inspect.Parameter.VAR_KEYWORD)
    fields = ComparisonRequest.model_fields
    options = [
        part.replace(annotation=fields[name].annotation)
        for name, part in ComparisonRequest.__signature__.parameters.items()
    ]
    return own.replace(parameters=[first, *options, *named])


compare.__signature__ = _signature()  # type: ignore[attr-defined]
