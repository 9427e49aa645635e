"""``maps``: draw maps and print their facts, or compare them with scenarios; ``maps audit``: find maps in a folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, get_args

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import (
    DATA_FOLDERS,
    NO_SETTINGS,
    RESOLUTION,
    SEED,
    Option,
    Request,
    Settings,
    SuitePart,
    read_count,
    read_names,
    read_share,
)

if TYPE_CHECKING:
    from indoor_explorers.env.maps.floorplan import Floorplan
    from indoor_explorers.evaluation.studies.maps.audit import Audit, AuditedMap

#: Maps of each generator in a comparison.
SAMPLES = 100
#: Matches that ``maps audit`` lists without ``--out``.
MOST_LISTED = 10


class MapsOptions(Request):
    """The options of ``maps``."""

    paths: Annotated[tuple[Path, ...], Option(metavar="PATH", several=True, positional=True)] = ()
    """Map files: .yaml, .png, .pgm, .bmp, .map, .npy, .json, .xml, .building.yaml, .bt, .stl, .ply, .obj, .pcd."""
    resolution: Annotated[float | None, RESOLUTION] = None
    """Metres per cell to resample map files to. Pictures have no scale: a pixel of theirs counts as 1 m."""
    scenario: Annotated[str | None, Option(metavar="PRESET|FILE.toml")] = None
    """Show the maps of this scenario instead."""
    seed: Annotated[int | None, SEED] = None
    """Seed of the scenario's map (default 0)."""
    settings: Settings = NO_SETTINGS
    """Settings such as map.height=128, or, for map files, map.building.storey=L1."""
    suite: Annotated[str | None, Option(metavar="NAME")] = None
    """Tell the facts and kinds of all maps of a part of this suite instead, without pictures."""
    part: Annotated[SuitePart, Option(choices=get_args(SuitePart))] = "test"
    """Which part of the suite."""
    data: DATA_FOLDERS = ()
    """Where the suite's map files are: clones of their repositories, or folders that have the clones in them."""
    save: Annotated[Path | None, Option(metavar="FILE.png|.npy|.bt")] = None
    """Write the map for --maps: as a picture, a pixel a cell and white where it is free, an array, or an OctoMap."""
    compare: Annotated[tuple[str, ...], Option(metavar="PRESET|FILE.toml,...", read=read_names)] = ()
    """Say instead how far the maps of these scenarios are from the map files, statistic by statistic."""
    samples: Annotated[int | None, Option(metavar="N", read=read_count)] = None
    """Maps of each generator to compare (default 100)."""
    figures: Annotated[Path | None, Option(metavar="DIR")] = None
    """Draw the comparison as maps.svg/.png in DIR."""


def show_maps(options: MapsOptions, typed: str) -> int:
    """Print a picture and the facts of map files, or of the maps of a scenario."""
    from indoor_explorers.env.maps.kinds import statistics_of
    from indoor_explorers.evaluation.cli.map_text import cautions, facts, kinds, layout, picture, statistics

    if options.compare:
        return _compare(options)
    console, given = make_console(), list(_floorplans(options))
    floorplans, of_source = [floorplan for _, floorplan in given], []
    for (source, floorplan), path in zip_longest(given, options.paths):
        found = statistics_of(floorplan)
        of_source.append((source, found.kind))
        if not options.suite:
            print_line(console, picture(floorplan, console.width))
        print_line(console, facts(floorplan))
        print_line(console, layout(floorplan))
        print_line(console, statistics(floorplan, found))
        for line in cautions(floorplan, path, options.resolution):
            print_line(console, line, "yellow")
    for line in kinds(of_source) if len(given) > 1 else ():
        print_line(console, line, "bold")
    if options.save is not None:
        _save(floorplans, options.save)
        print_line(console, f"Map: {options.save}")
    return 0


def _save(floorplans: Sequence[Floorplan], path: Path) -> None:
    """Write one map to a file."""
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.env.files import writable, written_whole
    from indoor_explorers.env.maps.files import write_map

    if len(floorplans) != 1:
        raise InputError(f"expected one map with --save, got {len(floorplans)} maps")
    with writable(path, "--save"), written_whole(path) as partial:
        write_map(floorplans[0], partial, path.suffix.lower())


def _floorplans(options: MapsOptions) -> Iterator[tuple[str, Floorplan]]:
    """Yield the maps that are asked for, each after its source."""
    from indoor_explorers.env.maps.sources import FileMaps
    from indoor_explorers.env.scenarios.loading import named_scenario
    from indoor_explorers.env.scenarios.presets import on_files
    from indoor_explorers.env.scenarios.suites.catalogue import source_of, suite_of
    from indoor_explorers.env.scenarios.suites.clones import maps_of
    from indoor_explorers.env.scenarios.suites.suite import Part
    from indoor_explorers.env.simulation.spawns import draw_floorplan

    _refuse_contradictions(options)
    if options.scenario:
        scenario = named_scenario(options.scenario).with_settings(options.settings)
        indices, maps = range(scenario.map.count), scenario.map
        plans = [(index, draw_floorplan(scenario, options.seed or 0, index)) for index in indices]
    elif options.suite:
        suite, part = suite_of(options.suite), Part(options.part)
        maps = maps_of(suite, part, options.data)
        seeds = suite.seeds(part) if maps.generated else range(1)
        plans = [(index, maps.floorplan(index, seed)) for seed in seeds for index in range(maps.count)]
    else:
        files = on_files(tuple(map(str, options.paths)), options.resolution)
        maps = files.with_settings(options.settings).map
        assert isinstance(maps, FileMaps)
        plans = [(index, maps.alone(index).floorplan(0, 0)) for index in range(maps.count)]
    return ((source_of(maps, index, plan), plan) for index, plan in plans)


def _refuse_contradictions(options: MapsOptions) -> None:
    from indoor_explorers.env.errors import InputError

    if options.samples is not None or options.figures is not None:
        raise InputError("expected --compare with --samples and --figures, got neither scenario; leave them out")
    if sum(map(bool, (options.paths, options.scenario, options.suite))) != 1:
        got = "several" if options.paths or options.scenario or options.suite else "none"
        raise InputError(f"expected the paths of map files, a --scenario or a --suite, got {got}; see maps --help")
    if not options.scenario and options.seed is not None:
        raise InputError("expected --scenario with --seed, got maps that have none; leave it out")
    if options.suite and options.settings:
        raise InputError("expected --scenario or map files with --set, got a suite; leave it out")
    if not options.paths and options.resolution is not None:
        raise InputError("expected map files with --resolution, got other maps; use --set map.resolution=... instead")


def _compare(options: MapsOptions) -> int:
    """Print how far the maps of scenarios are from map files."""
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.env.maps.files import read_map
    from indoor_explorers.env.scenarios.loading import named_scenario
    from indoor_explorers.evaluation.studies.maps.comparison import comparison_table, maps_of, measured
    from indoor_explorers.evaluation.studies.maps.drawing import write_comparison

    if options.scenario or not options.paths:
        raise InputError("expected the paths of map files with --compare and no --scenario; see maps --help")
    console, seed = make_console(), options.seed or 0
    scenarios = {name: named_scenario(name).with_settings(options.settings) for name in options.compare}
    plans = [read_map(path, options.resolution) for path in options.paths]
    given = measured("files", plans, next(iter(scenarios.values())), seed)
    others = []
    for name, scenario in scenarios.items():
        maps = maps_of(scenario, options.samples or SAMPLES, seed)
        others.append(measured(Path(name).stem, maps, scenario, seed))
    console.print_table(comparison_table(given, others))
    print_line(console, "Wasserstein distances to the files, in standard deviations of theirs; 0: alike", "dim")
    if options.figures is not None:
        for path in write_comparison(given, others, options.figures):
            print_line(console, f"Figure: {path}")
    return 0


MAPS = Command(MapsOptions, show_maps)


class AuditOptions(Request):
    """The options of ``maps audit``."""

    train: Annotated[Path, Option(metavar="TRAIN", positional=True)]
    """A folder of map files to train on, or one file."""
    test: Annotated[Path, Option(metavar="TEST", positional=True)]
    """A folder of map files to test on, or one file."""
    near: Annotated[float, Option(metavar="SHARE", read=read_share)] = 0.9
    """Overlap of free cells from which on two maps are near copies."""
    resolution: Annotated[float | None, RESOLUTION] = None
    """Metres per cell to resample all maps to before they are compared."""
    out: Annotated[Path | None, Option(metavar="FILE.csv")] = None
    """Write all matches, a line each: test map, training map, how they are alike, overlap."""


def audit_maps(options: AuditOptions, typed: str) -> int:
    """Print how many test maps are in a training folder, as they are, turned, rescaled or nearly."""
    from indoor_explorers.env.files import writable
    from indoor_explorers.evaluation.studies.maps.audit import audited, write_matches

    console = make_console()
    audit = audited(
        _read_folder(options.train, options.resolution),
        _read_folder(options.test, options.resolution),
        options.near,
        options.resolution,
    )
    for line in _audit_lines(audit):
        print_line(console, line)
    if options.out is not None:
        with writable(options.out, "--out"):
            write_matches(audit.matches, options.out)
        print_line(console, f"Matches: {options.out}")
        return 0
    for match in audit.matches[:MOST_LISTED]:
        print_line(console, f"{match.test} in {match.train}: {match.kind}, overlap {match.overlap:.2f}", "dim")
    if len(audit.matches) > MOST_LISTED:
        print_line(console, f"and {len(audit.matches) - MOST_LISTED} more; --out FILE.csv writes all", "dim")
    return 0


def _read_folder(place: Path, resolution: float | None) -> list[AuditedMap]:
    from rich.progress import track

    from indoor_explorers.evaluation.studies.maps.audit import AuditedMap, map_files

    files, console = map_files(place), make_console()
    shown = track(files, f"Reading {place}", console=console, transient=True, disable=not console.is_terminal)
    return [AuditedMap.read(path, resolution) for path in shown]


def _audit_lines(audit: Audit) -> list[str]:
    train, test = audit.layouts
    found = ", ".join(f"{count} {kind}" for kind, count in audit.counts.items())
    return [
        f"to train on: {len(audit.train)} maps, {train} different layouts",
        f"to test on: {len(audit.test)} maps, {test} different layouts",
        f"test maps that are among those to train on: {len(audit.matches)} ({found})",
    ]


AUDIT = Command(AuditOptions, audit_maps)
