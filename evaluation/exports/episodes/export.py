"""Writes a recorded episode in one of the formats, completely or not at all."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, get_args

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.files import expanded, written_whole
from indoor_explorers.evaluation.exports.episodes.choosing import chosen_record
from indoor_explorers.evaluation.exports.episodes.csv_tables import FILES, write_csv
from indoor_explorers.evaluation.exports.episodes.moments import frame_of
from indoor_explorers.evaluation.harness.episodes.flight import Told, explained_again
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.stored_policy import policy_again, whole_scenario

#: What an episode can be written as.
Format = Literal["mcap", "rosbag2", "csv"]


def export_episode(
    folder: str | Path,
    out: str | Path,
    *,
    policy: str | None = None,
    scenario: str | None = None,
    map: str | None = None,
    seed: int | None = None,
    format: Format = "mcap",
    step_seconds: float | None = None,
    speed: float | None = None,
    explanations: bool = False,
    plugins: Iterable[str] = (),
) -> Path:
    """Write one episode of a results folder for other programs, and return where it lies.

    The episode is simulated again from its map, seed and actions. An ``.mcap`` file or a folder that an export has
    written is replaced.

    Args:
        folder: a folder written by ``compare``.
        out: the file of ``mcap``, or the folder of ``rosbag2`` and ``csv``.
        policy: the policy; like the next three it may be left out where the results have only one.
        scenario: the scenario.
        map: the name of the map.
        seed: the seed of the episode.
        format: ``mcap``, one file for Foxglove and for ROS 2; ``rosbag2``, a folder with an SQLite file
            for ``ros2 bag play``, in the format of Humble; ``csv``, ``steps.csv`` and ``meta.json``.
        step_seconds: seconds of a step; 1 if neither this nor the speed is given.
        speed: metres per second, instead: a step is then the time to fly one cell.
        explanations: whether to fly the episode again with its policy, for a topic of each UAV that explains its moves.
        plugins: the lidar and radio models, and policies to explain, from outside this package that may be imported.

    Raises:
        InputError: the episode is not there, is not the only one, or cannot be written.
        RunError: the episode is not as stored when it is simulated again, or cannot be explained.

    """
    if format not in get_args(Format):
        raise InputError(f"expected a format of {', '.join(get_args(Format))}, got {format!r}")
    if explanations and format == "csv":
        raise InputError("expected explanations in mcap or rosbag2, got csv; choose another --format")
    target, results = _checked_target(expanded(out), format), Results.load(expanded(folder), plugins)
    wanted = {"policy": policy, "scenario": scenario, "map": map, "seed": seed}
    record = chosen_record(results, str(folder), wanted)
    settings = results.scenario(record.task.scenario)
    seconds = _step_seconds(record, step_seconds, speed)
    try:
        WRITERS[format](record, settings, target, seconds, _told(results, record) if explanations else None)
    except (OSError, sqlite3.Error) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"{target}: cannot be written: {why}; choose another --out") from error
    return target


def _told(results: Results, record: Record) -> Told:
    """Yield what explains the moves of an episode, which its policy flies again."""
    try:
        policy, scenario = policy_again(results, record.policy), whole_scenario(results, record.task.scenario)
        yield from explained_again(record, scenario, policy)
    except (InputError, RunError) as error:
        raise type(error)(f"{record.policy} cannot be explained: {error}; leave out --explanations") from error


def _step_seconds(record: Record, step_seconds: float | None, speed: float | None) -> float:
    """Return the seconds of a step; given a speed, the time to fly one cell."""
    if step_seconds is not None and speed is not None:
        raise InputError("expected the seconds of a step or a speed, got both; leave one out")
    given = next((value for value in (step_seconds, speed) if value is not None), 1.0)
    if not 0.001 <= given <= 1000:
        raise InputError(f"expected 0.001 to 1000 seconds or metres a second, got {given:g}")
    return given if speed is None else frame_of(record).resolution / speed


def _checked_target(target: Path, format: Format) -> Path:
    """Return the path to write, refusing one that does not fit the format or holds something else."""
    if (target.suffix == ".mcap") != (format == "mcap"):
        wanted = "a file that ends in .mcap" if format == "mcap" else "the name of a folder"
        raise InputError(f"expected {wanted} as --out of format {format}, got {target}")
    if target.is_dir() and (format == "mcap" or not all(map(_is_exported, target.iterdir()))):
        raise InputError(f"{target}: expected no folder, or one that an export has written; choose another --out")
    if format != "mcap" and target.exists() and not target.is_dir():
        raise InputError(f"{target}: expected the name of a folder, got a file; choose another --out")
    return target


def _is_exported(path: Path) -> bool:
    return path.name in (*FILES, "metadata.yaml", f"{path.parent.name}.db3")


def _write_mcap(record: Record, scenario: Scenario, target: Path, seconds: float, told: Told | None) -> None:
    write_bag = _bag_writer()
    with written_whole(target) as partial, _new_folder(partial) as scratch:
        write_bag(record, scenario, scratch / target.stem, seconds, mcap=True, told=told)
        (scratch / target.stem / target.name).replace(partial)


def _write_rosbag2(record: Record, scenario: Scenario, target: Path, seconds: float, told: Told | None) -> None:
    write_bag = _bag_writer()
    with _new_folder(target.resolve()) as scratch:
        write_bag(record, scenario, scratch / target.name, seconds, mcap=False, told=told)
        _replace_folder(scratch / target.name, target)


def _write_csv(record: Record, scenario: Scenario, target: Path, seconds: float, told: Told | None) -> None:
    with _new_folder(target.resolve()) as scratch:
        (scratch / target.name).mkdir()
        write_csv(record, scenario, scratch / target.name, seconds)
        _replace_folder(scratch / target.name, target)


#: How each format is written.
WRITERS: dict[str, Callable[[Record, Scenario, Path, float, Told | None], None]] = {
    "mcap": _write_mcap,
    "rosbag2": _write_rosbag2,
    "csv": _write_csv,
}


def _bag_writer() -> Callable[..., None]:
    """Return the function that writes bags, whose library is an extra."""
    try:
        from indoor_explorers.evaluation.exports.episodes.topics import write_bag
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != "rosbags":
            raise
        raise InputError("rosbags is not installed; pip install 'indoor-explorers[ros]', or use csv") from error
    return write_bag


@contextmanager
def _new_folder(target: Path) -> Iterator[Path]:
    """Give an empty folder beside ``target``, which is deleted at the end with what is left in it."""
    scratch = target.with_name(f".{target.name}.partial")
    shutil.rmtree(scratch, ignore_errors=True)  # left by an interrupted command
    scratch.mkdir(parents=True)
    try:
        yield scratch
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _replace_folder(written: Path, target: Path) -> None:
    """Move a finished folder to its place, or where a link there leads; an earlier one lies beside it until then."""
    target = target.resolve()
    if target.exists():
        target.replace(written.with_name(f"{written.name}.before"))
    written.replace(target)
