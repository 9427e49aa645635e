"""The command flies teams in the process of IR2, keeps the flights, and compares them with imported rows by map."""

import csv
import hashlib
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.evaluation.cli import main
from indoor_explorers.evaluation.harness.reported.rows import read_reported
from indoor_explorers.evaluation.studies.peers import ir2
from indoor_explorers.evaluation.studies.peers.ir2_results import scenario_of
from indoor_explorers.planners.toolbox.peers.process import Peer, PeerProcess

#: A clone of IR2 and the interpreter of its environment, for the tests with the real simulator.
CLONE, PYTHON = os.environ.get("IR2_CLONE"), os.environ.get("IR2_PYTHON")
real = pytest.mark.skipif(not (CLONE and PYTHON), reason="IR2_CLONE and IR2_PYTHON name no clone and interpreter")


@pytest.fixture
def clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a clone with three maps, whose simulator is the small one of these tests."""
    folder = tmp_path / "IR2"
    (folder / "DungeonMaps/test/hybrid").mkdir(parents=True)
    for number in (1, 10, 2):
        (folder / f"DungeonMaps/test/hybrid/{number}.png").write_bytes(b"")
    (folder / "env.py").write_bytes(b"RESOLUTION = 4\n")
    digest = hashlib.sha256(b"RESOLUTION = 4\n").hexdigest()
    monkeypatch.setattr(ir2, "CODE", replace(ir2.CODE, files={"env.py": digest}))
    monkeypatch.setattr(ir2, "NEEDS", ir2.NEEDS[:0])
    monkeypatch.setattr(ir2, "SCRIPT", Path(__file__).with_name("team_lattice.py"))
    return folder


def _peer(clone: Path, *more: str, python: str = sys.executable) -> int:
    return main(["peer", "ir2", "--clone", str(clone), "--python", python, *more])


def _rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "team-flights.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_tasks_are_in_the_order_of_the_simulator_with_its_seeds(clone: Path) -> None:
    tasks = ir2.Ir2Simulator(clone, sys.executable).tasks("hybrid")
    assert [(task.map, task.seed) for task in tasks] == [("2.png", 20261005), ("10.png", 20261006), ("1.png", 20261007)]
    assert ir2.Ir2Simulator(clone, sys.executable).tasks("hybrid", ("1.png",)) == tasks[2:]


def test_flights_are_kept_and_compared_with_imported_rows(clone: Path, tmp_path: Path, capsys) -> None:
    """Rows of other maps and other sets are not compared; mended flights are rows of their own."""
    out, theirs = tmp_path / "out", tmp_path / "theirs"
    assert _peer(clone, "--policies", "frontier-nearest", "--maps", "1", "--out", str(out)) == 0
    (flown,) = _rows(out)
    told = capsys.readouterr().out
    assert f"frontier-nearest on 2: {flown['steps']} steps, {float(flown['pixels']):.0f} px" in told
    assert "1 map of IR2's hybrid, by its own rules" in told
    rows = tmp_path / "rows.csv"
    rows.write_text(
        f"set,map,steps,px,success\nhybrid,2.png,{2 * int(flown['steps'])},{4 * float(flown['pixels'])},True\n"
        "hybrid,1.png,1,1,True\ncorridor,2.png,1,1,True\n"
    )
    rows.with_suffix(".toml").write_text(
        'policy = "theirs"\nscenario = { column = "set", names = { hybrid = "ir2-hybrid-own-rules", '
        'corridor = "ir2-corridor-own-rules" } }\nmap = { column = "map" }\nteam = 4\n'
        '[source]\ncitation = "somebody"\nurl = "https://example.org"\n'
        '[metrics]\nt99_worst = { column = "steps" }\npath_max_m = { column = "px" }\n'
        '[success]\ncolumn = "success"\nlevel = 0.99\n'
    )
    assert main(["import", str(rows), "--out", str(theirs)]) == 0
    capsys.readouterr()
    again = ["--policies", "frontier-nearest", "--maps", "1", "--out", str(out), "--against", str(theirs)]
    assert _peer(clone, *again) == 0
    told = capsys.readouterr().out
    assert " on 2:" not in told
    assert "/ theirs" in told
    assert "0.500" in told
    assert "0.250" in told
    assert _peer(clone, "--mend-maps", *again) == 0
    assert [(row["map"], row["mended"]) for row in _rows(out)] == [("2", "False"), ("2", "True")]
    plain, mended = read_reported(out)
    assert (plain.name, mended.name) == ("frontier-nearest in IR2", "frontier-nearest in IR2, mended")
    assert plain.source.measured
    (row,) = plain.rows
    assert (row.scenario, row.map, row.seed, row.team, row.budget) == (scenario_of("hybrid"), "2", 20261005, 4, 196)
    assert (row.success, row.metrics["t99_worst"]) == (1.0, int(flown["steps"]))
    assert _peer(clone, "--maps", "1", "--against", str(tmp_path / "none")) == 2
    assert "--against: expected imported rows of scenario ir2-hybrid-own-rules, found none" in capsys.readouterr().err


@pytest.mark.slow
def test_a_failure_costs_one_flight_which_is_flown_again(clone: Path, tmp_path: Path, capsys, monkeypatch) -> None:
    out = tmp_path / "out"
    monkeypatch.setenv("FAILS_ON", "2.png")
    asked = ["--policies", "frontier-nearest", "--maps", "2.png,1.png", "--out", str(out)]
    assert _peer(clone, *asked) == 1
    told = capsys.readouterr()
    assert "frontier-nearest on 2: the process of IR2 ended with exit code 7" in told.err
    printed = " ".join(told.out.split())
    assert "1 map of IR2's hybrid, by its own rules" in printed
    assert "1 flight failed; the same command flies what failed again." in printed
    assert [bool(row["failure"]) for row in _rows(out)] == [True, False]
    monkeypatch.delenv("FAILS_ON")
    assert _peer(clone, *asked) == 0
    assert capsys.readouterr().out.count("frontier-nearest on") == 1
    assert [row["failure"] for row in _rows(out)] == ["", ""]


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--maps", "12.png"], "--maps: expected a number up to 3 or names such as 2.png, got '12.png'"),
        (["--tasks", "corridor"], "expected maps, found none; fetch them with `git clone "),
        (["--policies", "frontir"], "did you mean 'frontier'?"),
        (["--policies", "frontier,frontier"], "expected different policies, got one twice"),
    ],
)
def test_wrong_options_are_one_line(clone: Path, capsys, more: list[str], told: str) -> None:
    assert _peer(clone, *more) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


def test_a_damaged_file_of_flights_is_one_line(clone: Path, tmp_path: Path, capsys) -> None:
    (tmp_path / "team-flights.csv").write_text("policy,map\nfrontier,1\n")
    assert _peer(clone, "--maps", "1", "--out", str(tmp_path)) == 2
    assert "team-flights.csv: expected flights of the command peer, cannot read them" in capsys.readouterr().err


@pytest.mark.slow
@real
def test_the_real_simulator(tmp_path: Path) -> None:
    """A team flies on the first map what it flew when the page was made."""
    assert CLONE is not None
    assert PYTHON is not None
    out = tmp_path / "out"
    assert _peer(Path(CLONE), "--policies", "frontier", "--maps", "1", "--out", str(out), python=PYTHON) == 0
    (row,) = _rows(out)
    assert (row["map"], row["steps"], round(float(row["pixels"])), row["done"]) == ("99", "49", 1692, "True")


@pytest.mark.slow
@real
@pytest.mark.parametrize("part", ["hybrid", "corridor"])
def test_faster_functions_answer_as_the_simulators_own(part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same moves lead to the same maps and the same graphs, with global graphs thinned at every tenth step."""
    assert CLONE is not None
    assert PYTHON is not None
    script = Path(__file__).with_name("ir2_states.py")
    peer = Peer(interpreter=PYTHON, folder=ir2.CODE.checked(CLONE), script=script, needs=ir2.NEEDS, time_limit=600)
    with PeerProcess(peer) as fast, PeerProcess(peer) as own:
        fast.start()
        monkeypatch.setenv("OWN_FUNCTIONS", "1")
        own.start()
        task = {"part": part, "name": "7.png", "team": 4, "most_nodes": 200, "seed": 1, "mended": True}
        one, other = fast.ask("begin", **task), own.ask("begin", **task)
        rng = np.random.default_rng(2)
        for _ in range(60):
            for key, value in one.items():
                np.testing.assert_array_equal(value, other[key], err_msg=key)
            ends = one["edges"][one["edges"][:, 0] == one["node"], 1]
            apart = np.hypot(*(one["nodes"][ends] - one["nodes"].mean(axis=0)).T)
            node = int(ends[apart.argmax()] if rng.random() < 0.5 else rng.choice(ends))
            one, other = fast.ask("move", node=node), own.ask("move", node=node)
