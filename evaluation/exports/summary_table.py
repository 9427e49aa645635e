"""The summary of a comparison as a table that prints itself in a line for each policy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from indoor_explorers.evaluation.drawing.formatting import EN_DASH, percent, with_interval
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.results.results import SUMMARY_COLUMNS
from indoor_explorers.evaluation.statistics import Estimate

#: The metrics that are printed.
PRINTED = ("t90", "t99", "auc")
#: The printed share of episodes that reach the threshold of a time.
REACHED, REACHED_TIME = "99 % reached", "t99"


class SummaryTable(pd.DataFrame):  # type: ignore[misc]  # pandas ships no types
    """The rows of ``summary.csv``: a DataFrame whose print has a line for each scenario and policy.

    What is selected or computed from it is an ordinary DataFrame.
    """

    @property
    def _constructor(self) -> Any:
        return pd.DataFrame

    def wide(self, metrics: Sequence[str] = PRINTED) -> pd.DataFrame:
        """Return the means with a row for each scenario and policy, in their order, and a column for each metric."""
        return self._spread(metrics, lambda row: row["mean"])

    def __repr__(self) -> str:
        """Return T90, T99 and AUC of each policy with their intervals, and the share that reached 99 %, as text."""
        return str(self._printed().to_string()) if self._is_whole() else str(super().__repr__())

    def _repr_html_(self) -> Any:
        return self._printed()._repr_html_() if self._is_whole() else super()._repr_html_()

    def _is_whole(self) -> bool:
        return tuple(self.columns) == SUMMARY_COLUMNS and len(self) > 0

    def _printed(self) -> pd.DataFrame:
        titles = {name: MEASURES[name].title for name in PRINTED}
        printed = self._spread(PRINTED, _cell)
        reached = self._spread(PRINTED, lambda row: percent(row["success"]))[REACHED_TIME]
        printed.insert(PRINTED.index(REACHED_TIME) + 1, REACHED, reached)
        return printed.rename(columns=titles).astype(object).fillna(EN_DASH)

    def _spread(self, metrics: Sequence[str], cell: Any) -> pd.DataFrame:
        kept = self[self["metric"].isin(metrics)]
        keys = ["scenario", "policy"] if kept["scenario"].nunique() > 1 else ["policy"]
        cells: dict[Any, dict[str, Any]] = {}
        for _, row in kept.iterrows():
            cells.setdefault(tuple(row[key] for key in keys), {})[row["metric"]] = cell(row)
        index = pd.MultiIndex.from_tuples(list(cells), names=keys) if len(keys) > 1 else None
        rows = pd.DataFrame(list(cells.values()), index=index, columns=list(metrics))
        return rows if index is not None else rows.set_axis(pd.Index([key[0] for key in cells], name="policy"))


def _cell(row: Any) -> str:
    estimate = Estimate(row["mean"], *(None if pd.isna(row[end]) else row[end] for end in ("low", "high")))
    return with_interval(estimate, 3 if row["metric"] == "auc" else 1)
