"""Help, version and errors come before anything heavy is imported."""

import os
import shutil
import signal
import subprocess
import sys

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation import cli
from indoor_explorers.evaluation.cli.commands import COMMANDS
from indoor_explorers.evaluation.cli.parser import build_parser, main

HEAVY = {"numba", "scipy", "pandas", "matplotlib", "plotly", "pyarrow", "jinja2", "rich", "torch", "ompl", "ray", "PIL"}


@pytest.mark.parametrize(
    ("words", "status"),
    [
        ([], 0),
        (["--help"], 0),
        (["--version"], 0),
        (["compare", "--help"], 0),
        (["comapre"], 2),
        (["compare", "--polices", "random", "--out", "x"], 2),
    ],
)
def test_help_and_usage_errors_import_nothing_heavy(words, status, tmp_path):
    code = (
        "import sys\n"
        "from indoor_explorers.evaluation.cli import main\n"
        "assert 'numpy' not in sys.modules\n"
        "try: status = main(sys.argv[1:])\n"
        "except SystemExit as end: status = end.code\n"
        f"print(status, *sorted({HEAVY!r} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, cwd=tmp_path)
    assert done.stderr.splitlines()[-1] == str(status)


def test_ctrl_c_while_modules_load_is_one_line(monkeypatch, capfd):
    class Interrupting:
        def find_spec(self, name, path=None, target=None):
            signal.raise_signal(signal.SIGINT)

    def leave(status):
        raise SystemExit(status)

    monkeypatch.delitem(sys.modules, "indoor_explorers.evaluation.cli.parser")
    monkeypatch.setattr(sys, "meta_path", [Interrupting()])
    monkeypatch.setattr(os, "_exit", leave)
    handler = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit, match="130"):
        cli.main(["--help"])
    assert signal.getsignal(signal.SIGINT) is handler
    assert capfd.readouterr().err == "indoor-explorers: interrupted; nothing was done\n"


def test_a_removed_folder_is_no_reason_to_fail(tmp_path, monkeypatch, capsys):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "gone").rmdir()
    with pytest.raises(SystemExit, match="0"):
        main([])
    assert "usage: " in capsys.readouterr().out


def test_without_a_word_there_is_help(capsys):
    with pytest.raises(SystemExit, match="0"):
        main([])
    printed = capsys.readouterr().out
    assert all(command.about.split()[0] in printed for command in COMMANDS)


def test_every_command_has_help_for_every_option(capsys):
    for command in COMMANDS:
        with pytest.raises(SystemExit, match="0"):
            build_parser().parse_args([command.name, "--help"])
        printed = " ".join(capsys.readouterr().out.split())
        for field in command.load().options.model_fields.values():
            assert field.description is not None
            assert " ".join(field.description.split())[:40] in printed


def test_help_comes_before_anything_slow_is_imported():
    code = """
import sys
from indoor_explorers.evaluation.cli import main
try:
    main(["--help"])
finally:
    print({"numpy", "pydantic", "gymnasium"} & set(sys.modules))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "set()"


def test_a_command_loads_its_own_options_alone():
    code = """
import sys
from indoor_explorers.evaluation.cli.parser import main
main(["suites"])
print(sorted(name.rpartition(".")[2] for name in sys.modules if ".cli.commands." in name))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "['suites']"


def test_the_likely_option_is_named():
    for words, likely in (
        (["compare", "--polices", "x", "--out", "y"], "did you mean --policies"),
        (["compare", "--polices=x", "--out", "y"], "did you mean --policies"),
        (["report", "a", "--out", "b", "--replay-count", "3"], "did you mean --replays"),
    ):
        with pytest.raises(InputError, match=f"unrecognized arguments: --.*{likely}.*see indoor-explorers {words[0]}"):
            build_parser().parse_args(words)


def test_settings_may_be_given_several_times():
    given = build_parser().parse_args(["compare", "--set", "goal=0.5", "team=2", "--set", "a.b=word", "--out", "x"])
    assert given.settings == [("goal", 0.5), ("team", 2), ("a.b", "word")]


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_a_script_completes_commands_and_options(shell, capsys):
    with pytest.raises(SystemExit) as ended:
        build_parser().parse_args(["--print-completion", shell])
    script = capsys.readouterr().out
    assert not ended.value.code
    assert all(word in script for word in ("leaderboard", "ratio-to"))


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_completes_a_command(capsys):
    with pytest.raises(SystemExit):
        build_parser().parse_args(["--print-completion", "bash"])
    script = capsys.readouterr().out + "COMP_WORDS=(indoor-explorers lead); COMP_CWORD=1; _shtab_indoor_explorers\n"
    done = subprocess.run(["bash", "-c", script + 'echo "${COMPREPLY[@]}"'], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["leaderboard"]
