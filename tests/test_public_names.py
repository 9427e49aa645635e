"""Public names can be imported, wherever the code behind them has moved to."""

import importlib

import pytest

from indoor_explorers.evaluation.site.reference import public_modules

#: Former paths, which still provide their names.
FORMER = ("indoor_explorers.env.encoders", "indoor_explorers.env.sb3")


def test_public_modules_are_listed():
    folders = {name.split(".")[1] for name in public_modules()}
    assert folders == {"env", "planners", "evaluation"}


@pytest.mark.parametrize("name", [*public_modules(), *FORMER])
def test_every_public_name_is_there(name):
    module = importlib.import_module(name)
    missing = [each for each in module.__all__ if not hasattr(module, each)]
    assert missing == []
    assert set(module.__all__) <= set(dir(module))
