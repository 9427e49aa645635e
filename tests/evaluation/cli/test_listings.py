"""Lists of what there is: every name whole, in every window, and aliases told."""

import re
import tomllib
from dataclasses import dataclass, field

import pytest

from indoor_explorers.env import PRESETS, Scenario, policy_names
from indoor_explorers.env.policies.registry import policy_entry_points
from indoor_explorers.env.scenarios.suites.catalogue import suites
from indoor_explorers.evaluation.cli.commands import listings
from indoor_explorers.evaluation.cli.parameters import policy_parameters
from indoor_explorers.evaluation.cli.parser import main


@pytest.mark.parametrize("columns", [40, 80, 120, 200])
def test_scenarios_are_never_cut(columns, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("TTY_COMPATIBLE", "1")  # as in a terminal of that width
    assert main(["scenarios"]) == 0
    printed = capsys.readouterr().out
    lines = [line.split() for line in re.sub(r"\x1b\[[0-9;]*m", "", printed).splitlines()]
    assert [line[0] for line in lines[1 : 1 + len(PRESETS)]] == list(PRESETS)
    assert "\N{HORIZONTAL ELLIPSIS}" not in printed
    assert ("A wider window shows" in printed) == (columns < 120)


def test_a_pipe_gets_every_column(capsys):
    assert main(["scenarios"]) == 0
    printed = capsys.readouterr().out
    assert all(heading in printed.splitlines()[0] for heading in listings.HEADINGS)
    (line,) = [line for line in printed.splitlines() if line.startswith("thesis-team-2 ")]
    assert line.split() == ["thesis-team-2", "16x16", "2", "3", "square", "3", "400", "90%", "of", "map"] + [
        *("oscillation", "-0.5,", "+1,", "+400")
    ]


def test_sizes_are_those_of_the_maps():
    for preset in PRESETS.values():
        levels = preset.map.floorplan(0, 0).levels
        size = (levels.height, levels.width, levels.number)
        assert listings._size(preset.map) == (size if levels.number > 1 else size[:2])


def test_policies_are_listed_with_their_aliases_and_without_markup(capsys):
    assert main(["policies"]) == 0
    printed = capsys.readouterr().out
    lines = {line.split()[0]: line for line in printed.splitlines() if line.strip()}
    assert set(policy_names()) <= set(lines)
    assert "`" not in printed
    assert "alias of frontier-joint" in lines["frontier"]
    assert "alias of rrt-aep" in lines["rrt"]
    aliases = [name for name in policy_names() if "alias of" in lines[name]]
    assert len({entry.value for entry in policy_entry_points().values()}) == len(policy_names()) - len(aliases)


def test_suites_are_listed_with_their_parts(capsys):
    assert main(["suites"]) == 0
    printed = capsys.readouterr().out
    assert [line.split()[0] for line in printed.splitlines() if " / " in line][1:] == list(suites())
    assert re.search(r"floors +1 +36 / 17 / 36 +amrl_maps", printed)
    assert re.search(r"buildings +1 +0 / 0 / \d+ +\d+ repositories", printed)


def test_a_suite_is_explained_with_the_commands_that_fetch_its_maps(capsys, tmp_path):
    (tmp_path / "GDC3").mkdir()
    (tmp_path / "GDC3" / "GDC3.vectormap.json").write_text("[]")
    assert main(["suites", "floors", "rooms", "--data", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"test +36 +26 +2 +504 +32,000,000 to 32,000,001", printed)
    assert "Data: https://github.com/ut-amrl/amrl_maps, 1 of 17 maps found below --data; licence: BSD" in printed
    assert "  git clone https://github.com/ut-amrl/amrl_maps && git -C amrl_maps checkout 38db3f2b17f7313aa" in printed
    assert "Data: none, the maps are generated." in printed
    assert main(["suites", "flors"]) == 2


def test_a_policy_is_explained_with_its_parameters(capsys):
    assert main(["policies", "pso", "random"]) == 0
    printed = capsys.readouterr().out
    assert "Assign several goals to each UAV" in printed
    assert re.search(r"^ ?particles +20 +Particles of the swarm, including the four", printed, re.MULTILINE)
    assert "\nrandom\n" in printed
    assert ":class:" not in printed
    assert main(["policies", "pos"]) == 2
    assert "did you mean 'pso'" in capsys.readouterr().err


def test_a_scenario_is_printed_as_toml_that_can_be_flown(capsys):
    assert main(["scenarios", "thesis-team-4"]) == 0
    assert Scenario.model_validate(tomllib.loads(capsys.readouterr().out)) == PRESETS["thesis-team-4"]


def test_learners_are_listed_and_explained_with_nested_settings_and_presets(capsys):
    assert main(["learners"]) == 0
    printed = capsys.readouterr().out
    assert {"dddqn", "dddqn-thesis", "sb3-ppo", "rllib-sac"} <= {line.split()[0] for line in printed.splitlines()}
    assert main(["learners", "dddqn"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"^ ?observation\.tours +\S+ +\w", printed, re.MULTILINE)
    assert "Presets for --preset: thesis-open" in printed
    assert main(["learners", "dqn"]) == 2


def test_parameters_of_any_kind_of_class_are_found():
    class Given:
        def __init__(self, path, steps=3):
            self.path = path

    @dataclass(frozen=True)
    class Base:
        rate: float = 0.5
        """How fast, see :class:`~a.b.Place`."""

    @dataclass(frozen=True)
    class Own(Base):
        names: tuple[str, ...] = field(default_factory=tuple)
        start: int = 0
        """The ``first``."""

    assert policy_parameters(Given) == [("path", "", ""), ("steps", "3", "")]
    assert policy_parameters(Own) == [
        ("rate", "0.5", "How fast, see Place."),
        ("names", "()", ""),
        ("start", "0", "The first."),
    ]
