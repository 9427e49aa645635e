"""The search space: the parameters that are tuned, with their ranges, and what they are by default."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from indoor_explorers.env import InputError, make_policy
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.policies.registry import policy_class
from indoor_explorers.env.policies.tunable import Choices, Span, Tunable, read_tunable, tunable_parameters
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution

#: Significant digits of tuned numbers.
DIGITS = 4


@dataclasses.dataclass(frozen=True)
class SearchSpace:
    """The tuned parameters of a policy."""

    choice: PolicyChoice
    """The policy by default, with the parameters that stay as they are."""
    ranges: Mapping[str, Tunable]
    defaults: Mapping[str, Any]
    """The default of each tuned parameter."""

    @classmethod
    def of(cls, choice: PolicyChoice, asked: Sequence[tuple[str, Any]] = ()) -> SearchSpace:
        """Return the space of what the policy declares and of the ranges asked for, which take precedence.

        Raises:
            InputError: nothing is to be tuned, a name is unknown or fixed, or a range leaves out the default or has
                values that the policy refuses.

        """
        kind = policy_class(choice.use)
        defaults = _defaults(kind)
        for name, _ in asked:
            _refuse_name(choice, name, defaults)
        given = {name: read_tunable(declared, defaults[name], name) for name, declared in asked}
        ranges = {**tunable_parameters(kind), **given}
        ranges = {name: each for name, each in ranges.items() if name not in choice.parameters}
        if not ranges:
            raise InputError(_nothing(choice, defaults))
        space = cls(choice, ranges, {name: defaults[name] for name in ranges})
        space.refuse_invalid()
        return space

    def refuse_invalid(self) -> None:
        """Raise :class:`InputError` where a range lacks the default, or has ends that the policy refuses."""
        for name, each in self.ranges.items():
            if self.defaults[name] not in each:
                raise InputError(
                    f"expected a range of {name!r} with its default {self.defaults[name]!r} in it, got {each}; widen it"
                )
            for end in each if isinstance(each, Choices) else each[:2]:
                make_policy(self.choice.use, **{**self.choice.parameters, name: end})

    def distributions(self) -> dict[str, BaseDistribution]:
        """Return the ranges for Optuna."""
        return {name: _distribution(each) for name, each in self.ranges.items()}

    def with_parameters(self, name: str, drawn: Mapping[str, Any]) -> PolicyChoice:
        """Return the policy under a name with drawn parameters, rounded to some digits within their ranges."""
        rounded = {key: _rounded(value, self.ranges[key]) for key, value in drawn.items()}
        return self.choice.model_copy(update={"name": name, "parameters": {**self.choice.parameters, **rounded}})


def _defaults(kind: Any) -> dict[str, Any]:
    """Return the parameters of a policy's class that have a plain default."""
    fields: Iterable[dataclasses.Field[Any]] = dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()
    return {each.name: each.default for each in fields if isinstance(each.default, int | float | str)}


def _refuse_name(choice: PolicyChoice, name: str, known: Mapping[str, Any]) -> None:
    if name in choice.parameters:
        raise InputError(f"expected --range of a parameter that is free, got {name!r}, which {choice.name!r} fixes")
    if name not in known:
        raise InputError(f"policy {choice.use!r} has no parameter {name!r} to tune{did_you_mean(name, known)}")


def _nothing(choice: PolicyChoice, known: Mapping[str, Any]) -> str:
    free = [name for name in known if name not in choice.parameters]
    advice = f"; name some of {', '.join(free)} with --range name=low:high" if free else ""
    return f"policy {choice.name!r} declares no parameters to tune{advice}"


def _distribution(each: Tunable) -> BaseDistribution:
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if isinstance(each, Span):
        if each.whole:
            return IntDistribution(int(each.low), int(each.high), log=each.log)
        return FloatDistribution(each.low, each.high, log=each.log)
    return CategoricalDistribution(each)


def _rounded(value: Any, within: Tunable) -> Any:
    if not isinstance(within, Span) or within.whole:
        return value
    return min(max(float(f"{value:.{DIGITS}g}"), within.low), within.high)
