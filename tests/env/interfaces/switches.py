"""Settings of harder tasks, with which the checks of other libraries must pass as well."""

SWITCHES = {
    "stops": {"failures.hazard": 0.05, "failures.reward": -5.0},
    "last word": {"failures.hazard": 0.05, "failures.last_word": True},
    "radios": {"failures.radio_hazard": 0.1, "failures.radio_outage": 4},
    "base": {"base.at": "start"},
    "prior": {"prior.kind": "outdated"},
    "noise": {"noise.misses": 0.05, "noise.false_returns": 0.01, "noise.range_std": 0.5},
    "drift": {"drift.rate": 0.1},
    "field of view": {"lidar.field_of_view": 90.0},
    "return": {"base.at": (8, 8), "base.must_return": True, "map.obstacles": 0},
}
