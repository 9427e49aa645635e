"""The facts that results store about a policy."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from collections.abc import Mapping
from typing import Annotated, Any, cast

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from indoor_explorers.env import InputError, Policy
from indoor_explorers.env.errors import one_line
from indoor_explorers.env.policies.renamed import renamed_parameters
from indoor_explorers.env.scenarios.seed_sets import SeedUse
from indoor_explorers.env.scenarios.suites.catalogue import digests_of
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.harness.experiment.sources import outside_files

#: Facts that no provenance may name, besides those that identify a policy.
DERIVED = (
    *("defaults", "hash", "uses_generator", "batched", "failed_check", "isolated", "seen_seeds", "seen_maps"),
    *("plans_for", "flown_again", "map_shape", "renamed"),
)
#: Characters of what a policy says it plans for.
LONGEST_AIM = 80
#: Characters of any other text among the facts, and of all facts together.
LONGEST_FACT, LONGEST_FACTS = 100_000, 10_000_000
#: Characters that no fact has: they move the cursor, colour or reverse text, or are not valid UTF-8.
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def _plain(text: str) -> str:
    if _CONTROL.search(text):
        raise ValueError("expected no control characters")
    return text


Text = Annotated[str, Field(max_length=LONGEST_FACT), AfterValidator(_plain)]
Seeds = Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=2, max_length=2)]


class _Facts(BaseModel):
    """The types of the facts; facts with other names are texts that a policy declares about itself."""

    model_config = ConfigDict(strict=True, extra="allow")
    __pydantic_extra__: dict[Text, Text]
    use: Text
    kind: Text = Field(alias="class")
    privileged: bool
    parameters: dict[Text, Text]
    sources: dict[Text, Text]
    defaults: dict[Text, Text]
    hash: Annotated[str, Field(pattern="^[0-9a-f]{16}$")]
    uses_generator: bool
    batched: bool
    plans_for: Annotated[Text, Field(max_length=LONGEST_AIM)] = ""
    seen_seeds: dict[Text, list[Seeds]] = {}
    seen_maps: dict[Text, list[Text]] = {}
    renamed: dict[Text, list[Text]] = {}
    map_shape: Annotated[list[Annotated[int, Field(gt=0)]], Field(min_length=2, max_length=2)] | None = None


def checked_facts(received: object, use: str) -> dict[str, Any]:
    """Return facts that a policy's process sent, if they are valid.

    Raises:
        InputError: they are not, or are those of another policy than ``use``.

    """
    try:
        facts = validated(_Facts, cast(dict[str, Any], received), "the facts of a policy")
    except InputError as error:
        raise InputError(one_line(str(error))) from error
    assert isinstance(received, dict)
    if facts.use != use or len(json.dumps(received)) > LONGEST_FACTS:
        raise InputError(f"expected facts of {use!r} of at most {LONGEST_FACTS} characters, got others or more")
    return received


def policy_facts(policy: Policy, use: str) -> dict[str, Any]:
    """Return the facts that results store about a policy: class, parameters, weights, sources, flags, and a hash.

    Raises:
        InputError: its flags or its provenance are invalid.

    """
    parameters: dict[str, Any] = dataclasses.asdict(policy) if dataclasses.is_dataclass(policy) else {}
    facts: dict[str, Any] = {
        "use": use,
        "class": f"{type(policy).__module__}:{type(policy).__qualname__}",
        "privileged": _flag(policy, "privileged"),
        "parameters": {name: repr(value) for name, value in parameters.items()},
    }
    taken = (*facts, "sources", *DERIVED)
    facts |= _provenance(policy, taken)
    digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]
    facts |= {"sources": outside_files(policy, use), "defaults": _defaults(policy)}
    facts |= {"hash": digest, "uses_generator": _flag(policy, "uses_generator"), "batched": _flag(policy, "batched")}
    more: dict[str, Any] = {"plans_for": _plans_for(policy), "seen_seeds": _seen_seeds(policy)}
    more |= {"seen_maps": _seen_maps(policy), "map_shape": _map_shape(policy), "renamed": _renamed(policy)}
    return checked_facts(facts | {name: value for name, value in more.items() if value}, use)


def with_chosen_on(facts: Mapping[str, Any], choice: PolicyChoice) -> dict[str, Any]:
    """Return the facts of a policy with the seeds and maps that the parameters of a choice of it were chosen on.

    Raises:
        InputError: it names a part that no suite has.

    """
    seeds = {str(use): [list(ends) for ends in each] for use, each in (choice.seen_seeds or {}).items()}
    maps = {
        str(use): [digest for name in names for digest in digests_of(name)]
        for use, names in (choice.seen_maps or {}).items()
    }
    seen: dict[str, dict[str, list[Any]]] = {"seen_seeds": {**seeds}, "seen_maps": {**maps}}
    return {**facts, **{key: _joined(facts.get(key, {}), found) for key, found in seen.items() if found}}


def _joined(one: Mapping[str, list[Any]], other: Mapping[str, list[Any]]) -> dict[str, list[Any]]:
    return {use: [*one.get(use, ()), *other.get(use, ())] for use in dict.fromkeys((*one, *other))}


def _map_shape(policy: Policy) -> list[int] | None:
    """Return the (H, W) of the only maps that a policy flies, None for any."""
    shape = policy.map_shape
    if shape is None:
        return None
    if not isinstance(shape, (tuple, list)) or len(shape) != 2 or not all(type(size) is int for size in shape):
        got = one_line(repr(shape), LONGEST_AIM)
        raise InputError(f"{type(policy).__name__}: expected map_shape to be two ints or None, got {got}")
    return list(shape)


def _plans_for(policy: Policy) -> str:
    text = policy.plans_for
    if not isinstance(text, str) or len(text) > LONGEST_AIM or not text.isprintable():
        raise InputError(
            f"{type(policy).__name__}: expected plans_for to be a line of at most {LONGEST_AIM} characters, "
            f"such as 'all cells', got {type(text).__name__}"
        )
    return text


def _seen_seeds(policy: Policy) -> dict[str, list[list[int]]]:
    """Return the first and the last of each range of seeds that a policy declares, by use."""
    given = _by_use(policy, "seen_seeds", policy.seen_seeds(), range, "ranges")
    return {use: spans for use, ranges in given.items() if (spans := [[r[0], r[-1]] for r in ranges if r])}


def _by_use(policy: Policy, method: str, given: object, kind: type, kinds: str) -> dict[str, list[Any]]:
    """Return the lists by use that a method of a policy returned, if they are such lists."""
    what = f"{type(policy).__name__}: expected {method}() to return lists of {kinds} by use"
    if not isinstance(given, Mapping):
        raise InputError(f"{what}, got {type(given).__name__}")
    for use, entries in given.items():
        if use not in list(SeedUse) or isinstance(entries, str) or not all(isinstance(each, kind) for each in entries):
            raise InputError(f"{what} ({', '.join(SeedUse)}), got other uses or no lists of {kinds}")
    return {str(use): list(entries) for use, entries in given.items()}


def _seen_maps(policy: Policy) -> dict[str, list[str]]:
    """Return the digests of the maps that a policy declares, by use; parts of suites are spelt out."""
    given = _by_use(policy, "seen_maps", policy.seen_maps(), str, "texts")
    spelt = {use: [digest for name in names for digest in digests_of(name)] for use, names in given.items()}
    return {use: list(dict.fromkeys(digests)) for use, digests in spelt.items() if digests}


def _defaults(policy: Policy) -> dict[str, str]:
    """Return the parameters' defaults, so that stores from before a parameter was added are known to be the same."""
    found: dict[str, Any] = {}
    for each in _fields(policy):
        if each.default is not dataclasses.MISSING:
            found[each.name] = each.default
        elif each.default_factory is not dataclasses.MISSING:
            found[each.name] = each.default_factory()
    records = {name for name, value in found.items() if dataclasses.is_dataclass(value) and not isinstance(value, type)}
    return {name: repr(dataclasses.asdict(value) if name in records else value) for name, value in found.items()}


def _fields(policy: Policy) -> tuple[dataclasses.Field[Any], ...]:
    return dataclasses.fields(policy) if dataclasses.is_dataclass(policy) else ()


def _renamed(policy: Policy) -> dict[str, list[str]]:
    """Return the present names of parameters by old ones, dotted in a parameter that is an object of parameters."""
    found = {old: list(names) for old, names in renamed_parameters(type(policy)).items()}
    for each in _fields(policy):
        inside = renamed_parameters(type(getattr(policy, each.name, None)))
        found |= {f"{each.name}.{old}": [f"{each.name}.{name}" for name in names] for old, names in inside.items()}
    return found


def _flag(policy: Policy, name: str) -> bool:
    value = getattr(policy, name)
    if not isinstance(value, bool):
        raise InputError(f"{type(policy).__name__}: expected {name} to be True or False, got {value!r}")
    return value


def _provenance(policy: Policy, taken: tuple[str, ...]) -> dict[str, str]:
    """Return what a policy declares about itself: texts by names that are not ``taken``, all valid UTF-8."""
    given, what = policy.provenance(), f"{type(policy).__name__}: expected provenance() to return"
    if not isinstance(given, dict):
        raise InputError(f"{what} a dict, got {type(given).__name__}")
    for name, text in given.items():
        if not isinstance(name, str) or not isinstance(text, str):
            raise InputError(f"{what} texts by name, got {name!r}: {text!r}")
        if name in taken:
            raise InputError(f"{what} names of its own, got {name!r}, which every policy has")
        if (name + text).encode("utf-8", "ignore").decode() != name + text:
            raise InputError(f"{what} valid UTF-8, got {name!r}: {text!r}")
    return given
