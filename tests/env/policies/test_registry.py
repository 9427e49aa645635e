"""Names to policies: declared ones, openers of paths, modules and classes, and what else a colon could mean."""

import importlib.metadata
import sys
import types
from dataclasses import dataclass

import numpy as np
import pytest

from indoor_explorers.env import InputError, Pilot, Policy, make_policy
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.policies import registry
from indoor_explorers.env.policies.registry import opener_entry_points


class Idle(Pilot):
    def act(self, view):
        return 4


@dataclass(frozen=True, kw_only=True)
class Opened(Policy):
    """Do nothing, as a path says."""

    path: str
    bold: bool = False

    def pilot(self, briefing):
        return Idle()


@dataclass(frozen=True, kw_only=True)
class Named(Policy):
    """Do nothing."""

    def pilot(self, briefing):
        return Idle()


@dataclass(frozen=True, kw_only=True)
class Typed(Policy):
    """Do nothing, with parameters of every type."""

    bold: bool = False
    count: int = 1
    share: float = 0.5
    parts: int | None = None
    label: str = "a"

    def pilot(self, briefing):
        return Idle()


def idle(path=""):
    return Named()


HERE = "tests.env.policies.test_registry"


@pytest.fixture
def declare(monkeypatch):
    """Return what declares entry points of (group, name, value), and nothing else."""

    def declared(*entries):
        points = [importlib.metadata.EntryPoint(name, value, group) for group, name, value in entries]
        monkeypatch.setattr(registry, "entry_points", lambda group: [point for point in points if point.group == group])

    return declared


OPENER = (registry.OPENERS, "box", f"{HERE}:Opened")


@pytest.mark.parametrize("path", ["results/one", "/abs/one two", r"C:\results", "a:b:c", ".", "Opened"])
def test_what_follows_an_opener_s_name_is_its_path(path, declare):
    declare(OPENER)
    policy = make_policy(f"box:{path}", bold=True)
    assert (policy.path, policy.bold) == (path, True)


def test_module_and_class_go_on_working(declare):
    declare(OPENER)
    assert make_policy(f"{HERE}:Named") == make_policy(f"{HERE}:Named")
    assert make_policy(f"{HERE}:Opened", path="mine").path == "mine"


@pytest.mark.parametrize("name", ["subprocess:check_output", "subprocess:Popen", f"{HERE}:idle", f"{HERE}:HERE"])
def test_what_is_no_policy_is_not_called(name, tmp_path):
    told = tmp_path / "called"
    with pytest.raises(InputError, match=r"expected a subclass of .*, got the \w+ .*; nothing was called"):
        make_policy(name, args=["touch", str(told)])
    assert not told.exists()


def test_a_function_is_called_where_it_is_declared(declare):
    declare((registry.GROUP, "idle", f"{HERE}:idle"), (registry.OPENERS, "box", f"{HERE}:idle"))
    assert make_policy("idle") == Named()
    assert make_policy("box:there") == Named()


def test_before_a_colon_an_opener_goes_before_a_module_of_its_name(declare, monkeypatch):
    box = types.ModuleType("box")
    box.Named = Named
    monkeypatch.setitem(sys.modules, "box", box)
    declare()
    assert isinstance(make_policy("box:Named"), Named)
    declare(OPENER)
    assert make_policy("box:Named") == Opened(path="Named")


def test_a_policy_may_be_called_like_an_opener(declare):
    declare(OPENER, (registry.GROUP, "box", f"{HERE}:Named"))
    assert make_policy("box") == Named()
    assert make_policy("box:there") == Opened(path="there")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("box", "policy 'box': expected box:PATH, got no path"),
        ("box:", "policy 'box:': expected box:PATH, got no path"),
        ("bex", "unknown policy 'bex'; did you mean 'box'?"),
        (":there", "expected module:Class, got no full module name"),
        ("bex:there", "no module named 'bex'"),
    ],
)
def test_what_is_none_of_them_is_one_line(name, message, declare):
    declare(OPENER)
    with pytest.raises(InputError) as caught:
        make_policy(name)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_path_is_given_once(declare):
    declare(OPENER)
    with pytest.raises(InputError, match="multiple values for keyword argument 'path'"):
        make_policy("box:there", path="elsewhere")


@pytest.mark.parametrize("name", ["a.box", "a:box"])
def test_an_opener_cannot_be_called_like_a_path_of_modules(name, declare):
    declare((registry.OPENERS, name, f"{HERE}:Opened"))
    with pytest.raises(InputError, match="expected a name without a dot or colon"):
        make_policy("random")


def test_an_opener_declared_twice_is_refused(declare):
    declare(OPENER, (registry.OPENERS, "box", f"{HERE}:Named"))
    with pytest.raises(InputError, match="opener 'box' is declared twice"):
        make_policy("box:there")


def test_the_project_s_own_openers_are_declared():
    assert {"dddqn", "sb3", "rllib"} <= set(opener_entry_points())


@pytest.mark.parametrize(("module", "extra"), [("stable_baselines3", "sb3"), ("ray", "ray"), ("torch", "rl")])
def test_a_missing_library_is_told_with_its_extra(module, extra):
    error = ModuleNotFoundError(name=f"{module}.inner")
    assert registry.missing_module(error) == f"no module named '{module}.inner'; install indoor-explorers[{extra}]"
    assert "install" not in registry.missing_module(ModuleNotFoundError(name="thing"))


def test_a_parameter_that_a_policy_does_not_take_is_told_with_the_likely_one():
    with pytest.raises(InputError, match="'pso' cannot be made: unknown parameter 'lenght'; did you mean 'length'"):
        make_policy("pso", lenght=1)


class RaisesInItsMessage(Exception):
    def __str__(self):
        raise KeyError("no message")


class CannotBeMade(Named):
    def __init__(self):
        raise RaisesInItsMessage


def test_an_error_whose_message_raises_is_one_line():
    with pytest.raises(PolicyError, match=r"cannot be made: RaisesInItsMessage: its message raised KeyError$"):
        make_policy(f"{__name__}:CannotBeMade")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"bold": "false"}, "expected bold to be true or false, got 'false'"),
        ({"bold": 1}, "expected bold to be true or false, got 1"),
        ({"count": 2.5}, "expected count to be a whole number, got 2.5"),
        ({"count": True}, "expected count to be a whole number, got True"),
        ({"count": None}, "expected count to be a whole number, got None"),
        ({"share": "0.5"}, "expected share to be a number, got '0.5'"),
        ({"share": [1]}, r"expected share to be a number, got \[1\]"),
        ({"parts": 1.5}, "expected parts to be a whole number, got 1.5"),
    ],
)
def test_values_of_other_types_are_refused(given, told):
    with pytest.raises(InputError, match=f"policy '{HERE}:Typed': {told}"):
        make_policy(f"{HERE}:Typed", **given)


def test_numbers_of_every_library_are_numbers():
    made = make_policy(f"{HERE}:Typed", bold=True, count=np.int64(3), share=1, parts=None, label="b")
    assert (made.bold, made.count, made.share, made.parts, made.label) == (True, 3, 1, None, "b")
    assert make_policy(f"{HERE}:Typed", share=np.float32(0.25), parts=2).share == 0.25
