"""The command line end to end, in temporary folders."""

import contextlib
import csv
import os
import resource
import signal
import sqlite3
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.env.grid.compiled import NOTICE
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.cli.commands import demo
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.experiment.request import read_names
from indoor_explorers.evaluation.harness.results.results import SUMMARY_COLUMNS
from tests.evaluation import plugins

PLUGINS = plugins.__name__
ROOT = Path(__file__).resolve().parents[3]
#: Fly in this process, which spares the start of others.
HERE = ["--workers", "0"]
#: Seconds after which a run without an episode must have worked, and the most seconds of work that its first one takes.
PATIENCE, MOST = 300.0, 600.0
CONTRACT_METRICS = {
    *("auc", "t50", "t90", "t95", "t99", "path_length", "overlap", "collisions"),
    *("latency_p50_us", "latency_p99_us", "messages_bytes"),
}


def run(capsys, *words):
    """Run the command in this process; returns (status, standard output, standard error)."""
    status = main([str(word) for word in words])
    captured = capsys.readouterr()
    return status, captured.out, captured.err.replace(NOTICE, "")  # which says only that nothing was compiled yet


def rows(out, machine=False):
    """The rows of summary.csv, without those that measure the machine."""
    lines = (Path(out) / "summary.csv").read_text().splitlines()
    return [line for line in lines if machine or ",latency_" not in line]


def summary(out):
    """The rows of summary.csv as dictionaries."""
    with (Path(out) / "summary.csv").open() as file:
        return list(csv.DictReader(file))


def start(*words, room=None):
    """Start the command as a user does, in a process of its own; no file of it can grow above ``room`` bytes."""

    def prepare():
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell's background jobs ignore it
        if room is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    code = "import sys; from indoor_explorers.evaluation.cli.parser import main; sys.exit(main())"
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, words)],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=prepare,
    )


def stored(out):
    """How many episodes a store holds now."""
    path = Path(out) / "results.db"
    try:
        with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as db:
            return db.execute("SELECT count(*) FROM episode").fetchone()[0]
    except sqlite3.OperationalError:
        return 0


def processor_seconds(session):
    """Seconds of processor time that the processes of a session have used, and those of theirs that have ended."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            facts = list(map(int, stat.read_text().rpartition(")")[2].split()[1:15]))
            ticks += sum(facts[10:]) if facts[2] == session else 0
    return ticks / os.sysconf("SC_CLK_TCK")


def await_first_episode(running, out):
    """Wait until an episode is stored, as long as the run works, however slowly: a second in five minutes, or more."""
    used, check = 0.0, time.monotonic() + PATIENCE
    while stored(out) == 0 and running.poll() is None:
        time.sleep(0.02)
        if time.monotonic() > check:
            before, used, check = used, processor_seconds(running.pid), check + PATIENCE
            if not before + 1 < used < MOST:
                break


def test_compare_writes_what_the_contract_says(figures, capsys, tmp_path):
    out = tmp_path / "out"
    words = ["--policies", "random,frontier-nearest", "--scenario", "thesis-team-2", "--episodes", "6", "--seed", "3"]
    status, printed, errors = run(capsys, "compare", *words, *HERE, "--out", out)
    assert (status, errors) == (0, "")
    assert "frontier-nearest" in printed
    assert "report.html" in printed
    table = summary(out)
    assert tuple(table[0]) == SUMMARY_COLUMNS
    for policy in ("random", "frontier-nearest"):
        mine = {row["metric"]: row for row in table if row["policy"] == policy}
        assert set(mine) >= CONTRACT_METRICS
        assert {(row["scenario"], row["team"], row["episodes"]) for row in mine.values()} == {
            ("thesis-team-2", "2", "6")
        }
        assert float(mine["t90"]["low"]) <= float(mine["t90"]["mean"]) <= float(mine["t90"]["high"])
    assert {path.suffix for path in (out / "figures").iterdir()} == {".svg", ".png", ".pdf"}
    assert (out / "report.html").read_text().startswith("<!doctype html>")


@pytest.mark.slow
@pytest.mark.filterwarnings("always::FutureWarning")
def test_an_old_name_of_a_parameter_is_told_once_and_stored_as_the_new_one(capsys, tmp_path):
    named = ["--policies", "frontier-burgard(hold=2)", "--scenario", "thesis-open", "--episodes", "4"]
    status, _, errors = run(capsys, "compare", *named, "--workers", "2", "--out", tmp_path)
    assert (status, errors.splitlines()) == (
        0,
        [
            "indoor-explorers: FrontierBurgard: the parameter 'hold' is now 'switch_cost'; "
            "the old name is accepted up to version 0.3"
        ],
    )
    with contextlib.closing(sqlite3.connect(tmp_path / "results.db")) as db:
        (entry,) = tomllib.loads(db.execute("SELECT experiment FROM run").fetchone()[0])["policies"]
    assert entry == {
        "use": "frontier-burgard",
        "name": "frontier-burgard(hold=2)",
        "parameters": {"switch_cost": 2},
    }


def test_running_again_flies_nothing_and_changes_nothing(capsys, tmp_path):
    words = ["compare", "--policies", "random", "--scenario", "thesis-open", "--episodes", "4", "--workers", "0"]
    run(capsys, *words, "--out", tmp_path)
    before = rows(tmp_path, machine=True)
    status, printed, _ = run(capsys, *words, "--out", tmp_path)
    assert status == 0
    assert "4 of 4 episodes are in the store already" in printed
    assert rows(tmp_path, machine=True) == before


def test_more_episodes_and_policies_are_added(capsys, tmp_path):
    words = ["compare", "--scenario", "thesis-open", "--workers", "0"]
    run(capsys, *words, "--policies", "random", "--episodes", "3", "--out", tmp_path / "grown")
    run(capsys, *words, "--policies", "random,frontier-nearest", "--episodes", "5", "--out", tmp_path / "grown")
    run(capsys, *words, "--policies", "random,frontier-nearest", "--episodes", "5", "--out", tmp_path / "whole")
    assert rows(tmp_path / "grown") == rows(tmp_path / "whole")


@pytest.mark.parametrize(
    "kind",
    [signal.SIGINT, *(pytest.param(kind, marks=pytest.mark.slow) for kind in (signal.SIGKILL, signal.SIGTERM))],
)
def test_killing_and_running_again_gives_the_same_summary(kind, capsys, tmp_path):
    words = ["compare", "--policies", "horizon", "--scenario", "thesis-obstacles", "--episodes", "12"]
    running = start(*words, "--workers", "2", "--out", tmp_path / "killed")
    await_first_episode(running, tmp_path / "killed")
    if kind == signal.SIGINT:
        os.killpg(running.pid, kind)
    else:
        running.send_signal(kind)
    _, errors = running.communicate(timeout=2 * PATIENCE)
    assert 0 < stored(tmp_path / "killed") < 12
    if kind == signal.SIGINT:
        assert (running.returncode, errors.replace(NOTICE, "").count("\n")) == (130, 1), errors
        assert "what is finished is kept" in errors
    for out in ("killed", "whole"):
        status, _, errors = run(capsys, *words, "--workers", "0", "--out", tmp_path / out)
        assert (status, errors) == (0, "")
    assert stored(tmp_path / "killed") == 12
    assert rows(tmp_path / "killed") == rows(tmp_path / "whole")


def test_an_experiment_file(capsys, tmp_path):
    (tmp_path / "far.toml").write_text('preset = "thesis-open"\nlidar.range = 5.0\n')
    (tmp_path / "plan.toml").write_text(
        'policies = ["random", {use = "random", name = "chance"}]\nscenarios = ["far.toml"]\n'
        'episodes = 2\nseed = 9\n[set]\nbudget = 50\n"radio.model" = "none"\n'
    )
    status, _, errors = run(capsys, "compare", "--experiment", tmp_path / "plan.toml", *HERE, "--out", tmp_path / "out")
    assert (status, errors) == (0, "")
    table = summary(tmp_path / "out")
    assert {row["policy"] for row in table} == {"random", "chance"}
    assert {row["scenario"] for row in table} == {"far"}
    assert all(float(row["mean"]) <= 50 for row in table if row["metric"] == "t90")


def test_maps_from_files(capsys, tmp_path):
    pixels = np.full((40, 60), 254, np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = 0
    pixels[5:35, 20] = pixels[10:, 40] = 0
    Image.fromarray(pixels).save(tmp_path / "flat.pgm")
    (tmp_path / "flat.yaml").write_text(
        "image: flat.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    words = ["--maps", tmp_path / "flat.yaml", "--resolution", "0.1", "--team", "2", "--episodes", "2"]
    status, _, errors = run(
        capsys, "compare", *words, "--policies", "frontier-nearest", "--workers", "0", "--out", tmp_path / "out"
    )
    assert (status, errors) == (0, "")
    table = summary(tmp_path / "out")
    assert {(row["scenario"], row["team"]) for row in table} == {("flat", "2")}
    assert next(row["success"] for row in table if row["metric"] == "t99") == "1"
    status, printed, _ = run(capsys, "maps", tmp_path / "flat.yaml", "--resolution", "0.1")
    assert "flat: 20 x 30 cells, 0.1 m a cell" in printed


def test_the_function_takes_the_arguments_of_the_command(capsys, tmp_path):
    table = compare(tmp_path / "a", policies=["random"], scenario="thesis-open", episodes=2, seed=1, workers=0)
    run(
        capsys,
        *["compare", "--policies", "random", "--scenario", "thesis-open", "--episodes", "2", "--seed", "1"],
        *[*HERE, "--out", tmp_path / "b"],
    )
    assert list(table.columns) == list(SUMMARY_COLUMNS)
    assert rows(tmp_path / "a") == rows(tmp_path / "b")


def test_failed_episodes_are_kept_and_make_status_1(capsys, tmp_path):
    words = ["compare", "--policies", f"{PLUGINS}:Raises,random", "--scenario", "thesis-team-2", "--episodes", "8"]
    status, printed, errors = run(capsys, *words, *HERE, "--out", tmp_path)
    assert (status, errors) == (1, "")
    assert "failed:" in printed
    assert "RuntimeError: motor</script> failure" in printed
    assert "</script> failure" not in (tmp_path / "report.html").read_text()
    assert stored(tmp_path) == 16


@pytest.mark.slow  # test_supervisor.py tells of such policies
def test_a_policy_that_ends_its_process_leaves_the_others_alone(capsys, tmp_path):
    words = ["compare", "--policies", f"{PLUGINS}:Dies,random", "--scenario", "thesis-open", "--episodes", "2"]
    status, printed, errors = run(capsys, *words, "--workers", "1", "--out", tmp_path)
    assert (status, errors) == (1, "")
    assert "Dies in 2 of 2 episodes, first on thesis-open, seed 0, step 0: the process of the policy ended" in printed
    assert stored(tmp_path) == 4
    assert (tmp_path / "report.html").exists()


def test_failed_episodes_are_flown_again_on_request_alone(capsys, tmp_path, monkeypatch):
    words = ["compare", "--policies", f"{PLUGINS}:Mended,random", "--scenario", "thesis-open", "--episodes", "2"]
    words += ["--workers", "0", "--out", tmp_path]
    monkeypatch.setattr(plugins, "BROKEN", True)
    assert run(capsys, *words)[0] == 1
    monkeypatch.setattr(plugins, "BROKEN", False)
    status, printed, _ = run(capsys, *words)
    assert status == 1
    assert "4 of 4 episodes are in the store already" in printed
    assert "--retry-failed flies them again" in printed
    status, printed, _ = run(capsys, *words, "--retry-failed")
    assert status == 1, "what the policy did at the first attempt counts"
    assert "2 of 4 episodes are in the store already; flying 2" in printed
    assert f"episodes flown again after a failure: 2 of {PLUGINS}:Mended; the first attempt counts" in printed
    assert stored(tmp_path) == 4
    assert "Episodes flown again after a failure: 2 of" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("episodes", "room", "full", "workers"),
    [(40, 200_000, "results.db", 0), (2, 500_000, "the output", 1)],
)
@pytest.mark.slow
def test_a_run_without_room_says_so_and_is_resumed_with_room(episodes, room, full, workers, capsys, tmp_path):
    words = ["compare", "--policies", "random", "--scenario", "thesis-open", "--episodes", episodes, "--out", tmp_path]
    running = start(*words, "--workers", workers, room=room)
    _, errors = running.communicate(timeout=300)
    assert (running.returncode, errors.replace(NOTICE, "").count("\n")) == (1, 1), errors
    assert full in errors
    assert "make room on the disk, and the same command goes on from there" in errors
    assert not list(tmp_path.rglob("*.partial"))
    assert 0 < stored(tmp_path) <= episodes
    status, _, errors = run(capsys, *words, *HERE)
    assert (status, errors) == (0, "")
    assert stored(tmp_path) == episodes
    assert (tmp_path / "report.html").stat().st_size > room


def test_a_report_is_rebuilt_and_combined(capsys, tmp_path):
    common = ["--scenario", "thesis-open", "--episodes", "5", "--workers", "0"]
    run(capsys, "compare", "--policies", "random", *common, "--out", tmp_path / "a")
    run(capsys, "compare", "--policies", "frontier-nearest", *common, "--out", tmp_path / "b")
    assert run(capsys, "report", tmp_path / "a", "--out", tmp_path / "again.html")[0] == 0
    assert (tmp_path / "again.html").read_bytes() == (tmp_path / "a" / "report.html").read_bytes()
    assert run(capsys, "report", tmp_path / "a", "--replays", "5", "--out", tmp_path / "all.html")[0] == 0
    assert all(f'"task":[0,{seed}]' in (tmp_path / "all.html").read_text() for seed in range(5))
    status, _, _ = run(capsys, "report", tmp_path / "a", tmp_path / "b", "--out", tmp_path / "both.html")
    assert status == 0
    both = (tmp_path / "both.html").read_text()
    assert "random" in both
    assert "frontier-nearest" in both
    run(capsys, "compare", "--policies", "random", *common, "--set", "lidar.range=4", "--out", tmp_path / "c")
    status, _, errors = run(capsys, "report", tmp_path / "a", tmp_path / "c", "--out", tmp_path / "no.html")
    assert status == 2
    assert "what differs: lidar.range (3.0 and 4.0)" in errors
    assert not (tmp_path / "no.html").exists()


def test_steps_are_printed_as_ratios_to_a_policy(capsys, tmp_path):
    out, page = tmp_path / "out", tmp_path / "page.html"
    words = ["--policies", "frontier-nearest,frontier-minpos", "--scenario", "thesis-open,thesis-obstacles"]
    status, printed, _ = run(capsys, "compare", *words, "--episodes", "6", "--workers", "0", "--out", out)
    assert status == 0
    assert "ratio" not in printed
    with (out / "tables" / "ratios.csv").open(newline="") as file:
        assert {row["to"] for row in csv.DictReader(file)} == {"frontier-nearest"}
    words = ["--ratio-to", "frontier-minpos", "--exports", tmp_path / "more", "--out", page]
    status, printed, _ = run(capsys, "report", out, *words)
    assert status == 0
    assert "steps relative to frontier-minpos" in printed
    with (tmp_path / "more" / "tables" / "ratios.csv").open(newline="") as file:
        (row,) = [row for row in csv.DictReader(file) if (row["scenario"], row["metric"]) == ("all scenarios", "t99")]
    assert (row["policy"], row["scenarios"], row["tasks"]) == ("frontier-nearest", "2", "12")
    assert f"{float(row['mean_of_ratios']):.3f} [{float(row['low']):.3f}, {float(row['high']):.3f}]" in printed
    assert "T99 as a ratio to frontier-minpos" in page.read_text()


OPEN = ["--scenario", "thesis-open", "--policies", "random"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["compare", "--policies", "fronteir-nearest"], "unknown policy 'fronteir-nearest'; did you mean 'frontier-"),
        (["compare", "--policies", "random,random"], "the name 'random' appears twice"),
        (["compare", "--policies", "nowhere:Policy"], "no module named 'nowhere'"),
        (["compare", "--policies", "json:dumps"], "policy 'json:dumps'"),
        (["compare", "--policies", ","], "expected names separated by commas"),
        (["compare", "--scenario", "thesis-obstacle"], "did you mean 'thesis-obstacles'"),
        (["compare", "--scenario", "missing.toml"], "missing.toml: cannot be read: No such file"),
        (["compare", *OPEN, "--team", "0"], "expected a whole number of at least 1, got '0'"),
        (["compare", *OPEN, "--team", "300"], "team: Input should be less than or equal to 256"),
        (["compare", *OPEN, "--episodes", "many"], "expected a whole number of at least 1, got 'many'"),
        (["compare", *OPEN, "--resolution", "0.1"], "expected --maps with --resolution"),
        (["compare", *OPEN, "--set", "goal"], "expected key=value"),
        (["compare", *OPEN, "--set", "gaol=0.5"], "no setting 'gaol'; did you mean 'goal'"),
        (["compare", *OPEN, "--set", "goal=1.5"], "goal: Input should be less than or equal to 1"),
        (["compare", *OPEN, "--maps", "nowhere.yaml"], "nowhere.yaml"),
        (["compare", *OPEN, "--experiment", "nowhere.toml"], "nowhere.toml: cannot be read"),
        (
            ["compare", *OPEN, "--ratio-to", "randon"],
            "expected a policy that takes part to compare with, got 'randon'",
        ),
        (["compare", *OPEN, "--margin", "1.5"], "expected a share below 1 such as 0.05, or 0 for none, got '1.5'"),
        (["compare", *OPEN, "--speed", "9"], "unrecognized arguments: --speed 9"),
        (["report", "nowhere"], "expected a folder with a results.db"),
        (["check", "fronteir"], "unknown policy 'fronteir'; did you mean"),
        (["maps", "nowhere.png"], "nowhere.png"),
        (["compare", *OPEN, "--set", "radio.rnge=3"], "no setting 'radio.rnge'; did you mean 'radio.range'"),
        (["comapre"], "invalid choice: 'comapre'; did you mean 'compare'?"),
    ],
)
def test_a_usage_error_is_one_line_and_status_2(words, message, capsys, tmp_path):
    out = ["--out", tmp_path / "out"] if words[:1] in (["compare"], ["report"]) else []
    status, printed, errors = run(capsys, *words, *out)
    assert (status, printed) == (2, "")
    assert errors.count("\n") == 1
    assert message in errors
    assert not (tmp_path / "out" / "summary.csv").exists()


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("polices = ['random']", "unknown key 'polices'; did you mean 'policies'"),
        ("policies = 'random'", "expected policies to be a list"),
        ("policies = [{use = 'random', nmae = 'x'}]", "did you mean 'name'"),
        ("policies = [{use = 'random', parameters = {speed = 3}}]", "policy 'random' cannot be made"),
        ("episodes = 0", "episodes"),
        ("scenarios = []", "scenarios"),
        ("set = 3", "expected [set] to be a table"),
        ("seed = -1", "seed"),
        ("policies = [", "expected TOML"),
    ],
)
def test_a_bad_experiment_file_is_one_line(toml, message, capsys, tmp_path):
    (tmp_path / "plan.toml").write_text(toml)
    status, _, errors = run(capsys, "compare", "--experiment", tmp_path / "plan.toml", "--out", tmp_path / "out")
    assert (status, errors.count("\n")) == (2, 1)
    assert message in errors


def test_a_folder_of_another_experiment_is_refused_and_left_alone(capsys, tmp_path):
    words = ["compare", "--scenario", "thesis-open", "--episodes", "2", "--workers", "0"]
    run(capsys, *words, "--policies", "random", "--out", tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.suffix in {".csv", ".html"}}
    status, _, errors = run(capsys, *words, "--policies", "random", "--seed", "1", "--out", tmp_path)
    assert (status, errors.count("\n")) == (2, 1)
    assert "holds another experiment; what differs: seed (0 there, 1 here)" in errors
    assert {name: (tmp_path / name).read_bytes() for name in before} == before


def test_an_output_that_cannot_be_a_folder_is_refused(capsys, tmp_path):
    (tmp_path / "file").write_text("")
    status, _, errors = run(capsys, "compare", *OPEN, "--out", tmp_path / "file")
    assert (status, errors.count("\n")) == (2, 1)
    assert "choose another --out" in errors


def test_a_read_only_folder_is_refused(capsys, tmp_path, monkeypatch):
    tmp_path.chmod(0o555)
    if os.geteuid() == 0:  # root may write everywhere; ask as somebody else would be answered
        monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    status, _, errors = run(capsys, "compare", *OPEN, "--out", tmp_path)
    tmp_path.chmod(0o755)
    assert (status, errors.count("\n")) == (2, 1)
    assert "expected a folder that can be written, got a read-only one; choose another --out" in errors
    assert not list(tmp_path.iterdir())


def test_outputs_that_cannot_be_written_are_one_line(capsys, tmp_path):
    (tmp_path / "report.html").mkdir()
    status, _, errors = run(capsys, "compare", *OPEN, "--episodes", "1", "--workers", "0", "--out", tmp_path)
    assert (status, errors.count("\n")) == (1, 1)
    assert "report.html" in errors
    assert not list(tmp_path.glob(".*"))


def test_commas_in_parentheses_separate_no_names():
    nested = 'camera-paths(explorer="frontier(goal_bonus=1.0,switch_cost=2.0)")'
    assert read_names(f"{nested},pso") == [nested, "pso"]
    assert read_names('pso(length=1,goal_bonus=0.1), dddqn,"a, b(c, d)",x') == [
        "pso(length=1,goal_bonus=0.1)",
        "dddqn",
        "a, b(c, d)",
        "x",
    ]


@pytest.mark.slow
def test_the_demo_compares_and_films(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(demo, "EPISODES", 2)
    status, out, _ = run(capsys, "demo", "--out", tmp_path / "demo")
    assert status == 0
    assert {row["policy"] for row in summary(tmp_path / "demo")} == set(demo.POLICIES)
    with Image.open(tmp_path / "demo" / "demo.gif") as film:
        assert film.n_frames > 10
    table, _, rest = out.partition("T90, T99: mean steps")
    assert "frontier-utility" in table
    assert [line.rpartition(": ")[2] for line in rest.splitlines()[1:3]] == [
        str(tmp_path / "demo" / name) for name in ("report.html", "demo.gif")
    ]
    assert not any(word in out for word in ("relative to", "Bold", "can be detected"))
