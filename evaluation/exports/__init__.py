"""Files for other programs and for papers: tables, figures, experiments, and a database for Planner Arena."""

from collections.abc import Sequence
from pathlib import Path

from indoor_explorers.env.files import write_whole
from indoor_explorers.evaluation.analysis.best_planner import against_best_planner, write_best_planner
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.reproduce import experiment_files
from indoor_explorers.evaluation.analysis.tables.reported_table import reported_csv, reported_tables
from indoor_explorers.evaluation.exports.figures import write_figures
from indoor_explorers.evaluation.exports.latex import latex_tables
from indoor_explorers.evaluation.exports.markdown import markdown_ratios, markdown_tables
from indoor_explorers.evaluation.exports.planner_arena import write_planner_arena
from indoor_explorers.evaluation.exports.scenario_tables import scenario_tables
from indoor_explorers.evaluation.exports.tidy import write_curves, write_episodes
from indoor_explorers.evaluation.harness.results.differences import differences, write_differences
from indoor_explorers.evaluation.harness.results.origin_ratios import ratios_by_origin, write_origin_ratios
from indoor_explorers.evaluation.harness.results.ratios import Ratios, write_ratios
from indoor_explorers.evaluation.harness.results.results import Results, write_csv, write_summary

__all__ = ["write_exports"]


def write_exports(results: Results, folder: Path, *, ratio_to: Sequence[str] | None = None) -> None:
    """Write everything but the report into ``folder``; equal results give equal bytes.

    ``ratio_to`` names the baselines of ratios and differences of steps, see
    :func:`~indoor_explorers.evaluation.harness.experiment.selection.chosen_baselines`.
    """
    tables = folder / "tables"
    tables.mkdir(parents=True, exist_ok=True)
    write_summary(results, folder / "summary.csv")
    write_episodes(results, tables / "results.csv")
    write_curves(results, tables / "curves.csv")
    ratios = Ratios.of(results, ratio_to)
    write_ratios(ratios, tables / "ratios.csv")
    if by_origin := ratios_by_origin(ratios):
        write_origin_ratios(by_origin, tables / "ratios_by_origin.csv")
    best = against_best_planner(Comparison(results.on_common_tasks, name) for name in results.scenarios)
    if best:
        write_best_planner(best, tables / "best_planner.csv")
    write_differences(differences(results, ratios.to), tables / "differences.csv")
    texts = {folder / name: text for name, text in experiment_files(results).items()}
    shown = scenario_tables(results) + reported_tables(results)
    if results.reported:
        write_csv(reported_csv(results), tables / "reported.csv", "%.6g")
    texts |= {tables / "results.md": markdown_tables(shown), tables / "results.tex": latex_tables(shown)}
    texts |= {tables / "ratios.md": markdown_ratios(ratios, best)}
    for path, text in texts.items():
        write_whole(path, text)
    write_planner_arena(results, folder / "planner-arena.db")
    write_figures(results, folder / "figures", best)
