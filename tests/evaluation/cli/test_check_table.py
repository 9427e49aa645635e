"""What ``indoor-explorers check`` prints, for plug-ins that pass and for those that do not."""

import io
import re
from pathlib import Path

import pytest
from rich.console import Console

from indoor_explorers.env import PolicyError, run_checks
from indoor_explorers.env.conformance import CHECKS
from indoor_explorers.evaluation.cli.check_table import print_findings, print_header
from indoor_explorers.evaluation.cli.parser import main
from tests.env.conformance.policies import MOST_CHECKS
from tests.evaluation import plugins
from tests.evaluation.cli.test_cli import PLUGINS, run

GUIDE = Path(__file__).resolve().parents[3] / "evaluation" / "site" / "pages" / "guides" / "planner.md"


def test_a_policy_that_passes_gets_its_facts_a_row_for_each_check_and_status_0(capsys):
    status, printed, errors = run(capsys, "check", f"{PLUGINS}:Batched")
    assert (status, errors) == (0, "")
    assert re.search(r"policy +tests\.evaluation\.plugins:Batched *\n", printed)
    assert re.search(r"parameters +speed=1", printed)
    assert re.search(r"knows +its view and briefing alone", printed)
    for name in CHECKS:
        mark = "! warning" if name == "failure modes" else "ok"  # it wanders too slowly to finish
        assert re.search(rf"{mark} +{re.escape(name)}  ", printed), name
    assert f"{len(CHECKS)} of {len(CHECKS)} checks passed, 1 with a warning in " in printed


def test_all_checks_run_although_some_fail(capsys):
    status, printed, errors = run(capsys, "check", f"{PLUGINS}:Leaks")
    words = " ".join(printed.split())
    assert (status, errors) == (1, "")
    for row in ("FAILED +messages", "FAILED +same seed, same episode", "unknown +unlinked teammates"):
        assert re.search(f"{row}  ", printed), row
    assert re.search(r"ok +latency, large map  ", printed)
    assert "finite numbers, got [0.0]" in words
    assert "perhaps the ndarray Mind.calls" in words
    assert words.count("To fix: ") == words.count("FAILED")
    passed = len(CHECKS) - words.count("FAILED") - words.count("- unknown")
    assert f"{passed} of {len(CHECKS)} checks passed" in words


def test_what_cannot_be_run_says_so(capsys):
    status, printed, errors = run(capsys, "check", f"{PLUGINS}:Raises")
    words = " ".join(printed.split())
    assert (status, errors) == (1, "")
    assert "act raised RuntimeError: motor</script> failure To fix: see failing.py, line " in words
    assert words.count("not run: see decisions") == len(CHECKS) - 1
    assert f"0 of {len(CHECKS)} checks passed" in words


def test_parameters_are_written_as_for_compare(capsys, monkeypatch):
    made = []
    monkeypatch.setattr("indoor_explorers.env.run_checks", lambda policy: made.append(policy) or [])
    assert run(capsys, "check", "pso(particles=7)")[0] == 0
    assert made[0].particles == 7
    long = ",".join(f"{name}={value}" for name, value in {"particles": 7, "rounds": 30, "length": 3}.items())
    assert run(capsys, "check", f"pso({long},power={0.5:.60f})")[0] == 0
    status, printed, errors = run(capsys, "check", "pso(particles)")
    assert (status, printed) == (2, "")
    assert "expected parameters as in pso(length=1)" in errors


@pytest.mark.parametrize(
    ("target", "message"),
    [
        (f"{PLUGINS}:NeverMade", "cannot be made: RuntimeError: no weights"),
        ("tests.evaluation.broken_module:Policy", "importing tests.evaluation.broken_module raised RuntimeError: lic"),
    ],
)
def test_a_plugin_that_cannot_be_made_is_one_line_and_status_1(target, message, capsys):
    status, printed, errors = run(capsys, "check", target)
    assert (status, printed, errors.count("\n")) == (1, "", 1)
    assert message in errors


@pytest.mark.parametrize(
    ("target", "message"),
    [
        (":Policy", "expected module:Class"),
        ("", "unknown policy ''"),
        (f"{PLUGINS}:Nobody", "has no 'Nobody'"),
        (
            f"{PLUGINS}:Wanderer",
            f"expected a subclass of indoor_explorers.env.Policy, got the class {PLUGINS}:Wanderer",
        ),
        ("tests.evaluation.cli.test_cli:run", "got the function tests.evaluation.cli.test_cli:run"),
    ],
)
def test_a_target_that_is_no_policy_is_one_line_and_status_2(target, message, capsys):
    status, printed, errors = run(capsys, "check", target)
    assert (status, printed, errors.count("\n")) == (2, "", 1)
    assert message in errors


Dict = dict


def test_debugging_shows_where_it_was_raised(capsys, monkeypatch):
    monkeypatch.setenv("INDOOR_EXPLORERS_DEBUG", "1")
    with pytest.raises(PolicyError, match="motor") as caught:
        main(["check", f"{PLUGINS}:Raises"])
    assert isinstance(caught.value.__cause__, RuntimeError)
    assert "not run: see decisions" in capsys.readouterr().out


@pytest.fixture(scope="module")
def found():
    return list(run_checks(plugins.Leaks(), MOST_CHECKS))


@pytest.mark.parametrize("width", [60, 80, 120])
@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_the_page_fits_any_terminal(width, encoding, found):
    raw = io.BytesIO()
    console = Console(file=io.TextIOWrapper(raw, encoding), width=width)
    print_header(console, "leaks", plugins.Leaks())
    print_findings(console, found)
    console.file.flush()
    lines = raw.getvalue().decode(encoding).splitlines()
    assert max(map(len, lines)) <= width
    assert any(line.rstrip().endswith("same seed gave another episode") or "FAILED" in line for line in lines)


def test_the_page_in_the_documentation_has_today_s_checks():
    text = GUIDE.read_text()
    rows = re.findall(r"^ {6}\S (?:ok|FAILED|unknown|warning) +(.+?) {2}", text, re.MULTILINE)
    assert rows == list(CHECKS)
    assert re.findall(r"^\| \*\*(.+?)\*\* \|", text, re.MULTILINE) == list(CHECKS)
