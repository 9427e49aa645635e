"""Invalid settings of a scenario are refused in one line that names the setting."""

import pytest

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.scenarios.validation import validated


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"noise": {"misses": 0.5}}, "noise.misses: .*less than 0.5.*got 0.5"),
        ({"noise": {"misses": -0.1}}, "noise.misses: .*greater than or equal to 0.*got -0.1"),
        ({"noise": {"false_returns": 0.7}}, "noise.false_returns: .*less than 0.5.*got 0.7"),
        ({"noise": {"range_std": 11}}, "noise.range_std: .*less than or equal to 10.*got 11"),
        ({"noise": {"range_std": float("nan")}}, "noise.range_std: .*got nan"),
        ({"noise": {"range_std": "wide"}}, "noise.range_std: .*got 'wide'"),
        ({"noise": {"mises": 0.1}}, r"unknown key 'noise\.mises'; did you mean 'misses'"),
        ({"drift": {"rate": 0.6}}, "drift.rate: .*less than or equal to 0.5.*got 0.6"),
        ({"drift": {"closures": 1.5}}, "drift.closures: .*less than or equal to 1.*got 1.5"),
        ({"drift": {"closure_gap": 0}}, "drift.closure_gap: .*greater than or equal to 1.*got 0"),
        ({"drift": {"mates": "sometimes"}}, "drift.mates: .*got 'sometimes'"),
        ({"lidar": {"field_of_view": 20}}, "lidar.field_of_view: .*greater than or equal to 30.*got 20"),
        ({"lidar": {"field_of_view": 400}}, "lidar.field_of_view: .*less than or equal to 360.*got 400"),
        ({"team": 2, "failures": {"stops": ((2, 5),)}}, "list each once, from 0 to 1"),
        ({"team": 2, "failures": {"stops": ((1, 5), (1, 9))}}, "list each once"),
        ({"team": 2, "failures": {"stops": ((1, 0),)}}, "steps count from 1"),
        ({"failures": {"hazard": 1.0}}, "less than 1"),
        ({"prior": {"kind": "old"}}, "prior.kind"),
        ({"prior": {"doors": 1.5}}, "prior.doors"),
        ({"prior": {"shift": -0.1}}, "prior.shift"),
        ({"base": {"must_return": True}}, "base.must_return needs a base"),
        ({"base": {"at": "home"}}, "base.at"),
        ({"map": {"source": "rooms", "height": 4}}, "map.height: Input should be greater than or equal to 5, got 4"),
        ({"map": {"source": "maze", "width": 2049}}, "map.width: Input should be less than or equal to 2048, got 2049"),
        ({"map": {"source": "rooms", "room_size": [9, 4]}}, r"room_size is \[9, 4\], expected 1 <= smallest <= larg"),
        ({"map": {"source": "rooms", "corridor": 6}}, "are 1, 6 and 5, expected each at most the next"),
        (
            {"map": {"source": "rooms", "room_size": [30, 40], "height": 31}},
            r"height is 31, expected at least 32 \(the smallest",
        ),
        ({"map": {"source": "maze", "corridor": 9, "width": 10}}, "width is 10, expected at least 11 .* enlarge it"),
        ({"map": {"source": "offices", "height": 11}}, "height is 11, expected at least 12 .*a row of rooms"),
        ({"map": {"source": "offices", "door": [0, 1]}}, r"door is \[0, 1\]"),
        ({"map": {"source": "cave", "rock": 0.9}}, "less than or equal to 0.6"),
        ({"map": {"source": "cave", "smoothnig": 3}}, "did you mean 'smoothing'"),
        ({"map": {"source": "caves"}}, "'cave'"),
        (
            {"map": {"source": "floors", "area": [900.0, 300.0]}},
            r"area is \[900.0, 300.0\], expected 0 < smallest <= l",
        ),
        ({"map": {"source": "floors", "area": [0.0, 300.0]}}, r"area is \[0.0, 300.0\]"),
        (
            {"map": {"source": "floors", "height": 20}},
            "map.height: Input should be greater than or equal to 32, got 20",
        ),
        ({"map": {"source": "floors", "resolution": 3.0}}, "less than or equal to 2, got 3.0"),
        ({"map": {"source": "floors", "rotated": 0.5}}, "map.rotated"),
        ({"map": {"source": "thesis", "rows": 3}}, "expected both or neither"),
        ({"map": {"source": "thesis", "noise": 2}}, "noise is 2 without a lattice"),
        ({"map": {"source": "thesis", "obstacle_size": (3, 2)}}, "expected 1 <= smallest <= largest"),
    ],
)
def test_an_invalid_setting_is_refused(table, message):
    with pytest.raises(InputError, match=message) as caught:
        validated(Scenario, table, "scenario")
    assert "\n" not in str(caught.value)
