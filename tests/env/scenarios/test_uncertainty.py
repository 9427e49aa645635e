"""Settings added later, above all errors of sensors and poses: fingerprints, and forbidden combinations."""

import json
from pathlib import Path

import pytest

from indoor_explorers.env import PRESETS, InputError, Scenario, load_scenario, scenario
from tests.env import plugins

#: Each setting, and whether it alone makes maps uncertain.
CHANGES = {
    "noise.misses": (0.1, True),
    "noise.false_returns": (0.01, True),
    "noise.range_std": (0.5, True),
    "drift.rate": (0.02, True),
    "drift.closures": (0.5, False),
    "drift.closure_gap": (7, False),
    "drift.mates": (False, False),
    "lidar.field_of_view": (90.0, True),
    "failures.hazard": (0.1, False),
    "prior.kind": ("outdated", False),
    "base.at": ("start", False),
}
#: Of the presets that there were before these settings came.
FINGERPRINTS = json.loads((Path(__file__).parent / "fingerprints.json").read_text())


@pytest.mark.parametrize("name", FINGERPRINTS)
def test_settings_that_were_not_there_leave_fingerprints_alone(name):
    assert PRESETS[name].fingerprint == FINGERPRINTS[name]


@pytest.mark.parametrize("setting", CHANGES)
def test_each_setting_is_part_of_the_task(setting):
    value, uncertain = CHANGES[setting]
    plain = scenario("thesis-team-2")
    changed = plain.with_settings({setting: value})
    assert changed.uncertain is uncertain
    assert changed.fingerprint != plain.fingerprint
    part, name = setting.split(".")
    default = getattr(getattr(plain, part), name)
    assert changed.with_settings({setting: default}).fingerprint == plain.fingerprint
    assert not plain.uncertain


def test_no_two_settings_have_one_fingerprint():
    changed = [Scenario().with_settings({key: value}).fingerprint for key, (value, _) in CHANGES.items()]
    assert len({*changed, Scenario().fingerprint}) == len(CHANGES) + 1


def test_all_settings_are_printed_and_read_back(tmp_path):
    task = scenario("thesis-team-2").with_settings({key: value for key, (value, _) in CHANGES.items()})
    (tmp_path / "task.toml").write_text(task.to_toml())
    again = load_scenario(tmp_path / "task.toml")
    assert again == task
    assert again.fingerprint == task.fingerprint


def test_a_limited_field_of_view_brings_the_sixth_action():
    assert (Scenario().turns, Scenario().actions) == (False, 5)
    limited = Scenario().with_settings({"lidar.field_of_view": 359.0})
    assert (limited.turns, limited.actions) == (True, 6)
    assert Scenario().with_settings({"noise.misses": 0.1, "drift.rate": 0.1}).actions == 5


@pytest.mark.parametrize("plugin", [{"lidar.model": "exact"}, {"radio.model": "disc"}], ids=["lidar", "radio"])
@pytest.mark.parametrize("setting", [key for key, (_, uncertain) in CHANGES.items() if uncertain])
def test_plug_in_sensors_are_refused_where_there_are_errors(setting, plugin):
    own = {key: f"{plugins.__name__}:{name}" for key, name in plugin.items()}
    assert not scenario("thesis-team-2").with_settings(own).uncertain
    with pytest.raises(InputError, match=r"need a lidar and a radio model of this package, got .*plugins:") as caught:
        scenario("thesis-team-2").with_settings({**own, setting: CHANGES[setting][0]})
    assert "\n" not in str(caught.value)
