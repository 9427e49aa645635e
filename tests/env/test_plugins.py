"""Plug-ins are found by declared names and by module:attribute."""

from importlib.metadata import EntryPoint

import pytest

from indoor_explorers.env import InputError, plugins, scenario
from indoor_explorers.env.plugins import MAPS, declared, is_own, load_plugin, source_hash
from tests.env import plugins as given


@pytest.fixture
def pillars(monkeypatch):
    """Declare the generator of tests under a name."""
    entry = EntryPoint("pillars", f"{given.__name__}:Pillars", MAPS)
    monkeypatch.setattr(plugins, "entry_points", lambda group: [entry] if group == MAPS else [])
    declared.cache_clear()
    yield
    declared.cache_clear()


@pytest.mark.usefixtures("pillars")
def test_a_declared_name_stays_in_the_scenario():
    task = scenario("thesis-open").with_settings({"map.source": "pillars", "map.every": 5})
    assert task.map.every == 5
    assert task.map.source == "pillars"
    assert '"pillars"' in task.to_toml()
    with pytest.raises(InputError, match="did you mean 'pillars'"):
        load_plugin(MAPS, "pilars", "map generator")


def test_what_a_module_raises_is_told(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "raises_in_a_test.py").write_text("1 / 0\n")
    with pytest.raises(InputError, match="importing raises_in_a_test raised ZeroDivisionError"):
        load_plugin(MAPS, "raises_in_a_test:Maps", "map generator")


def test_sources_are_told_apart():
    assert source_hash(given.Pillars) == source_hash(given.exact) != source_hash(test_sources_are_told_apart)
    assert source_hash(3) == source_hash(len) == ""
    assert is_own(load_plugin)
    assert not is_own(given.Pillars)
