"""Settings of harder tasks, with which the checks of other libraries must pass as well."""

SWITCHES = {
    "stops": {"failures.hazard": 0.05, "failures.reward": -5.0},
    "last word": {"failures.hazard": 0.05, "failures.last_word": True},
    "radios": {"failures.radio_hazard": 0.1, "failures.radio_outage": 4},
    "base": {"base.at": "start"},
    "prior": {"prior.kind": "outdated"},
    "return": {"base.at": (8, 8), "base.must_return": True, "map.obstacles": 0},
}
