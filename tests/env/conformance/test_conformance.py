"""The conformance suite finds what is wrong with a policy and says the likely cause."""

import ctypes
import random
import sys

import numpy as np
import pytest

from indoor_explorers.env import Pilot, Policy, PolicyError, World, check_policy, make_policy, run_checks
from indoor_explorers.env.conformance import CHECKS
from indoor_explorers.env.conformance.latency import latency_text
from tests.env.conformance.policies import MOST_CHECKS, Flying, Honest, Named, make
from tests.seeds import seed_of


def findings(kind, policy=Flying, names=MOST_CHECKS):
    """What the checks of some names find, by name."""
    return {finding.name: finding for finding in run_checks(make(kind, policy), names)}


def variant(kind, **attributes):
    """A subclass of a pilot or a policy with other attributes or methods."""
    return type(f"Other{kind.__name__}", (kind,), attributes)


def failures(found):
    return {name for name, finding in found.items() if not finding.passed}


def test_an_honest_policy_passes_and_gets_a_report():
    report = check_policy(make(Honest))
    assert list(report) == list(CHECKS)
    assert "8 changes" in report["no hidden knowledge"]
    assert "3 teammates replaced and 2 stopped" in report["unlinked teammates"]
    assert "at most 2 in one" in report["messages"]
    assert "one UAV, 16x16: median" in report["latency"]
    assert "share of a batch" not in report["latency, large map"]
    batched = findings(Honest, type("Batched", (Flying,), {"batched": True}))
    assert "each time a UAV's share of a batch" in batched["latency, large map"].text


class ReadsMapSettings(Honest):
    """Picks its way by what the scenario says about maps."""

    def act(self, view):
        crowded = getattr(self.briefing.scenario.map, "obstacles", 1) > 0
        moves = np.flatnonzero(view.legal)
        return int(moves[0 if crowded else -1])


class ReadsGenerator(Honest):
    def act(self, view):
        moves = np.flatnonzero(view.legal)
        return int(moves[self.briefing.generator.height % len(moves)])


class Declares(Flying):
    uses_generator = True


@pytest.mark.parametrize(
    ("kind", "message"), [(ReadsMapSettings, "chose differently at step 0"), (ReadsGenerator, "has no attribute")]
)
def test_a_policy_declares_that_it_reads_the_settings_of_the_maps_generator(kind, message):
    found = findings(kind)
    assert failures(found) == {"map generator"}
    assert message in found["map generator"].text
    assert "uses_generator = True" in found["map generator"].fix
    assert not failures(findings(kind, Declares))


def test_moves_into_walls_are_allowed_and_counted():
    bold = variant(Honest, act=lambda pilot, view: pilot.briefing.agent % 4)
    count = findings(bold)["actions"].text.split(", ")[1].split()[0]
    assert int(count) > 0


class Listens(Honest):
    """Follows what it hears, which is what messages are for."""

    def act(self, view):
        self.message = (float(view.cell[0]), float(self.briefing.agent))
        heard = sum(mate.cell[1] + sum(mate.message or ()) + mate.age for mate in view.mates)
        moves = np.flatnonzero(view.legal)
        return int(moves[int(heard) % len(moves)])


def test_what_is_heard_by_radio_may_change_what_is_done():
    assert not failures(findings(Listens))


class Returns(Honest):
    value: object = 4

    def act(self, view):
        return self.value


@pytest.mark.parametrize("value", [1.0, float("nan"), "left", None, True, 5, -1, np.ones(2), np.float64(3), [4]])
def test_a_wrong_action_is_refused(value):
    found = findings(variant(Returns, value=value), names=["decisions", "actions"])
    assert failures(found) == {"actions"}
    kind = "action" if value is None or type(value) is int else "int"
    assert f"expected an {kind} from 0 to 4 (down, left, up, right, stay), got " in found["actions"].text
    assert "return an int" in found["actions"].fix


class Says(Honest):
    said: object = None

    def act(self, view):
        self.message = self.said
        return 4


@pytest.mark.parametrize("said", [[1.0], tuple(range(17)), (float("nan"),), ("hello",), "hi", 3.0, (10**400,), (1j,)])
def test_a_wrong_message_is_refused(said):
    found = findings(variant(Says, said=said), names=["decisions", "messages"])
    assert failures(found) == {"messages"}
    assert "a tuple of at most 16 finite numbers, got " in found["messages"].text
    assert found["messages"].text.isprintable()


class Unprintable:
    def __repr__(self):
        raise RuntimeError("no")


def test_a_value_that_cannot_be_printed_is_named():
    found = findings(variant(Returns, value=Unprintable()))
    assert "got the Unprintable a Unprintable whose repr raises RuntimeError" in found["actions"].text


class Tallies(Honest):
    told: object = None

    def tally(self):
        return self.told


@pytest.mark.parametrize("told", [None, [1.0], {"x": "y"}, {1: 1.0}, {"x": float("inf")}])
def test_a_wrong_tally_is_refused(told):
    found = findings(variant(Tallies, told=told), names=["decisions", "tally"])
    assert failures(found) == {"tally"}
    assert "expected tally to return a dict of finite numbers" in found["tally"].text


@pytest.mark.parametrize(
    ("kind", "check"),
    [
        (variant(Returns, value=1.0), "actions"),
        pytest.param(variant(Says, said=(1.0, "hello")), "messages", marks=pytest.mark.slow),
        pytest.param(variant(Tallies, told=[1.0]), "tally", marks=pytest.mark.slow),
    ],
)
def test_a_wrong_answer_fails_one_check_and_the_others_go_on(kind, check):
    found = findings(kind, names=CHECKS)
    assert failures(found) == {check}
    assert found["failure modes"].warned


class RaisesOnLevels(Honest):
    def act(self, view):
        assert self.briefing.level_count == 1, "a plain map"
        return super().act(view)


def test_who_changes_levels_who_stays_and_who_raises_is_told_apart():
    texts = [findings(kind, names=["several levels"])["several levels"] for kind in (Honest, RaisesOnLevels)]
    assert texts[0].text.endswith("staying on the levels of their starts")
    assert not texts[0].warned
    assert texts[1].text.startswith("cannot fly maps of several levels: act raised AssertionError: a plain map")
    assert texts[1].warned
    assert "on 4 of 7 levels" in check_policy(make_policy("frontier-nearest"))["several levels"]


class TallyRaises(Honest):
    def tally(self):
        return {"x": 1 / 0}


def test_a_tally_that_raises_fails_one_check():
    found = findings(TallyRaises)
    assert failures(found) == {"tally"}
    assert found["tally"].text == "tally raised ZeroDivisionError: division by zero"
    assert found["tally"].fix.startswith("see test_conformance.py, line ")


class WritesView(Honest):
    def act(self, view):
        view.belief[0, 0] = 1
        return 4


class WritesUnderView(Honest):
    def act(self, view):
        ctypes.memset(view.belief.ctypes.data, 1, 1)  # no Python object lets anybody write there
        return 4


class Raises(Honest):
    def act(self, view):
        raise RuntimeError("motor\nfailure \x1b[31m")


class NeverMade(Honest):
    def __init__(self, briefing, policy):
        raise KeyError("weights")


class MessageRaises(Honest):
    @property
    def message(self):
        raise RuntimeError("radio")

    def act(self, view):
        return 4


class PrivilegeRaises(Flying):
    @property
    def privileged(self):
        raise RuntimeError("undecided")


@pytest.mark.parametrize(
    ("kind", "policy", "text", "fix"),
    [
        (WritesView, Flying, "act raised ValueError: assignment destination is read-only", "views are read-only, copy"),
        (WritesUnderView, Flying, "act changed the view it was given", "views are live, copy"),
        (Raises, Flying, "act raised RuntimeError: motor failure \\x1b[31m", "see test_conformance.py, line "),
        (variant(Honest, act=lambda *_: sys.exit(0)), Flying, "act raised SystemExit: 0", "in <lambda>"),
        (NeverMade, Flying, "policy.pilot raised KeyError: 'weights'", "in __init__"),
        (MessageRaises, Flying, "pilot.message raised RuntimeError: radio", "in message"),
        (
            Honest,
            variant(Flying, act=lambda _, pilots, views: [4] * (len(pilots) + 1)),
            "expected a list of 1 actions from act, got 2: [4, 4]",
            "one for each pilot",
        ),
        (
            Honest,
            variant(Flying, act=lambda *_: None),
            "expected a list of 1 actions from act, got None",
            "one for each pilot",
        ),
        (
            Honest,
            variant(Flying, pilot=lambda *_: "pilot"),
            "expected policy.pilot to return a Pilot, got 'pilot'",
            "subclass Pilot",
        ),
        (Honest, PrivilegeRaises, "policy.privileged raised RuntimeError: undecided", "in privileged"),
    ],
)
def test_a_policy_that_cannot_fly_is_told_why_once(kind, policy, text, fix):
    found = findings(kind, policy, CHECKS)
    assert found["decisions"].text == text
    assert fix in found["decisions"].fix
    later = [finding for finding in found.values() if finding.name not in {"decisions", "pickling"}]
    assert all(not finding.conclusive and finding.text == "not run: see decisions" for finding in later)
    with pytest.raises(PolicyError, match="; "):
        check_policy(make(kind, policy))


class OneSize(Honest):
    """As a network of fixed input size."""

    shape = (16, 16)

    def act(self, view):
        return super().act(view) if view.belief.shape == self.shape else self.briefing.missing


def test_a_policy_that_flies_maps_of_one_size_passes_all_it_can():
    found = findings(OneSize)
    assert failures(found) == {"latency, large map"}
    large = found["latency, large map"]
    assert (large.error, large.conclusive, large.fix) == (None, False, "")
    assert "cannot be told, as act raised AttributeError" in large.text
    assert "set its map_shape" in large.text
    assert list(check_policy(make(OneSize))) == list(CHECKS)


def test_a_policy_may_say_the_size_of_the_only_maps_it_flies():
    wide = type("Wide", (OneSize,), {"shape": (12, 20)})
    assert "decisions" in failures(findings(wide))
    said = type("Said", (Flying,), {"map_shape": (12, 20)})
    found = findings(wide, said)
    assert failures(found) == set()
    assert "one UAV, 12x20" in found["latency"].text
    assert "not timed" in found["latency, large map"].text
    assert "7 maps" in found["map of the seed"].text


class WritesBriefing(Honest):
    def act(self, view):
        object.__setattr__(self.briefing, "team", 9)
        return 4


class WritesScenario(Honest):
    def act(self, view):
        self.briefing.scenario.__dict__["budget"] = 9
        return 4


@pytest.mark.parametrize(("kind", "name"), [(WritesBriefing, "team"), (WritesScenario, "scenario")])
def test_a_changed_briefing_is_noticed(kind, name):
    found = findings(kind)
    assert failures(found) == {"decisions"}
    assert found["decisions"].text == f"the briefing's {name} was changed"


def choosing(choose):
    """A class of pilots with another way to choose among legal moves."""
    return variant(Honest, act=lambda pilot, view: int(choose(np.flatnonzero(view.legal[:4]))))


class CountsInPolicy(Honest):
    def act(self, view):
        self.policy.calls.append(view.step)
        return int(np.flatnonzero(view.legal)[len(self.policy.calls) // 7 % view.legal.sum()])


class Counting(Named):
    def __init__(self):
        self.calls = []


class ModuleDraws(Honest):
    generator = np.random.default_rng(1)

    def act(self, view):
        return int(self.generator.integers(5))


@pytest.mark.parametrize(
    ("kind", "policy", "fix"),
    [
        (choosing(lambda moves: np.random.default_rng().choice(moves)), Flying, "draw from briefing.rng only"),
        (choosing(random.choice), Flying, "the policy draws from the global random; draw from briefing.rng"),
        (choosing(np.random.choice), Flying, "the policy draws from the global numpy.random; draw from briefing.rng"),
        (CountsInPolicy, Counting, "perhaps the list calls of the policy"),
        (ModuleDraws, Flying, "perhaps the Generator ModuleDraws.generator"),
    ],
)
def test_an_episode_that_is_another_one_the_next_time(kind, policy, fix):
    found = findings(kind, policy)
    finding = found["same seed, same episode"]
    assert "the same seed gave another episode (first difference at step " in finding.text
    assert fix in finding.fix
    others = [other for other in found.values() if not other.passed and other is not finding]
    assert all(other.text == "cannot be told: see same seed, same episode" for other in others)
    assert "unlinked teammates" in {other.name for other in others}


class HoldsLambda(Flying):
    def __init__(self):
        self.choose = lambda moves: moves[0]

    __reduce__ = object.__reduce__


class Forgets(Named):
    goal = 4

    def __init__(self):
        self.goal = 0

    def __getstate__(self):
        return {}


class FliesGoal(Honest):
    def act(self, view):
        return self.policy.goal


class BecomesNone(Flying):
    def __reduce__(self):
        return (dict, ())


@pytest.mark.parametrize(
    ("kind", "policy", "text", "fix"),
    [
        (Honest, HoldsLambda, "the policy cannot be pickled", "keep lambdas, open files and locks out"),
        (FliesGoal, Forgets, "a pickled copy flew another episode", "everything that it needs"),
        (Honest, BecomesNone, "the policy came back from pickling as {}", "__reduce__"),
    ],
)
def test_a_policy_that_does_not_survive_pickling(kind, policy, text, fix):
    found = findings(kind, policy)
    assert failures(found) == {"pickling"}
    assert text in found["pickling"].text
    assert fix in found["pickling"].fix


class Pools(Honest):
    """Pilots post their cells on a board and read the last step's; which pilots share one is ``key``'s business."""

    boards: dict[object, object] = {}  # noqa: RUF012 - the fault under test

    def key(self):
        return ()

    def __init__(self, briefing, policy):
        super().__init__(briefing, policy)
        flight = id(briefing.scenario)
        _, self.board = self.boards.setdefault((flight, *self.key()), (briefing.scenario, {}))

    def act(self, view):
        self.board.setdefault(view.step, []).append(view.cell)
        moves = np.flatnonzero(view.legal)
        return int(moves[sum(map(sum, self.board.get(view.step - 1, ()))) % len(moves)])


class PoolsByEpisode(Pools):
    """The same, but each episode has a board of its own."""

    def key(self):
        return (seed_of(self.briefing),)


def test_pilots_that_share_across_episodes_are_caught():
    found = findings(Pools)
    assert failures(found) == {"pilots share nothing", "unlinked teammates"}
    assert "pilots share state (first difference at step 1)" in found["pilots share nothing"].text
    assert "perhaps the dict Pools.boards" in found["pilots share nothing"].fix


def test_pilots_that_share_within_an_episode_are_caught_when_a_mate_out_of_contact_acts_otherwise():
    found = findings(PoolsByEpisode)
    assert failures(found) == {"unlinked teammates"}
    finding = found["unlinked teammates"]
    assert "chose differently at step 2 when only UAV 0 acted differently" in finding.text
    assert "seen and heard nothing (radio none)" in finding.text
    assert "share nothing but messages" in finding.fix
    assert "perhaps the dict Pools.boards" in finding.fix


class Peeks(Flying):
    """Lets every choice depend on all views of the batch."""

    def act(self, pilots, views):
        total = sum(sum(view.cell) for view in views)
        return [int(np.flatnonzero(view.legal)[total % view.legal.sum()]) for view in views]


class Places(Flying):
    """Lets every choice depend on the place in the batch."""

    def act(self, pilots, views):
        return [int(np.flatnonzero(view.legal)[place % view.legal.sum()]) for place, view in enumerate(views)]


@pytest.mark.parametrize(
    ("policy", "check"),
    [(Peeks, "pilots share nothing"), (Peeks, "unlinked teammates"), (Places, "order of the batch")],
)
def test_a_batched_act_that_mixes_its_views_is_caught(policy, check):
    finding = findings(Honest, policy)[check]
    assert not finding.passed
    assert "batch" in finding.fix


class Omniscient(Honest):
    """Chooses by the number of walls of the true map."""

    def act(self, view):
        return int((self.briefing.truth == 2).sum() % 5)


def test_a_policy_that_knows_the_truth_is_caught(monkeypatch):
    briefing = World.briefing
    monkeypatch.setattr(World, "briefing", lambda self, b, n, privileged: briefing(self, b, n, privileged=True))
    with pytest.raises(PolicyError, match="only cells that no UAV had seen were changed; use the view"):
        check_policy(make(Omniscient))


def test_a_privileged_policy_may_know_it():
    found = findings(Omniscient, type("Yardstick", (Flying,), {"privileged": True}))
    assert not failures(found)
    assert found["no hidden knowledge"].text == "not checked: the policy is privileged and knows the true map"


def test_latency_is_said_in_its_units_and_growth_is_told():
    even = latency_text([20e-6] * 99 + [7e-3])
    assert even == "median 20 us, p99 90 us, slowest 7.0 ms; 1.0 % over 5 ms"
    assert latency_text([1e-3]) == "median 1.0 ms, p99 1.0 ms, slowest 1.0 ms; none over 5 ms"
    growing = latency_text([n * 10e-6 for n in range(1, 101)])
    assert growing.endswith("gets slower: median 130 us in the first quarter, 880 us in the last")


def test_a_pilot_class_can_be_anything_that_flies():
    class Minimal(Policy):
        def pilot(self, briefing):
            return Stays()

    assert failures({finding.name: finding for finding in run_checks(Minimal())}) == {"pickling"}


class Stays(Pilot):
    def act(self, view):
        return 4


class WrongArguments(Flying):
    def pilot(self):
        return None


class RaisesInLibrary(Honest):
    def act(self, view):
        return np.stack([])


def test_the_place_that_is_named_is_the_plugins_own():
    found = findings(RaisesInLibrary)["decisions"]
    assert found.text == "act raised ValueError: need at least one array to stack"
    assert found.fix.startswith("see test_conformance.py, line ")
    found = findings(Honest, WrongArguments)["decisions"]
    assert "policy.pilot raised TypeError" in found.text
    assert found.fix == "give it the arguments that indoor_explorers.env.Policy and Pilot have"
