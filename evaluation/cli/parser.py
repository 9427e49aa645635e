"""The command line: ``indoor-explorers compare | watch | report | train | ablate | thesis | bench | ...``."""

from __future__ import annotations

import argparse
import errno
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from indoor_explorers.env import InputError, PolicyError
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.cli import commands
from indoor_explorers.evaluation.cli.arguments import add_options
from indoor_explorers.evaluation.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.options import (
    read_count,
    read_metres,
    read_names,
    read_natural,
    read_rate,
    read_setting,
)

#: Exit statuses.
OK, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130
#: What the system says when a file finds no room: full disk, full quota, file too large.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class _Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message}; see {self.prog} --help")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command."""
    parser = _Parser(prog="indoor-explorers", description="Compare exploration policies for teams of UAVs.")
    commands_ = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=_Parser)
    _add_compare(commands_.add_parser("compare", help="fly policies on the same tasks and write a report"))
    _add_watch(commands_.add_parser("watch", help="watch a policy fly one episode, or save it as a video"))
    _add_report(commands_.add_parser("report", help="rebuild a report, or combine several results"))
    _add_train(commands_.add_parser("train", help="train a learner: the DDDQN, or a baseline through another library"))
    _add_ablate(commands_.add_parser("ablate", help="train a learner without each of its ingredients, and compare"))
    _add_thesis(commands_.add_parser("thesis", help="fly every experiment of the IndoorExplorers thesis again"))
    listing = commands_.add_parser("policies", help="list the installed policies")
    listing.set_defaults(run=commands.list_policies)
    listing = commands_.add_parser("scenarios", help="list the preset scenarios")
    listing.set_defaults(run=commands.list_scenarios)
    _add_maps(commands_.add_parser("maps", help="show map files, or what a scenario generates, and their facts"))
    _add_bench(commands_.add_parser("bench", help="measure the speed figures on this machine"))
    check = commands_.add_parser("check", help="run the conformance suite on a policy")
    check.add_argument("policy", metavar="MODULE:CLASS", help="or the name of an installed policy, or NAME:PATH")
    check.set_defaults(run=commands.check)
    return parser


def _add_settings(parser: argparse.ArgumentParser, about: str) -> None:
    parser.add_argument(
        "--set", dest="settings", type=read_setting, nargs="+", action="extend", default=[], metavar="key=value",
        help=about,
    )  # fmt: skip


def _add_ratio_to(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ratio-to", type=read_names, metavar="a,b,...",
        help="""print steps as ratios to these policies' on the same tasks (tables and page have them in any case: to
        frontier-nearest, or else the first policy, and to policies that know the map)""",
    )  # fmt: skip


def _add_compare(parser: argparse.ArgumentParser) -> None:
    add_options(parser, ComparisonRequest)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="results; resumed when it exists")
    parser.set_defaults(run=commands.run_compare)


def _add_watch(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--policy", required=True, metavar="NAME", help="a name, NAME:PATH such as sb3:DIR, or module:Class"
    )
    parser.add_argument("--scenario", metavar="PRESET|FILE.toml", help="the task (default thesis-obstacles)")
    parser.add_argument("--maps", metavar="PATH", help="a map file to explore instead")
    parser.add_argument("--resolution", type=read_metres, metavar="METRES", help="metres a cell to resample to")
    parser.add_argument("--team", type=read_count, metavar="N", help="UAVs")
    parser.add_argument(
        "--seed", type=read_natural, default=0, metavar="S", help="the episode that compare flies for it"
    )
    _add_settings(parser, "scenario settings such as goal=0.9 or radio.range=3")
    parser.add_argument("--save", type=Path, metavar="FILE", help="write a .gif, an .mp4, or the last moment as a .png")
    parser.add_argument("--steps", type=read_count, metavar="N", help="stop after N steps")
    parser.add_argument("--fps", type=read_rate, metavar="N", help="frames a second (default 8; long videos up to 25)")
    parser.set_defaults(run=commands.run_watch, interrupted="nothing was written")


def _add_maps(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths", nargs="*", metavar="PATH", help="map files: .yaml, .png, .pgm, .bmp, .map, .npy, .json"
    )
    parser.add_argument("--resolution", type=read_metres, metavar="METRES", help="metres a cell to resample to")
    parser.add_argument("--scenario", metavar="PRESET|FILE.toml", help="show the maps of this scenario instead")
    parser.add_argument("--seed", type=read_natural, metavar="S", help="makes the map of a scenario (default 0)")
    _add_settings(parser, "scenario settings such as map.height=128")
    parser.set_defaults(run=commands.show_maps)


def _add_report(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders that compare has written")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.html", help="the page to write")
    parser.add_argument("--against", type=Path, metavar="OLD", help="say what changed since the results of this folder")
    _add_ratio_to(parser)
    parser.add_argument(
        "--replays", type=read_natural, metavar="N",
        help="replay N episodes of each scenario (default: as many as keep the page under 10 MB)",
    )  # fmt: skip
    parser.add_argument(
        "--exports", type=Path, metavar="DIR",
        help="also write summary, tables, figures, experiments and planner-arena.db",
    )  # fmt: skip
    parser.set_defaults(run=commands.run_report)


def _add_train(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--learner", default="dddqn", metavar="NAME", help="what learns: dddqn (default), sb3-ppo, ...")
    parser.add_argument(
        "--preset",
        metavar="NAME",
        help="scenario, hyperparameters and seed of weights that ship, or of a quick training, where not given here",
    )
    parser.add_argument("--scenario", metavar="PRESET|FILE.toml", help="what to train on (default thesis-obstacles)")
    _add_settings(parser, "hyperparameters of the training, such as batch=512 or observation.tours=false")
    parser.add_argument("--seed", type=read_natural, metavar="S", help="makes the whole training (default 1)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="checkpoints, weights and history")
    parser.add_argument("--resume", action="store_true", help="go on from the checkpoint in DIR")
    parser.set_defaults(run=commands.run_train)


def _add_ablate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--learner", default="dddqn", metavar="NAME", help="what learns (default dddqn)")
    parser.add_argument("--scenario", default="thesis-obstacles", metavar="PRESET|FILE.toml", help="what to train on")
    parser.add_argument(
        "--only", type=read_names, nargs="+", default=[["*"]], metavar="PATTERN", help="these variants and the full one"
    )
    parser.add_argument(
        "--seeds", type=read_count, default=3, metavar="N", help="trainings of each variant (default 3)"
    )
    _add_settings(parser, "hyperparameters of all trainings, such as total_steps=2000000")
    parser.add_argument("--jobs", type=read_count, default=1, metavar="N", help="trainings at once (default 1)")
    parser.add_argument(
        "--episodes", type=read_count, default=200, metavar="N", help="unseen maps each is judged on (default 200)"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="trainings, table, figures; resumed")
    parser.set_defaults(run=commands.run_ablate)


def _add_thesis(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--episodes", type=read_count, default=10_000, metavar="N",
        help="training episodes in the empty room, five times as many among obstacles (default 10000, the thesis's)",
    )  # fmt: skip
    parser.add_argument(
        "--versions", type=read_names, default=["thesis", "mended"], metavar="a,b,...",
        help="thesis: as it was; mended: every mistake mended; a switch's name: this one alone; each: all such",
    )  # fmt: skip
    parser.add_argument(
        "--only",
        type=read_names,
        default=["*"],
        metavar="PATTERN,...",
        help="these of the experiments: 'team-*'",
    )
    _add_settings(parser, "hyperparameters of all trainings, such as environments=16")
    parser.add_argument("--seed", type=read_natural, default=1, metavar="S", help="makes every training (default 1)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="trainings, page, figures; resumed")
    parser.set_defaults(run=commands.run_thesis_experiments)


def _add_bench(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", type=Path, metavar="FILE", help="write them as a list of name, value and unit")
    parser.add_argument(
        "--growth", action="store_true", help="also how speeds and decisions grow with map, lidar, team"
    )
    parser.add_argument(
        "--figures", type=Path, metavar="DIR", help="draw that, too: growth and decisions, .svg and .png"
    )
    parser.add_argument("--all", action="store_true", help="all there are, also those that take minutes")
    parser.add_argument("--only", type=read_names, metavar="PATTERN,...", help="of all, those named so: 'world-*-core'")
    parser.set_defaults(run=commands.run_bench, interrupted="nothing was written")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    words = list(sys.argv[1:] if argv is None else argv)
    sys.path.append(str(Path.cwd()))  # so that module:Class finds a file of the current folder, as python -m would
    debug = bool(os.environ.get("INDOOR_EXPLORERS_DEBUG"))
    arguments = argparse.Namespace()
    try:
        arguments = build_parser().parse_args(words)
        arguments.debug = debug
        arguments.words = shlex.join(["indoor-explorers", *words])
        status: int = arguments.run(arguments)
    except (InputError, PolicyError, RunError) as error:
        if debug:
            raise
        line = " ".join(str(error).split())
        sys.stderr.write(f"indoor-explorers: {line}\n")
        return USAGE if isinstance(error, InputError) else FAILED
    except BrokenPipeError:
        sys.stderr.close()
        return FAILED
    except OSError as error:
        if debug:
            raise
        sys.stderr.write(f"indoor-explorers: {_system_said(error)}\n")
        return FAILED
    except KeyboardInterrupt:
        kept = getattr(arguments, "interrupted", "what is finished is kept, and the same command goes on from there")
        sys.stderr.write(f"indoor-explorers: interrupted; {kept}\n")
        return INTERRUPTED
    return status


def _system_said(error: OSError) -> str:
    line = f"{error.filename or 'the output'}: {error.strerror or error}"
    if error.errno in NO_ROOM:
        line += "; what is finished is kept: make room on the disk, and the same command goes on from there"
    return line


if __name__ == "__main__":
    sys.exit(main())
