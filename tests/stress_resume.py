"""Kill a comparison again and again, and see that nothing is lost, nothing is flown twice, and the result is the same.

Not a test of the suite, as it takes minutes: python -P tests/stress_resume.py --kills 50
"""

import argparse
import contextlib
import os
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from indoor_explorers.evaluation.harness.results.store import Store

ROOT = Path(__file__).resolve().parents[1]
POLICIES = ("tests.evaluation.plugins:Slower", "random", "tests.evaluation.plugins:Slow", "frontier-nearest")
KINDS = ("driver SIGKILL", "worker SIGKILL", "driver SIGINT")
COMMAND = "import sys; from indoor_explorers.evaluation.cli.parser import main; sys.exit(main())"


def start(out: Path, episodes: int) -> subprocess.Popen[str]:
    """Start or resume the comparison as a user does."""
    words = ["compare", "--policies", ",".join(POLICIES), "--scenario", "thesis-team-2", "--set", "budget=200"]
    words += ["--episodes", str(episodes), "--workers", "2", "--out", str(out)]
    return subprocess.Popen(
        [sys.executable, "-P", "-c", COMMAND, *words],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def workers_of(driver: int) -> list[int]:
    """Return the worker processes of a driver."""
    found = []
    for task in Path(f"/proc/{driver}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            for child in map(int, task.read_text().split()):
                if b"LokyProcess" in Path(f"/proc/{child}/cmdline").read_bytes():
                    found.append(child)
    return found


def kill(running: subprocess.Popen[str], kind: str, rng: np.random.Generator) -> bool:
    """Kill what ``kind`` says; tells whether there was anything to kill."""
    victim, number = running.pid, signal.SIGINT if kind.endswith("SIGINT") else signal.SIGKILL
    with contextlib.suppress(OSError):
        if kind.startswith("worker"):
            workers = workers_of(running.pid)
            if not workers:
                return False
            victim = int(rng.choice(workers))
        if running.poll() is None:
            os.kill(victim, number)
            return True
    return False


def held(out: Path) -> dict[tuple[object, ...], tuple[object, ...]]:
    """Check the store and return what it holds: the run and the flight of each episode by its key."""
    path = out / "results.db"
    if not path.exists():
        return {}
    with contextlib.closing(sqlite3.connect(path)) as db:
        assert db.execute("PRAGMA integrity_check").fetchone() == ("ok",), "the store is damaged"
        if not db.execute("SELECT 1 FROM sqlite_master WHERE name = 'episode'").fetchone():
            return {}
        runs = {
            tuple(key): run for *key, run in db.execute("SELECT policy, scenario, map_index, seed, run FROM episode")
        }
    with Store(path) as store:
        return {
            (record.policy, *record.task): (runs[record.policy, *record.task], record.outcome, record.actions.tobytes())
            for record in store.records()
        }


def stored(out: Path) -> int:
    """Return how many episodes there are now."""
    try:
        with contextlib.closing(sqlite3.connect(f"file:{out / 'results.db'}?mode=ro", uri=True)) as db:
            return int(db.execute("SELECT count(*) FROM episode").fetchone()[0])
    except sqlite3.OperationalError:  # not there yet
        return 0


def rows(out: Path) -> list[str]:
    """Return summary.csv without what measures the machine."""
    return [line for line in (out / "summary.csv").read_text().splitlines() if ",latency_" not in line]


def finish(out: Path, episodes: int) -> str:
    """Run the comparison to its end and return what it said."""
    running = start(out, episodes)
    _, errors = running.communicate(timeout=900)
    assert running.returncode == 0, (running.returncode, errors)
    return errors


def strike(out: Path, episodes: int, kind: str, rng: np.random.Generator) -> bool:
    """Start the comparison, and kill what ``kind`` says at a random moment; tells whether there was anything to kill.

    One moment in five is any, one is while workers start or fly, the others are after new episodes were stored.
    """
    before, running = stored(out), start(out, episodes)
    moment = rng.choice(["any", "workers", "stored"], p=[0.2, 0.2, 0.6])
    until = time.monotonic() + 30
    while running.poll() is None and time.monotonic() < until:
        if moment == "any" or (workers_of(running.pid) if moment == "workers" else stored(out) > before):
            break
        time.sleep(0.02)
    time.sleep(float(rng.uniform(0.0, 1.5 if moment == "stored" else 6.0)))
    hit = kill(running, kind, rng)
    if hit and kind.startswith("worker"):
        time.sleep(float(rng.uniform(0.0, 8.0)))  # let the driver notice, or not
    if running.poll() is None and not kind.endswith("SIGINT"):
        running.kill()
    _, errors = running.communicate(timeout=200)
    of_python = kind.endswith("SIGINT") and errors.rstrip(": \n").endswith("KeyboardInterrupt")
    assert of_python or "Traceback" not in errors, errors  # Python's own, while it starts or in its callbacks
    return hit


def stress(folder: Path, kills: int, episodes: int, seed: int) -> Counter[str]:
    """Kill ``kills`` times; return how often each kind of kill struck."""
    rng = np.random.default_rng(seed)
    finish(folder / "whole", episodes)
    struck: Counter[str] = Counter()
    out = folder / "killed-0"
    while struck.total() < kills:
        before = held(out)
        if len(before) == len(POLICIES) * episodes:
            out, before = folder / f"killed-{len(list(folder.glob('killed-*')))}", {}
        kind = KINDS[int(rng.integers(len(KINDS)))]
        struck[kind] += strike(out, episodes, kind, rng)
        after = held(out)
        changed = [key for key in before if after.get(key) != before[key]]
        assert not changed, f"episodes were lost or flown twice: {changed[:3]}"
        sys.stdout.write(f"{struck.total():3d} {kind:15s} {len(before):4d} -> {len(after):4d} episodes\n")
        sys.stdout.flush()
    for out in sorted(folder.glob("killed-*")):
        check_finished(out, folder / "whole", episodes)
    return struck


def check_finished(out: Path, whole: Path, episodes: int) -> None:
    """Run a comparison that was killed to its end, and compare it with the undisturbed one."""
    before = held(out)
    finish(out, episodes)
    after = held(out)
    assert len(after) == len(POLICIES) * episodes, "episodes are missing"
    assert all(after[key] == before[key] for key in before), "finished episodes were flown again"
    assert rows(out) == rows(whole), f"{out.name}: the summary differs"


def main() -> None:
    """Read the arguments, kill, and print what happened."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=50, metavar="N")
    parser.add_argument("--episodes", type=int, default=50, metavar="N", help="of each of four policies")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="makes moments and victims")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        struck = stress(Path(folder), arguments.kills, arguments.episodes, arguments.seed)
    for kind, count in sorted(struck.items()):
        sys.stdout.write(f"{kind:15s} {count:4d}\n")
    sys.stdout.write("every summary is that of the undisturbed run\n")


if __name__ == "__main__":
    main()
