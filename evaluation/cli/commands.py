"""What each command of the command line does."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from importlib.metadata import EntryPoint
from pathlib import Path

from rich.console import Console
from rich.table import Table

from indoor_explorers.env import PRESETS, InputError, make_policy, run_checks
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.registry import missing_module, opener_entry_points, policy_entry_points
from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation import bench
from indoor_explorers.evaluation.ablation import run_ablation
from indoor_explorers.evaluation.cli.check_table import print_findings, print_header
from indoor_explorers.evaluation.cli.map_text import facts, picture
from indoor_explorers.evaluation.cli.progress import ProgressBar
from indoor_explorers.evaluation.cli.watch import watch
from indoor_explorers.evaluation.driver import run
from indoor_explorers.evaluation.experiment.planning import plan
from indoor_explorers.evaluation.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.exports import write_exports
from indoor_explorers.evaluation.report import write_report
from indoor_explorers.evaluation.report.analysis.failures import by_cause, failed
from indoor_explorers.evaluation.report.changes.against import compare_with
from indoor_explorers.evaluation.report.changes.against_table import against_lines
from indoor_explorers.evaluation.report.tables.headline_table import headline_table
from indoor_explorers.evaluation.report.tables.ratio_table import ratio_lines
from indoor_explorers.evaluation.results.combine import combined
from indoor_explorers.evaluation.results.coverage_threshold import threshold_of
from indoor_explorers.evaluation.results.ratios import Ratios
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.thesis import run_thesis
from indoor_explorers.evaluation.training import preset_of, run_training

#: Characters of a line where the output is no terminal.
PLAIN_WIDTH = 120


def _console() -> Console:
    console = Console()
    return console if console.is_terminal else Console(width=PLAIN_WIDTH)


def run_compare(arguments: argparse.Namespace) -> int:
    """Fly what is missing and print the headline table."""
    console = _console()
    given = {name: value for name, value in vars(arguments).items() if name in ComparisonRequest.model_fields}
    request = ComparisonRequest.of(**given)
    experiment = plan(request)
    levels = {scenario.name: threshold_of(scenario.goal) for scenario in experiment.scenarios}
    with ProgressBar(console, levels) as bar:
        results = run(experiment, arguments.out, request, watcher=bar, command=arguments.words)
    console.print(headline_table(results, console.width))
    _print_ratios(results, request.ratio_to, console)
    console.print(f"Report: {arguments.out / 'report.html'}", highlight=False, soft_wrap=True)
    return _status(results, console)


def _print_ratios(results: Results, asked: Sequence[str] | None, console: Console) -> None:
    for part in ratio_lines(Ratios.of(results, asked)) if asked else ():
        console.print(part, highlight=False)


def _status(results: Results, console: Console) -> int:
    broken = failed(results.records)
    flown = Counter(record.policy for record in results.records)
    for records in by_cause(broken):
        first = records[0]
        console.print(
            f"failed: {first.policy} in {len(records)} of {flown[first.policy]} episodes, first on "
            f"{first.task.scenario}, seed {first.task.seed}, step {first.steps}: {first.reason}",
            style="red",
            markup=False,
            soft_wrap=True,
        )
    return 1 if broken else 0


def run_watch(arguments: argparse.Namespace) -> int:
    """Fly one episode in a window, or into a file."""
    request = ComparisonRequest(
        policies=(arguments.policy,),
        scenario=arguments.scenario,
        maps=() if arguments.maps is None else (arguments.maps,),
        resolution=arguments.resolution,
        team=arguments.team,
        episodes=1,
        seed=arguments.seed,
        settings=arguments.settings,
    )
    experiment = plan(request)
    watch(experiment, _console(), save=arguments.save, steps=arguments.steps, fps=arguments.fps)
    return 0


def run_report(arguments: argparse.Namespace) -> int:
    """Rebuild a report from one folder, or combine several; say what changed against another."""
    results = combined([Results.load(folder) for folder in arguments.folders])
    against = compare_with(results, Results.load(arguments.against)) if arguments.against is not None else None
    try:
        write_report(results, arguments.out, against=against, replays=arguments.replays, ratio_to=arguments.ratio_to)
        if arguments.exports is not None:
            write_exports(results, arguments.exports, ratio_to=arguments.ratio_to)
    except OSError as error:
        where = error.filename or arguments.out
        raise InputError(f"{where}: cannot be written: {error.strerror}; choose another --out or --exports") from error
    console = _console()
    for part in against_lines(against) if against is not None else ():
        console.print(part, highlight=False)
    _print_ratios(results, arguments.ratio_to, console)
    console.print(f"Report: {arguments.out}", highlight=False, soft_wrap=True)
    return 0


def run_train(arguments: argparse.Namespace) -> int:
    """Train a learner on a scenario, both given or a preset's."""
    preset = None if arguments.preset is None else preset_of(arguments.learner, arguments.preset)
    settings = dict(arguments.settings)
    seed = arguments.seed
    return run_training(
        arguments.learner,
        named_scenario(arguments.scenario or (preset.scenario if preset else "thesis-obstacles")),
        {**preset.settings, **settings} if preset else settings,
        out=arguments.out,
        seed=seed if seed is not None else (preset.seed if preset else 1),
        resume=arguments.resume,
    )


def run_ablate(arguments: argparse.Namespace) -> int:
    """Train a learner's variants and say what each ingredient is worth; the status is 1 where a training failed."""
    console = _console()
    failures = run_ablation(
        arguments.learner,
        arguments.scenario,
        arguments.out,
        console,
        patterns=[pattern for patterns in arguments.only for pattern in patterns],
        settings=dict(arguments.settings),
        seeds=arguments.seeds,
        jobs=arguments.jobs,
        episodes=arguments.episodes,
        command=arguments.words,
    )
    for order, reason in failures:
        console.print(f"failed: {order.title}: {reason}", style="red", markup=False, soft_wrap=True)
    return 1 if failures else 0


def run_thesis_experiments(arguments: argparse.Namespace) -> int:
    """Fly the thesis's experiments and write the page about them."""
    console = _console()
    run_thesis(
        arguments.out,
        console,
        episodes=arguments.episodes,
        version_names=arguments.versions,
        patterns=arguments.only,
        settings=dict(arguments.settings),
        seed=arguments.seed,
    )
    console.print(f"Page: {arguments.out / 'thesis.html'}", highlight=False, soft_wrap=True)
    return 0


def list_policies(arguments: argparse.Namespace) -> int:
    """Print the installed policies."""
    table = Table("policy", "what it is", "from", box=None, header_style="bold")
    for name, entry in policy_entry_points().items():
        table.add_row(name, _about(entry), entry.dist.name if entry.dist else "")
    for name, entry in opener_entry_points().items():
        table.add_row(f"{name}:PATH", _about(entry), entry.dist.name if entry.dist else "")
    _console().print(table)
    return 0


def _about(entry: EntryPoint) -> str:
    try:
        return (entry.load().__doc__ or "").strip().partition("\n")[0]
    except ModuleNotFoundError as error:
        return missing_module(error)


def list_scenarios(arguments: argparse.Namespace) -> int:
    """Print the preset scenarios."""
    headings = ("scenario", "map", "UAVs", "lidar", "radio", "goal", "steps", "stuck", "step, cell, goal")
    table = Table(*headings, box=None, header_style="bold")
    for name, preset in PRESETS.items():
        rows, cols = preset.map.floorplan(0, 0).shape
        pay = preset.rewards
        reach = "" if preset.radio.model in {"none", "unlimited"} else f" {preset.radio.range:g}"
        radio = preset.radio.model + reach
        table.add_row(
            *(name, f"{rows} x {cols}", str(preset.team), f"{preset.lidar.range:g} cells", radio),
            *(f"{preset.goal:.0%} of {preset.denominator}", str(preset.budget), preset.stuck.rule),
            f"{pay.step:+g}, {pay.discovered:+g}, {pay.goal:+g}",
        )
    _console().print(table)
    return 0


def show_maps(arguments: argparse.Namespace) -> int:
    """Print a picture and the facts of map files, or of the maps that a scenario's seed makes."""
    console = _console()
    for floorplan in _maps_of(arguments):
        console.print(picture(floorplan, console.width), highlight=False, markup=False, soft_wrap=True)
        console.print(facts(floorplan), highlight=False, markup=False, soft_wrap=True)
    return 0


def _maps_of(arguments: argparse.Namespace) -> Iterator[Floorplan]:
    if bool(arguments.paths) == bool(arguments.scenario):
        got = "both" if arguments.paths else "neither"
        raise InputError(f"expected the paths of map files or a --scenario, got {got}; see maps --help")
    if not arguments.scenario and (arguments.settings or arguments.seed is not None):
        raise InputError("expected --scenario with --seed and --set, got map files, which have none; leave them out")
    if arguments.scenario and arguments.resolution is not None:
        raise InputError("expected map files with --resolution, got --scenario; use --set map.resolution=... instead")
    yield from (read_map(Path(path), arguments.resolution) for path in arguments.paths)
    if arguments.scenario:
        task = named_scenario(arguments.scenario).with_settings(dict(arguments.settings))
        yield from (draw_floorplan(task, arguments.seed or 0, index) for index in range(task.map.count))


def check(arguments: argparse.Namespace) -> int:
    """Run the whole conformance suite on a policy and print what it found; the status is 1 where a check fails."""
    policy, console = make_policy(arguments.policy), _console()
    print_header(console, arguments.policy, policy)
    with console.status("checking") if console.is_terminal else nullcontext():
        findings = list(run_checks(policy))
    print_findings(console, findings)
    failures = [finding.error for finding in findings if finding.error is not None]
    if failures and arguments.debug:
        raise failures[0]
    return 1 if failures else 0


def run_bench(arguments: argparse.Namespace) -> int:
    """Measure the speed figures and print them as they come."""
    console = _console()
    growing = arguments.growth or arguments.figures is not None
    measures = bench.measures(everything=arguments.all or bool(arguments.only), growing=growing)
    if arguments.only:
        wanted = [*arguments.only, *(["growth-*"] if growing else [])]
        measures = bench.chosen(measures, wanted)
    figures = list(bench.measured(measures, console))
    if arguments.json is not None:
        bench.write_json(figures, arguments.json)
    if arguments.figures is not None:
        for path in bench.write_growth(figures, arguments.figures):
            console.print(f"Figure: {path}", highlight=False, soft_wrap=True)
    return 0
