"""The command flies policies in the process of a peer, keeps what was flown, and tells what fails in a line."""

import csv
import hashlib
import os
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from indoor_explorers.evaluation.cli import main
from indoor_explorers.evaluation.harness.reported.rows import read_reported
from indoor_explorers.evaluation.studies.peers import dare
from indoor_explorers.evaluation.studies.peers.flights import EXPERT, Flight
from indoor_explorers.evaluation.studies.peers.results import SCENARIO, flight_table

#: A clone of DARE and the interpreter of its environment, for the tests with the real simulator.
CLONE, PYTHON = os.environ.get("DARE_CLONE"), os.environ.get("DARE_PYTHON")


@pytest.fixture
def clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a clone with four maps, whose simulator is the small one of these tests."""
    folder = tmp_path / "DARE"
    (folder / "maps_test").mkdir(parents=True)
    for number in (1, 10, 2, 3):
        (folder / "maps_test" / f"{number}.png").write_bytes(b"")
    (folder / "parameter.py").write_bytes(b"CELL_SIZE = 0.4\n")
    digest = hashlib.sha256(b"CELL_SIZE = 0.4\n").hexdigest()
    monkeypatch.setattr(dare, "CODE", replace(dare.CODE, files={"parameter.py": digest}))
    monkeypatch.setattr(dare, "NEEDS", dare.NEEDS[:0])
    monkeypatch.setattr(dare, "SCRIPT", Path(__file__).with_name("lattice.py"))
    return folder


def _peer(clone: Path, *more: str, python: str = sys.executable) -> int:
    return main(["peer", "dare", "--clone", str(clone), "--python", python, *more])


def _rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "flights.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_flights_are_kept_and_compared_with_the_expert(clone: Path, tmp_path: Path, capsys) -> None:
    """The same command goes on where it stopped, and another one adds to the folder."""
    out = tmp_path / "out"
    assert _peer(clone, "--policies", "frontier-tour,expert", "--maps", "2", "--out", str(out)) == 0
    told = capsys.readouterr().out
    assert "frontier-tour on 1: 110 m, 25 moves" in told
    assert "2 maps of DARE, by its own rules" in told
    assert [row["map"] for row in _rows(out)] == ["1", "1", "10", "10"]
    first = (out / "flights.csv").read_bytes()
    assert _peer(clone, "--policies", "frontier-tour,expert", "--maps", "2", "--out", str(out)) == 0
    told = capsys.readouterr().out
    assert " on " not in told.split("maps of DARE")[0]
    assert "0.842" in told  # 110 m against the 131 m of the nearest useful node
    assert (out / "flights.csv").read_bytes() == first
    assert _peer(clone, "--policies", "frontier,expert", "--maps", "10.png", "--out", str(out)) == 0
    assert [row["policy"] for row in _rows(out)][-1] == "frontier"


def test_flights_are_reported_rows_that_say_where_they_were_measured(clone: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    _peer(clone, "--policies", "frontier-tour", "--maps", "1", "--out", str(out))
    (policy,) = read_reported(out)
    assert policy.name == "frontier-tour in DARE"
    assert policy.source.measured
    (row,) = policy.rows
    assert (row.scenario, row.map, row.team, row.budget, row.success) == (SCENARIO, "1", 1, 128, 1.0)
    assert row.metrics["path_max_m"] == float(_rows(out)[0]["metres"])
    capsys.readouterr()
    assert main(["report", str(out), "--out", str(tmp_path / "page.html")]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "frontier-tour in DARE \N{PILCROW SIGN} measured here in the simulator of Y. Cao et al., DARE" in told
    assert "not flown in this world" in told


def test_scans_on_the_way_are_flights_of_their_own(clone: Path, tmp_path: Path, capsys) -> None:
    """What was flown by the simulator's own rule stays, and rows and table say which rule was flown."""
    out = tmp_path / "out"
    for more in ([], ["--scan-on-the-way"], []):
        assert _peer(clone, "--policies", "frontier-tour", "--maps", "1", "--out", str(out), *more) == 0
    told = capsys.readouterr().out
    assert told.count("frontier-tour on 1:") == 2
    assert "1 maps of DARE, by its own rules but for scans on the way" in told
    nodes, on_the_way = _rows(out)
    assert [row["scans_on_the_way"] for row in (nodes, on_the_way)] == ["False", "True"]
    assert float(on_the_way["metres"]) <= float(nodes["metres"])
    assert [policy.name for policy in read_reported(out)] == [
        "frontier-tour in DARE",
        "frontier-tour in DARE, scanning on the way",
    ]


def test_a_failure_costs_one_flight_which_is_flown_again(clone: Path, tmp_path: Path, capsys, monkeypatch) -> None:
    out = tmp_path / "out"
    monkeypatch.setenv("FAILS_ON", "10.png")
    assert _peer(clone, "--policies", "frontier-tour", "--maps", "1.png,10.png,2.png", "--out", str(out)) == 1
    told = capsys.readouterr()
    assert (
        "frontier-tour on 10: the process of DARE ended with exit code 7; it printed: no memory for the map" in told.err
    )
    assert [bool(row["failure"]) for row in _rows(out)] == [False, True, False]
    assert len(read_reported(out)[0].rows) == 2
    monkeypatch.delenv("FAILS_ON")
    assert _peer(clone, "--policies", "frontier-tour", "--maps", "1.png,10.png,2.png", "--out", str(out)) == 0
    assert capsys.readouterr().out.count("frontier-tour on") == 1
    assert [row["failure"] for row in _rows(out)] == ["", "", ""]


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--maps", "12.png"], "--maps: expected a number up to 4 or names such as 1.png, got '12.png'"),
        (["--maps", "5"], "expected a number up to 4 or names such as 1.png, got '5'"),
        (["--policies", "frontir"], "did you mean 'frontier'?"),
        (["--policies", "frontier,frontier"], "expected different policies, got one twice"),
        (["--policies", "frontier-nearest", "--adapter", "nodes"], "has no rule for nodes"),
    ],
)
def test_wrong_options_are_one_line(clone: Path, capsys, more: list[str], told: str) -> None:
    assert _peer(clone, *more) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


def test_another_clone_or_interpreter_is_one_line(clone: Path, capsys) -> None:
    assert _peer(clone, "--policies", "frontier-tour", python="/no/python") == 2
    assert "/no/python: expected a Python interpreter, cannot start it" in capsys.readouterr().err
    (clone / "parameter.py").write_bytes(b"CELL_SIZE = 0.2\n")
    assert _peer(clone) == 2
    assert "found another parameter.py; run `git -C " in capsys.readouterr().err


def test_a_damaged_file_of_flights_and_another_adapter_are_one_line(clone: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    _peer(clone, "--policies", "frontier", "--maps", "1", "--out", str(out))
    assert _peer(clone, "--policies", "frontier", "--maps", "1", "--adapter", "cells", "--out", str(out)) == 2
    assert "frontier was flown by nodes; choose another --out" in capsys.readouterr().err
    (out / "flights.csv").write_text("policy,map\nfrontier,1\n")
    assert _peer(clone, "--policies", "frontier", "--maps", "1", "--out", str(out)) == 2
    assert "flights.csv: expected flights of the command peer, cannot read them" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(not (CLONE and PYTHON), reason="DARE_CLONE and DARE_PYTHON name no clone and interpreter")
def test_the_real_simulator_and_its_expert(tmp_path: Path) -> None:
    """The expert flies on the first map what it flew when the page was made: 471 m."""
    assert CLONE is not None
    assert PYTHON is not None
    out = tmp_path / "out"
    assert _peer(Path(CLONE), "--policies", "expert,frontier", "--maps", "1.png", "--out", str(out), python=PYTHON) == 0
    expert, frontier = _rows(out)
    assert (expert["moves"], round(float(expert["metres"]))) == ("72", 471)
    assert frontier["done"] == "True"


def test_flights_that_did_not_end_make_bounds() -> None:
    """What one of the two never reached counts with all that it flew, and a sign says in which direction."""

    def flight(policy: str, name: str, metres: float, done: bool) -> Flight:
        known = {"metres_90": metres / 2, "metres_99": metres if done else None}
        return Flight(policy=policy, chosen_by="nodes", map=name, seed=0, metres=metres, done=done, moves=9, **known)

    maps = [str(number) for number in range(8)]
    mine = [flight("frontier", name, 90.0, name != "3") for name in maps]
    theirs = [flight(EXPERT, name, 100.0, True) for name in maps]
    frontier, expert = flight_table([*mine, *theirs], ["frontier", EXPERT]).rows
    told = [cell.line for cell in frontier.cells]
    assert told[1] == "88\N{NARROW NO-BREAK SPACE}%"
    assert told[3:] == [
        "45",
        "0.900 [0.900, 0.900]",
        "> 90",
        "> 0.900 [0.900, 0.900]",
        "> 90",
        "> 0.900 [0.900, 0.900]",
    ]
    assert [cell.text for cell in expert.cells[3:]] == ["50", "\N{EN DASH}", "100", "\N{EN DASH}", "100", "\N{EN DASH}"]
