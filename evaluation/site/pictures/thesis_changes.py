"""The greedy evaluations of the thesis's learner with two changes, apart and together."""

from __future__ import annotations

from matplotlib.figure import Figure

from indoor_explorers.evaluation.site.pictures.drawing import svg
from indoor_explorers.evaluation.site.pictures.map_marks import legend as map_legend
from indoor_explorers.evaluation.site.pictures.thesis import ROW, WIDTH
from indoor_explorers.evaluation.site.pictures.thesis_lines import LABELS, curve_legend, draw_greedy
from indoor_explorers.evaluation.site.studies.thesis import VERSIONS
from indoor_explorers.evaluation.site.studies.thesis_changes import ChangedTraining, measured

#: What a panel is called after its changes.
NAMES = {"centred": "centred", "terminal_reward": "small rewards"}


def thesis_changes_pictures() -> dict[str, bytes]:
    """Return the SVG file of the page by name."""
    return {"changed-learner.svg": svg(_changes)}


def _changes(figure: Figure) -> None:
    """Draw a panel for each version and its changes."""
    groups: dict[str, list[ChangedTraining]] = {}
    for training in measured():
        groups.setdefault(_title(training), []).append(training)
    rows = -(-len(groups) // 2)
    figure.set_size_inches(WIDTH, rows * ROW + 0.5)
    panels = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False)
    for axes, (title, trainings) in zip(panels.flat, groups.items(), strict=False):
        for training in trainings:
            draw_greedy(axes, training.greedy.__getitem__, training.seed)
        axes.set_title(title)
        axes.label_outer()
    map_legend(figure, curve_legend(greedy=True, seeds=True), 3)


def _title(training: ChangedTraining) -> str:
    made = [NAMES[name] for name in training.changes]
    version = LABELS[VERSIONS.index(training.version)]
    return ", ".join([version, *(["both"] if len(made) == len(NAMES) else made)])
