"""Public names can be imported, wherever the code behind them has moved to."""

import importlib

import pytest

MODULES = (
    "env",
    "env.observations",
    "env.rendering",
    "env.interfaces",
    "env.encoders",
    "env.sb3",
    "planners",
    "evaluation",
)


@pytest.mark.parametrize("name", MODULES)
def test_every_public_name_is_there(name):
    module = importlib.import_module(f"indoor_explorers.{name}")
    missing = [each for each in module.__all__ if not hasattr(module, each)]
    assert missing == []
    assert set(module.__all__) <= set(dir(module))
