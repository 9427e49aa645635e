"""A policy from outside the package is met in a process of its own: nothing it does there reaches the command."""

import re
import sys
import textwrap
from types import SimpleNamespace

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.scenarios.suites.catalogue import digests_of
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.engines.loading import PolicyLoader
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.results.policy_version import version_difference
from tests.evaluation.harness.engines.limits import LIMITS, PATIENT, SECONDS
from tests.evaluation.plugins import Wander

BEGIN = """
import ctypes, os, sys, time
from dataclasses import dataclass
from indoor_explorers.env import Policy

class Terrible(Exception):
    def __str__(self):
        raise RuntimeError("no words")

class Sits(Policy):
    def pilot(self, briefing):
        return None
"""


def met(tmp_path, monkeypatch, code, name="Plug", limits=LIMITS):
    """Load a plug-in whose code begins with :data:`BEGIN`."""
    module = f"met_{abs(hash(code))}"
    (tmp_path / f"{module}.py").write_text(BEGIN + textwrap.dedent(code))
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    with PolicyLoader(limits) as loader:
        facts = loader.facts([PolicyChoice(use=f"{module}:{name}", name="plug")])
    assert module not in sys.modules
    return facts["plug"]


def plug(body):
    return "class Plug(Sits):\n" + textwrap.indent(textwrap.dedent(body), "    ")


#: Cases that end much as others do, each of which costs a process.
ALIKE = (
    *("breaks off at import", "kills its process at import", "hangs in its constructor", "raises when asked"),
    *("exits at import", "raises in its constructor", "raises when asked what it knows"),
)
OVERDUE = f"importing and making it took longer than {SECONDS:g} s (--decision-timeout)"
CASES = {
    "exits at import": ("sys.exit(0)", "SystemExit: 0"),
    "ends its process at import": ("os._exit(0)", "the process of the policy ended with exit code 0"),
    "hangs at import": ("while True: pass", OVERDUE),
    "breaks off at import": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
    "kills its process at import": ("ctypes.string_at(0)", "killed by signal 11 (SIGSEGV)"),
    "raises what cannot be told": ("raise Terrible", "Terrible: its message raised RuntimeError"),
    "raises in Latin-1 and colours": ("raise ValueError('\\x1b[31m' + '\\udcff' + 'x' * 10**6)", r"\x1b[31m\udcffxxx"),
    "misses a module": ("import nowhere_at_all", "no module named 'nowhere_at_all'"),
    "hangs in its constructor": (plug("def __init__(self): time.sleep(1000)"), OVERDUE),
    "raises in its constructor": (plug("def __init__(self): raise MemoryError('big')"), "MemoryError: big"),
    "raises when asked what it knows": (plug("@property\ndef privileged(self): 1 / 0"), "ZeroDivisionError"),
    "raises when asked": (plug("def provenance(self): raise Terrible"), "Terrible: its message raised RuntimeError"),
    "cannot be shown": (
        "class Odd:\n    def __repr__(self): raise OSError('odd')\n"
        "@dataclass(frozen=True)\n" + plug("odd: object = Odd()\ndef __hash__(self): return 1"),
        "OSError: odd",
    ),
}


BY_USE = "expected {}() to return lists of {} by use"
AIM = "expected plans_for to be a line of at most 80 characters"


@pytest.mark.parametrize(
    ("name", "answer", "message"),
    [
        ("provenance", None, "expected provenance() to return a dict, got NoneType"),
        ("provenance", ["a"], "expected provenance() to return a dict, got list"),
        ("provenance", {"a": b"b"}, "expected provenance() to return texts by name, got 'a': b'b'"),
        ("provenance", {1: "b"}, "expected provenance() to return texts by name, got 1: 'b'"),
        ("provenance", {"a": "\ud800"}, r"expected provenance() to return valid UTF-8, got 'a': '\ud800'"),
        ("provenance", {"privileged": "no"}, "names of its own, got 'privileged', which every policy has"),
        *(
            ("seen_seeds", answer, BY_USE.format("seen_seeds", "ranges"))
            for answer in (None, {"training": [3]}, {"fun": [range(3)]}, {3: [range(3)]})
        ),
        *(
            ("seen_maps", answer, BY_USE.format("seen_maps", "texts"))
            for answer in (None, {"training": [3]}, {"fun": ["a"]}, {"training": "floors/train"})
        ),
        ("seen_maps", {"training": ["rooms/train"]}, "expected a part of a suite of map files, "),
        *(("plans_for", aim, AIM) for aim in (None, 0.9, "x" * 81, "two\nlines")),
        ("map_shape", 12, "expected map_shape to be two ints or None, got 12"),
        ("batched", "often", "expected batched to be True or False, got 'often'"),
    ],
)
def test_what_a_policy_declares_about_itself_is_checked(name, answer, message):
    declared = (lambda self: answer) if callable(getattr(Wander, name)) else answer
    with pytest.raises(InputError, match=re.escape(message)):
        policy_facts(type("Odd", (Wander,), {name: declared})(), "odd")


def test_seeds_that_a_policy_has_seen_are_facts_that_make_no_other_version_of_it():
    about = {"seen_seeds": lambda self: {"training": [range(3, 9), range(0)], "tuning": []}}
    facts = policy_facts(type("Wander", (Wander,), about)(), "wander")
    assert facts["seen_seeds"] == {"training": [[3, 8]]}
    plain = policy_facts(type("Wander", (Wander,), {})(), "wander")
    assert "seen_seeds" not in plain
    assert facts["hash"] == plain["hash"]
    assert not version_difference(plain, facts)


def test_maps_that_a_policy_has_seen_are_facts_and_parts_of_suites_are_spelt_out():
    about = {"seen_maps": lambda self: {"training": ["floors/train", "0123"], "tuning": []}}
    facts = policy_facts(type("Wander", (Wander,), about)(), "wander")
    assert list(facts["seen_maps"]) == ["training"]
    assert facts["seen_maps"]["training"] == [*digests_of("floors/train"), "0123"]
    plain = policy_facts(type("Wander", (Wander,), {})(), "wander")
    assert "seen_maps" not in plain
    assert not version_difference(plain, facts)


def test_the_size_of_the_only_maps_that_a_policy_flies_is_a_fact_that_makes_no_other_version_of_it():
    facts = policy_facts(type("Wander", (Wander,), {"map_shape": (12, 14)})(), "wander")
    assert facts["map_shape"] == [12, 14]
    assert not version_difference(policy_facts(type("Wander", (Wander,), {})(), "wander"), facts)


@pytest.mark.parametrize("case", [pytest.param(case, marks=[pytest.mark.slow] * (case in ALIKE)) for case in CASES])
def test_what_a_plug_in_does_when_it_is_loaded_is_told_in_a_line(case, tmp_path, monkeypatch):
    code, message = CASES[case]
    with pytest.raises(InputError) as raised:
        met(tmp_path, monkeypatch, code)
    line = str(raised.value)
    assert message in line
    assert line.startswith("policy 'plug'") or "policy 'met_" in line
    assert line.isprintable()
    assert len(line) < 1000


@pytest.fixture(scope="module")
def told():
    """The facts of an honest policy."""
    return policy_facts(Wander(), "plug:Plug")


@pytest.mark.parametrize(
    "forged",
    [
        *({"parameters": [1]}, {"seen_maps": 5}, {"note": "\ud800"}, {"note": "\x1b[31m"}, {"note": 3}, {"a\x07": "b"}),
        *({"privileged": 1}, {"use": "reference"}, {"note": "x" * 10**6}, {"seen_seeds": {"training": [[1]]}}),
        {str(number): "x" * 99_999 for number in range(101)},
    ],
)
def test_forged_facts_are_refused_in_a_line(forged, told, monkeypatch):
    for answer in ({"facts": told | forged}, {"facts": list(told)}, [], {"refused": ["a"]}):
        monkeypatch.setattr(PolicyLoader, "process", lambda *_, answer=answer: SimpleNamespace(ask=lambda *_: answer))
        with PolicyLoader(LIMITS) as loader, pytest.raises(InputError, match="policy 'plug': ") as raised:
            loader.facts([PolicyChoice(use="plug:Plug", name="plug")])
        assert str(raised.value).isprintable()
        assert len(str(raised.value)) < 1000


def test_the_line_names_the_place_in_the_plug_ins_code(tmp_path, monkeypatch):
    number = BEGIN.count("\n") + 2
    with pytest.raises(InputError, match=rf"ValueError: wrong \(met_\d+.py:{number} in <module>\)"):
        met(tmp_path, monkeypatch, "\nraise ValueError('wrong')")


def test_a_plug_in_that_is_never_deleted_holds_nobody_up(tmp_path, monkeypatch):
    code = plug("def __del__(self): time.sleep(1000)\ndef provenance(self): return {'a': 'é'}")
    facts = met(tmp_path, monkeypatch, code, limits=PATIENT)
    assert facts["a"] == "é"
    assert facts["privileged"] is False
    assert len(facts["sources"]) == 1


def test_nothing_is_flown_and_the_status_is_2(tmp_path, monkeypatch, capsys):
    (tmp_path / "leaves.py").write_text("import sys; sys.exit(0)")
    monkeypatch.chdir(tmp_path)
    words = ["compare", "--policies", "leaves:Plug,random", "--episodes", "1", "--out", "out", "--workers", "1"]
    assert main(words) == 2
    assert capsys.readouterr().err == (
        "indoor-explorers: policy 'leaves:Plug': importing leaves raised SystemExit: 0 (leaves.py:1 in <module>)\n"
    )
    assert not (tmp_path / "out").exists()
